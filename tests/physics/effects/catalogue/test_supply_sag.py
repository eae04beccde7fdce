"""A shared supply: what one motor draws weakens the others."""

import jax.numpy as jnp
import pytest

from estexp_jax.physics.effects.catalogue.supply_floor import SupplyFloor
from estexp_jax.physics.effects.catalogue.supply_sag import SupplySag
from estexp_jax.physics.effects.checks import sample_joint_state
from tests.physics.effects.test_alike import chain
from tests.physics.robots import robot


def factor(term, *p: float, load: float) -> float:
    joint = sample_joint_state(1)._replace(load=lambda: jnp.array([load]))
    return float(term.act(tuple(jnp.array([x]) for x in p), joint, ())[0].motor[0])


def test_every_motor_weakens_with_the_load_of_all() -> None:
    assert factor(SupplySag(), 0.03, load=10.0) == pytest.approx(0.7)
    assert factor(SupplySag(), 0.03, load=50.0) == 0.0


def test_it_may_end_at_a_floor() -> None:
    assert factor(SupplyFloor(), 0.03, 0.4, load=10.0) == pytest.approx(0.7)
    assert factor(SupplyFloor(), 0.03, 0.4, load=50.0) == pytest.approx(0.4)


def test_it_takes_several_motors() -> None:
    one = chain("hinge")
    assert SupplySag().sites(one) == SupplyFloor().sites(one) == ()
    assert SupplySag().sites(robot("quadruped")) == ("",)


def test_a_floor_is_told_where_there_is_one() -> None:
    name, values = SupplyFloor().reported_as({"R": 0.03, "floor": 0.4})
    assert name == "supply_sag" and SupplySag().sentence("", values).endswith("together, down to 40 %")
    assert "floor" in SupplySag().equation_with_values(values)
    name, values = SupplyFloor().reported_as({"R": 0.03, "floor": 0.001})
    assert values == {"R": 0.03} and SupplySag().equation_with_values(values) == SupplySag.equation
