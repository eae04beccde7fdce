"""Models drawn at random: some here, 200 in the study; each is right or refused, and a wrong one is noticed."""

from pathlib import Path
from unittest.mock import patch

import mujoco
import numpy as np
import pytest

import estexp_jax.api.simulate as front_door
from experiments.robustness.public_models.trial import tried
from experiments.robustness.random_models.draw import random_mjcf
from experiments.robustness.random_models.run import attempt, summary

SEEDS = range(100, 125)


@pytest.mark.filterwarnings("ignore")
def test_models_drawn_at_random_are_right_or_refused() -> None:
    rows = [attempt(seed, "auto") for seed in SEEDS]
    bad = [row for row in rows if row["result"] not in ("right", "unstable", "refused")]
    assert not bad
    assert summary(rows)["results"]["right"] >= 20 and summary(rows)["largest_error"] < 1e-9


def test_a_seed_is_a_model_and_seeds_differ() -> None:
    texts = [random_mjcf(seed)[0] for seed in SEEDS]
    assert texts == [random_mjcf(seed)[0] for seed in SEEDS] and len(set(texts)) == len(texts)


def test_draws_have_what_engines_treat_differently() -> None:
    models = [random_mjcf(seed)[1] for seed in range(60)]
    kinds = {int(kind) for model in models for kind in model.actuator_gaintype}
    assert kinds >= {
        int(k) for k in (mujoco.mjtGain.mjGAIN_PID, mujoco.mjtGain.mjGAIN_SO3, mujoco.mjtGain.mjGAIN_MUSCLE)
    }
    assert {int(kind) for model in models for kind in model.jnt_type} == {0, 1, 2, 3}
    assert any(model.neq for model in models) and any(model.ntendon for model in models)
    assert any(model.nhistory for model in models) and any(model.opt.disableactuator for model in models)


def test_a_difference_is_wrong_and_an_error_of_ours_a_crash(tmp_path: Path) -> None:
    path, simulate = tmp_path / "model.xml", front_door.simulate
    path.write_text(random_mjcf(3)[0], encoding="utf-8")
    assert tried(path, "auto")["result"] == "right"

    def off(*args: object, **kwargs: object) -> dict[str, np.ndarray]:
        found = simulate(*args, **kwargs)  # pyright: ignore[reportArgumentType, reportCallIssue]
        return found | {name: x + 1e-3 * np.ptp(x) for name, x in found.items() if name.startswith("qpos.")}

    with patch.object(front_door, "simulate", off):
        found = tried(path, "auto")
    assert found["result"] == "wrong" and found["worst_value"].startswith("qpos.")
    with patch.object(front_door, "simulate", side_effect=IndexError("out of bounds")):
        assert attempt(3, "auto")["result"] == "crashed"
