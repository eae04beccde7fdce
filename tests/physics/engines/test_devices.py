"""On an accelerator chunks are wide and matrix products exact; on the CPU neither changes."""

import jax
import pytest

from estexp_jax.physics.engines.devices import exact_products
from estexp_jax.physics.engines.lanes.closed_loop import lanes_width
from estexp_jax.physics.engines.mjx.closed_loop import mjx_width


def _precision():
    return jax.config.jax_default_matmul_precision  # pyright: ignore[reportAttributeAccessIssue] (made at run time)


@pytest.fixture
def precision():
    """JAX's own setting, put back afterwards."""
    before = _precision()
    yield
    jax.config.update("jax_default_matmul_precision", before)


@pytest.mark.parametrize("population", [2, 200, 51_202])
def test_an_accelerator_takes_half_a_population_at_once(population, monkeypatch):
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    for width, fillers in ((lanes_width(population), 0), (mjx_width(population), 1)):
        assert (width - fillers) % 8 == 0
        assert 0 <= width - fillers - population // 2 < 8


def test_a_population_of_any_size_is_split_somewhere(monkeypatch):
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    assert lanes_width(10**7) < 200_000


def test_products_are_exact_on_an_accelerator_unless_the_user_chose_otherwise(monkeypatch, precision):
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    jax.config.update("jax_default_matmul_precision", None)
    exact_products()
    assert _precision() == "highest"
    jax.config.update("jax_default_matmul_precision", "high")
    exact_products()
    assert _precision() == "high"


def test_on_a_cpu_nothing_changes(monkeypatch, precision):
    monkeypatch.setattr(jax, "default_backend", lambda: "cpu")
    jax.config.update("jax_default_matmul_precision", None)
    exact_products()
    assert _precision() is None
    assert max(lanes_width(10**6), mjx_width(10**6)) <= 104
