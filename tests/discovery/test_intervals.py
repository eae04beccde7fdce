"""Intervals hold the truth as often as they say, also where windows are few and their errors last."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest

from estexp_jax.discovery import intervals
from estexp_jax.discovery.intervals import parameter_intervals
from estexp_jax.discovery.slopes import Fit

WINDOWS, SAMPLES = 12, 40
TRUE = np.array([0.7, -1.2, 0.4])
FREE = [SimpleNamespace(size=s, spread=1e3, low=-9.0, high=9.0, chosen=False) for s in (1.0, 0.1, 3.0)]


@dataclass(frozen=True)
class Linear:
    """A comparison whose residuals grow in proportion to the parameters."""

    slopes: np.ndarray
    seen: np.ndarray
    step: np.ndarray | float = 0.0
    lacking: float = 1.0
    hairs: bool = False
    fitted: np.ndarray = field(default_factory=lambda: np.arange(WINDOWS))

    def prices(self, members):
        return [1e-6] * len(members)

    def residuals(self, members, windows):
        off = self.seen - self.step * (1.0 - self.lacking)
        return np.stack([self.slopes @ v - off for _, v in members])[:, windows]


def drawn(rng, step=0.0) -> tuple[Linear, Fit]:
    """Errors last for a whole window, and in some windows they are larger."""
    slopes = rng.standard_normal((WINDOWS, SAMPLES, 3)) + rng.standard_normal((WINDOWS, 1, 3))
    loud = rng.choice([0.3, 2.0], size=(WINDOWS, 1))
    noise = loud * (rng.standard_normal((WINDOWS, 1)) + 0.5 * rng.standard_normal((WINDOWS, SAMPLES)))
    problem = Linear(slopes, slopes @ TRUE + noise, step)
    found = np.linalg.lstsq(slopes.reshape(-1, 3), problem.seen.ravel(), rcond=None)[0]
    return problem, Fit(SimpleNamespace(free=FREE), found, 0.0)  # pyright: ignore[reportArgumentType]


@pytest.fixture(autouse=True)
def _derivatives(monkeypatch):
    def jacobian(problem, fitted, windows):
        return problem.residuals([fitted.member], windows)[0], problem.slopes[windows]

    monkeypatch.setattr(intervals, "jacobian", jacobian)


def test_nine_of_ten_intervals_hold_the_truth() -> None:
    rng, held = np.random.default_rng(31), []
    for _ in range(300):
        low, high = parameter_intervals(*drawn(rng)).T  # pyright: ignore[reportArgumentType]
        held.append((low <= TRUE) & (high >= TRUE))
    assert 0.86 < np.mean(held) < 0.97


def test_what_changes_nothing_may_have_any_value() -> None:
    problem, fitted = drawn(np.random.default_rng(35))
    plain = parameter_intervals(problem, fitted)  # pyright: ignore[reportArgumentType]
    for rounding in (0.0, 1e-8):
        slopes = problem.slopes.copy()
        slopes[..., 2] *= rounding
        blind = Linear(slopes, problem.seen - 0.4 * problem.slopes[..., 2])
        free = [SimpleNamespace(**{**vars(f), "spread": np.inf}) for f in FREE]
        found = Fit(SimpleNamespace(free=free), fitted.vector, 1.0)  # pyright: ignore[reportArgumentType]
        told = parameter_intervals(blind, found)  # pyright: ignore[reportArgumentType]
        assert told[2].tolist() == [-9.0, 9.0]
        assert (np.diff(told[:2]) < 3.0 * np.diff(plain[:2])).all()


def test_what_the_step_does_like_a_parameter_makes_it_uncertain() -> None:
    problem, fitted = drawn(np.random.default_rng(32))
    plain = np.diff(parameter_intervals(problem, fitted))[:, 0]  # pyright: ignore[reportArgumentType]
    stepped = Linear(problem.slopes, problem.seen, 50.0 * problem.slopes[..., 1])
    doubtful = np.diff(parameter_intervals(stepped, fitted))[:, 0]  # pyright: ignore[reportArgumentType]
    assert doubtful[1] > 8.0 and doubtful[1] > 5.0 * plain[1]
    assert doubtful[[0, 2]] == pytest.approx(plain[[0, 2]], rel=0.2)


def test_a_window_that_hangs_on_a_hair_makes_nothing_uncertain_that_the_others_settle() -> None:
    problem, fitted = drawn(np.random.default_rng(33))
    plain = np.diff(parameter_intervals(problem, fitted))[:, 0]  # pyright: ignore[reportArgumentType]
    slopes, seen = problem.slopes.copy(), problem.seen.copy()
    slopes[4] *= 30.0
    seen[4] = slopes[4] @ fitted.vector + 40.0
    wild = Linear(slopes, seen)
    ruled, free = (
        np.diff(parameter_intervals(replace(wild, hairs=hairs), fitted))[:, 0]  # pyright: ignore[reportArgumentType]
        for hairs in (False, True)
    )
    assert (ruled > 3.0 * plain).all()
    assert (free < 1.5 * plain).all()
