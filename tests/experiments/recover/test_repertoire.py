"""The study of trials without a diagnosis."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.harness.recovery_case import RecoveryCase
from experiments.harness.world import world
from experiments.recover.repertoire import summary as repertoire
from experiments.recover.repertoire.repertoire import Repertoire, adapted, believed, evolved
from experiments.recover.repertoire.trials import budget


def test_a_trial_teaches_about_gaits_that_are_like_it() -> None:
    gaits, prior = np.array([[0.1], [0.2], [0.9]]), np.array([1.0, 0.9, 0.5])
    mean, deviation = believed(prior, gaits, [(0, 0.0)])
    assert mean[0] == pytest.approx(0.0, abs=0.01) and mean[1] < 0.2 and mean[2] > 0.3
    assert deviation[0] < 0.05 < deviation[1] < deviation[2] <= 1.0


def test_what_works_on_the_robot_is_found_among_what_does_not() -> None:
    """The map's best half does nothing on the robot; one trial there leads away from all of it."""
    duty = np.linspace(0.0, 1.0, 40)[:, None]
    far = np.where(duty[:, 0] < 0.5, 2.0, 1.5)
    robot = np.where(duty[:, 0] < 0.5, 0.1, 1.5)
    gaits = Repertoire(np.arange(40.0)[:, None], duty, far)
    tried = adapted(gaits, lambda weights: robot[int(weights[0])], 6)
    assert tried[0][1] == 0.1 and max(d for _, d in tried) == 1.5
    assert len({i for i, _ in tried}) == 6


def test_a_map_keeps_the_farthest_walker_of_each_gait_within_its_budget() -> None:
    settings = replace(RecoveryCase(None, 3, "tiny", "set").settings)
    maps = list(evolved(world("tiny"), settings, 20))
    sizes, bests = [len(m.distance) for m in maps], [m.distance.max() for m in maps]
    assert len(maps) == 4 and sizes == sorted(sizes) and bests == sorted(bests)  # 8 + 4 + 4 + 4 walks
    cells = {tuple(np.minimum((duty * 5).astype(int), 4)) for duty in maps[-1].duty}
    assert len(cells) == sizes[-1]
    start = world("tiny").settled([()])
    again = world("tiny").rollouts([()], start, maps[-1].weights, settings.steps)
    np.testing.assert_array_equal(again.position[0, :, -1, 0] - again.position[0, :, 0, 0], maps[-1].distance)
    assert budget(settings) == 5 * (8 + 2 * 4)


def test_recovery_is_the_best_so_far_of_what_there_was_before(tmp_path: Path) -> None:
    row = {"robot": "same", "before": 2.0, "diagnosis_0": 0.4, "diagnosis_1": 1.6, "diagnosis_2": 1.2}
    row |= {"gaits_repertoire": 9, "best_repertoire": 3.0, "gaits_tenfold": 20, "best_tenfold": 4.0}
    for way in ("repertoire", "tenfold"):
        row |= {f"{way}_{i}": d for i, d in enumerate([0.4, 0.2, 1.0, 1.7])}
    assert repertoire.recovered([row], "diagnosis").tolist() == [[0.2, 0.8, 0.8]]
    found = repertoire.summary([row, row])["same"]
    assert found["tenfold"]["with_equal_trials"] == {"trials": 3, "better": 2, "p": pytest.approx(0.25)}
    assert found["repertoire"]["trials_to_equal"] == 4
    assert (found["repertoire"]["best_undamaged"], found["tenfold"]["best_undamaged"]) == (1.5, 2.0)
    repertoire.draw([row, row], tmp_path)
    assert (tmp_path / "repertoire.png").stat().st_size > 0
