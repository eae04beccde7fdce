"""Effects: ways in which a robot may differ from its simulator. Loading this folder registers all of the package's."""

from estexp_jax.physics import quiet_mjx  # noqa: F401, I001 (before any module of this folder imports MJX)
from estexp_jax.physics.effects import catalogue  # noqa: F401
from estexp_jax.physics.effects.laws import library  # noqa: F401
