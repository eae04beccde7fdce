"""A recovery in pictures, and the motions it is drawn from."""

import io
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.cycle import job_of
from estexp_jax.recovery.reality_gap_target import RealityGapTarget
from estexp_jax.recovery.state import Row, RunState
from estexp_jax.recovery.target import SameTarget
from estexp_jax.report.drawing.film import can_film
from estexp_jax.report.recover import film as recover_film
from estexp_jax.report.recover.film import film_of
from estexp_jax.report.recover.page import recover_page
from tests.physics.robots import robot


@pytest.fixture(scope="module")
def recovered():
    """A short run, ended, with a leg lost."""
    few: dict[str, Any] = {"population": 8, "generations": 1, "steps": 30, "settle_steps": 10, "passes": 1, "seed": 1}
    quadruped = robot("quadruped")
    job = job_of(quadruped, Settings(situation=None, damage=("part_lost@lower_f",), **few))
    weights = np.random.default_rng(0).uniform(-1, 1, (2, job.simulator.n_weights)).astype(np.float32)
    first, last = (job.simulator.controller(w, 30) for w in weights)
    assert isinstance(job.healthy, SameTarget) and isinstance(job.target, SameTarget)
    trials = (job.target(first), job.target(last))
    rows = tuple(Row(number, "exploration", 1, 0.1, 0.0, 1) for number in (0, 1))
    return job, RunState("done", 1, None, tuple(weights), before=job.healthy(first), trials=trials, history=rows)


def test_motions_are_the_trials_themselves(recovered) -> None:
    job, state = recovered
    rows = [0, 1, 17, 29]
    planted = [(), job.planted]
    found = job.simulator.motions(planted, np.stack([state.controllers[0]] * 2), rows)
    assert found.shape == (2, 4, job.simulator.robot.model.nq)
    for qpos, trial in zip(found, (state.before, state.trials[0]), strict=True):
        np.testing.assert_array_equal(qpos[:, :3].astype(np.float32), trial.position[rows].astype(np.float32))
    target = job_of(job.simulator.robot, replace(job.settings, robot="foreign"), world=job.simulator).target
    assert isinstance(target, RealityGapTarget)
    controller = job.simulator.controller(state.controllers[0], 30)
    np.testing.assert_allclose(target.motion(controller, rows)[:, :3], target(controller).position[rows])


def test_a_recovery_is_shown(recovered, renderer: None, monkeypatch: pytest.MonkeyPatch) -> None:
    job, state = recovered
    monkeypatch.setattr(recover_film, "_SIZE", (80, 54))
    shown = film_of(job, state)
    assert shown is not None and "data:image/jpeg" in shown._repr_html_()
    picture = np.asarray(Image.open(io.BytesIO(shown.strip)))
    assert picture.shape == (3 * 72, 5 * 80, 3) and picture[:54].std() > 10
    assert (shown.video is not None) == can_film()
    html = recover_page("run", job.planted, state, "x", {}, shown)
    assert "data:image/jpeg;base64" in html and ("data:video/mp4" in html) == can_film()
    assert film_of(replace(job, healthy=None, target=lambda c: state.trials[0]), state) is None
