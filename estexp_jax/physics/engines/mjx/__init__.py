"""Simulation on MJX: the reference for any MJCF that MJX takes, one robot batched by `vmap`."""
