"""The balance of torques sizes springs and frictions of all joints at once."""

from collections.abc import Generator
from typing import Any

import pytest

from estexp_jax.discovery.diagnosis import ExplainConfig
from estexp_jax.discovery.joint.fit import JointSearch
from estexp_jax.discovery.joint.strategy import joint_problem_of
from estexp_jax.estimation.parameters import parameter_space
from tests.discovery.joint.arm import PLANTED, SPRING, case


def _result(steps: Generator[Any, None, Any]) -> Any:
    try:
        while True:
            next(steps)
    except StopIteration as end:
        return end.value


@pytest.mark.slow
def test_a_counterbalance_is_a_spring_and_no_gravity_compensation_or_offset():
    _, problem = joint_problem_of(case(planted=True, balanced=True), ExplainConfig(), {})
    found = _result(JointSearch(problem).first())  # no more than torques and the first fit of readings
    space = parameter_space(problem.simulator.robot, problem.simulator.catalogue)
    assert {name for name, site in found.fit.places if site == "j2"} == {"joint_stiffness", "coulomb_friction"}
    k, rest = found.fit.point[space.of_place["joint_stiffness", "j2"]]
    [dry] = found.fit.point[space.of_place["coulomb_friction", "j2"]]
    assert (k, rest) == pytest.approx(SPRING, rel=0.1)
    assert dry == pytest.approx(PLANTED["dof_frictionloss"][1], rel=0.1)
