"""Explained cases, each once a session."""

from collections.abc import Callable
from functools import cache

import pytest

from estexp_jax.discovery.diagnosis import Diagnosis
from tests.discovery.planted import CASES, case_of, explained


@pytest.fixture(scope="session")
def diagnosed() -> Callable[[str], Diagnosis]:
    """The diagnosis of one of `CASES`, by its name."""

    @cache
    def diagnose(name: str) -> Diagnosis:
        robot, plant, seed = CASES[name]
        return explained(case_of(robot, plant, seed))

    return diagnose
