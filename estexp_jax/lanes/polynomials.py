"""Springs and dampers beyond the first degree, as MuJoCo 4 has them.

A damper of coefficients (b, c, d) gives -(b + c |w| + d w^2) w, a spring of (k, l, m) -(k x + l x^2 + m x^3) of its
stretch x. What is beyond b and k is added here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp


class HigherOrder(NamedTuple):
    """Terms beyond the first degree: a force, and minus its derivative by the speed or the extension."""

    force: Any
    slope: Any


def damper(square: Any, cube: Any, speed: Any) -> HigherOrder:
    """A damper's, of coefficients `square`, of |w| w, and `cube`, of w^3; arrays of one shape."""
    bare, power = jnp.abs(speed), speed * speed
    return HigherOrder(-(square * bare + cube * power) * speed, 2.0 * square * bare + 3.0 * cube * power)


def spring(square: Any, cube: Any, stretch: Any) -> HigherOrder:
    """A spring's, of coefficients `square` and `cube`; arrays of one shape."""
    return HigherOrder(-(square + cube * stretch) * stretch * stretch, (2.0 * square + 3.0 * cube * stretch) * stretch)
