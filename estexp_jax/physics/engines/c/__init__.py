"""Simulation with MuJoCo's C engine on all cores."""
