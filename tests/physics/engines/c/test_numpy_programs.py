"""Laws as NumPy lines give what JAX gives, for any number of instances."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.engines.c.numpy_operations import ANY_LENGTH
from estexp_jax.physics.engines.c.numpy_programs import NumpyProgram, instances_shape


def _mixed(p: Any, x: Any) -> list[Any]:
    a, b = p
    q, w = x
    near = jnp.where(jnp.abs(q) < a, jnp.sin(b * q), jnp.sign(w) * jnp.exp(-jnp.square(w)))
    near, clipped = jnp.unstack(jnp.stack([near, jnp.clip(q, -a, a)]))
    both = jnp.stack([near, clipped])
    return [jnp.sum(both * x, axis=0), jnp.zeros_like(q), (q > w) & (a > 0.5), jnp.full_like(q, 2.0) ** 3 - q**2]


def _constants_alone(p: Any, x: Any) -> list[Any]:
    a, b = p
    return [jnp.sqrt(a) * b, jnp.max(x * jnp.stack([a, b]), axis=0)]


def _looping(p: Any, x: Any) -> list[Any]:
    return [jax.lax.fori_loop(0, 3, lambda _, y: y * p[0] + x[1], x[0])]


@pytest.mark.parametrize("function", [_mixed, _constants_alone, _looping])
@pytest.mark.parametrize("n", [1, 5, 40])
def test_a_program_gives_what_jax_gives(function: Callable[[Any, Any], list[Any]], n: int) -> None:
    one = instances_shape(ANY_LENGTH)
    program = NumpyProgram(function, (one, one), instances_shape(2, ANY_LENGTH))
    assert (program._compiled is not None) == (function is _looping)
    rng = np.random.default_rng(n)
    p, x = tuple(rng.uniform(0.1, 1.0, (2, n))), rng.normal(size=(2, n))
    with jax.enable_x64(True):
        expected = [np.asarray(y) for y in jax.jit(function)(p, x)]
    run = program.bound(p, n)
    for inputs in (x, x + 0.0):  # bound once, called often
        for found, right in zip(run(inputs), expected, strict=True):
            np.testing.assert_allclose(np.broadcast_to(found, n), right, rtol=1e-12, atol=1e-12)
