"""Lanes: populations of robots stepped with the population as the last axis of every array.

The one place where code is not written for one robot and batched outside: with the batch last, each elementwise
operation runs over contiguous robots, and XLA makes vector code of it. Solves the same convex problem as MuJoCo.
"""
