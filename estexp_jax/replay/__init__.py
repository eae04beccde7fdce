"""Commands replayed through a robot whose changes are known: the explained simulator, and recordings made with it."""
