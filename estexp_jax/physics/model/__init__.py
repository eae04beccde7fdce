"""The robot: MJCF files, validation, names and indices, derived constants, collision pairs, scales."""

from estexp_jax.physics import quiet_mjx  # noqa: F401 (before any module of this folder imports MJX)
