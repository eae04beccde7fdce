"""Ways to simulate populations."""

from estexp_jax.physics import quiet_mjx  # noqa: F401 (before any module of this folder imports MJX)
