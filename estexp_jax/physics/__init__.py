"""Robots, effects and engines: everything that is simulated."""
