"""What tests need of the versions at hand: `tests/versions.sh` runs them with the oldest and the newest."""

import pytest

from estexp_jax.physics.model.actuators import HAS_DECLARED_INPUTS

needs_mujoco_4 = pytest.mark.skipif(
    not HAS_DECLARED_INPUTS, reason="MuJoCo before 4 has no such motors, no batch, and writes six digits"
)
