"""Search algorithms: the genetic algorithm of the paper and set search, by ask and tell, and sparse regression."""
