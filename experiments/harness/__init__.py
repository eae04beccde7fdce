"""What the experiments of `recover` share: their runs, one folder each, and how they are counted and drawn."""

from estexp_jax.runs import quiet_xla

quiet_xla()  # the modules of this folder load JAX; afterwards it would be too late
