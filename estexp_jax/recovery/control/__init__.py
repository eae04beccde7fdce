"""Controllers: the recurrent network of the paper, and trials of it."""
