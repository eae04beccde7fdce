"""Simulation on the batch-last engine `estexp_jax.lanes`: effects, controllers and sensor faults put on it."""
