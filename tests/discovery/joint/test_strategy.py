"""The joint sparse fit: several effects found together on an arm that plain MuJoCo moved, and nothing where none is."""

from collections.abc import Generator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig
from estexp_jax.discovery.explain import explain
from estexp_jax.discovery.joint.reading_stage import JointFit
from estexp_jax.discovery.joint.strategy import _likelier, explain_jointly, is_jointly_fitted
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.model.robot import Robot
from tests.discovery.joint.arm import NOMINAL, PLANTED, case


def _result(steps: Generator[Any, None, Any]) -> Any:
    try:
        while True:
            next(steps)
    except StopIteration as end:
        return end.value


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    return _result(explain(case(planted=True), ExplainConfig()))


def test_all_that_is_missing_is_named_at_its_joint_with_its_size(found: Diagnosis):
    damping, dry = PLANTED["dof_damping"], PLANTED["dof_frictionloss"]
    wanted = {("viscous_friction", f"j{i + 1}"): c for i, c in enumerate(damping) if c}
    wanted |= {("coulomb_friction", f"j{i + 1}"): T for i, T in enumerate(dry) if T}
    told = {(w["effect"], w["name"]): next(iter(w["parameters"].values())) for w in found.findings["what"]}
    assert set(told) == set(wanted)
    for place, value in wanted.items():
        assert told[place]["value"] == pytest.approx(value, rel=0.05)
        assert told[place]["low"] <= told[place]["value"] <= told[place]["high"]


def test_the_joints_are_located_and_the_test_recording_is_predicted(found: Diagnosis):
    findings = found.findings
    assert findings["verdict"] == "missing_physics"
    assert {entry["name"] for entry in findings["where"]} <= {"j1", "j2", "j3", "j4"}
    assert sum(entry["share"] for entry in findings["where"]) == pytest.approx(1.0, abs=0.1)
    assert findings["fit"]["gain"]["low"] > 0.9


@pytest.mark.slow
def test_where_nothing_is_missing_the_stepwise_search_is_asked():
    assert _result(explain_jointly(case(planted=False), ExplainConfig(), {})) is None


def test_it_applies_to_robots_of_hinges_and_slides_that_are_all_measured():
    arm = case(planted=True)
    assert is_jointly_fitted(arm)
    unmeasured = tuple(replace(r, sensor=r.sensor * [1.0, 1.0, np.nan, 1.0]) for r in arm.recordings)
    assert not is_jointly_fitted(Case(arm.robot, unmeasured, arm.robots))
    floating = Robot.from_string(
        NOMINAL.replace('<body name="l1">', '<body name="l1" pos="0 0 1"><freejoint/><geom size=".1"/></body><body>'),
        "floating",
    )
    assert not is_jointly_fitted(Case(floating, arm.recordings, (floating,) * 3))


def test_what_is_told_first_is_the_likeliest():
    """A rival that is better by a tenth on every window, but not plainly, is likelier; one that is as good is not."""
    hypotheses = {name: SimpleNamespace(places=((name, "j1"),), free=(), changes=tuple) for name in "abc"}
    errors = {"a": 1.0, "b": 0.9, "c": 1.0}
    tried = {
        name: Explanation(cast(Fit, SimpleNamespace(hypothesis=h, vector=np.zeros(0))), np.full(12, errors[name]))
        for name, h in hypotheses.items()
    }
    rivals = {name: cast(JointFit, SimpleNamespace(places=h.places)) for name, h in hypotheses.items()}
    nothing = Explanation(cast(Fit, SimpleNamespace(hypothesis=SimpleNamespace(places=(), free=()))), np.full(12, 9.0))
    selection = Selection(nothing, nothing, nothing, (tried["c"], tried["b"], tried["a"]), tried["a"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("estexp_jax.discovery.selection.stretched", lambda _: ())
        assert _likelier(selection, [rivals["c"], rivals["b"]]) is rivals["b"]
        assert _likelier(selection, [rivals["c"]]) is None
        assert _likelier(selection, []) is None
