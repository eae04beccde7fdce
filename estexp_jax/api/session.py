"""What has to be set before a command computes anything."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from estexp_jax.runs import quiet_xla


@contextmanager
def command_session() -> Iterator[None]:
    """Keep XLA and MuJoCo from writing to the terminal. Enter it before anything imports JAX."""
    quiet_xla()
    from estexp_jax.physics.model.validation import mujoco_warnings_suppressed

    with mujoco_warnings_suppressed():
        yield
