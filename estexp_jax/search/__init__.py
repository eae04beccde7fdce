"""Search algorithms with an ask/tell interface: the genetic algorithm of the paper, and set search."""
