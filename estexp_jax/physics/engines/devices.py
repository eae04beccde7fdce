"""Settings that differ where JAX computes on an accelerator."""

from __future__ import annotations

import jax

_MOST = 102_400
"""Robots in a chunk there: many more are no faster together."""


def accelerated() -> bool:
    """Whether JAX computes on something else than the CPU."""
    return jax.default_backend() != "cpu"


def device() -> str:
    """Device that JAX computes on, as it names it: `cpu`, or a GPU's model."""
    return jax.devices()[0].device_kind


def wide(population: int, multiple: int) -> int:
    """Robots in a chunk on an accelerator, which simulates hundreds in the time of one: half the population at once.

    Args:
        population: robots simulated at once, or twice as many as are new each time.
        multiple: of which the width must be one.
    """
    return -(-min(-(-population // 2), _MOST) // multiple) * multiple


def exact_products() -> None:
    """Have matrix products computed in full single precision, unless the user has chosen otherwise.

    GPUs round their factors to ten bits of mantissa by default: MJX's velocities after a control step of the quadruped
    were then 2e-4 off (median, H100), instead of 2e-7. On CPUs nothing changes.
    """
    chosen = jax.config.jax_default_matmul_precision  # pyright: ignore[reportAttributeAccessIssue] (made at run time)
    if accelerated() and chosen is None:
        jax.config.update("jax_default_matmul_precision", "highest")
