"""The estimation-exploration algorithm of Bongard and Lipson (2004)."""
