"""Bad input of every kind the program reads, and what it makes of it."""
