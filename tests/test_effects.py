"""The public namespace of effects is a module and lists them when called, whichever is asked for first."""

import subprocess
import sys

import pytest

import estexp_jax as ee
import estexp_jax.effects as namespace
from estexp_jax.physics.effects import registry

CALLED_FIRST = """
import sys, estexp_jax as ee
assert "jax" not in sys.modules
listed = ee.effects()
from estexp_jax.effects import Term
import estexp_jax.effects as namespace
assert ee.effects is namespace and ee.effects() == listed and namespace.Term is Term
"""
IMPORTED_FIRST = """
from estexp_jax.effects import Term
import estexp_jax.effects
import estexp_jax as ee
assert ee.effects is estexp_jax.effects and ee.effects.Term is Term
assert "cogging" in [e.name for e in ee.effects()]
"""


@pytest.mark.parametrize("script", [CALLED_FIRST, IMPORTED_FIRST], ids=["called first", "imported first"])
def test_the_namespace_is_a_module_and_can_be_called(script: str) -> None:
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_list_prints_as_a_table() -> None:
    listed = ee.effects()
    assert tuple(listed) == registry.named_effects()
    header, *rows = repr(listed).splitlines()
    assert header.split()[0] == "effect" and len(rows) == len(listed)
    [row] = [row for row in rows if row.startswith("viscous_friction ")]
    assert "joint" in row and "c [N m s/rad]" in row and row.endswith("tau = -c w")
    assert listed._repr_html_().count("<tr>") == len(listed) + 1


def test_all_that_it_offers_is_there() -> None:
    assert len(set(namespace.__all__)) == len(namespace.__all__)
    assert all(hasattr(namespace, name) for name in namespace.__all__)
