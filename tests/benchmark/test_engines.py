"""Engines as the bench calls them."""

import numpy as np

from estexp_jax.benchmark.engines import CRunner
from estexp_jax.benchmark.subject import BenchmarkRobots


def test_c_by_another_route_that_does_something_else_is_found(race) -> None:
    field = BenchmarkRobots(race)
    assert CRunner("rollout", field).agreement().agrees
    other = BenchmarkRobots(race)
    other.__dict__["recorded"] = np.zeros_like(field.recorded)
    assert not CRunner("rollout", other).agreement().agrees
