"""The state of a run: plain data and back, and its passes."""

from dataclasses import replace

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.state import Row, RunState

WEAK, LOST = (Change("motor_weakness", "knee_f", {"loss": 0.6}),), (Change("part_lost", "upper_b", {"lost": 1.0}),)


def trial(distance: float) -> Trial:
    position = np.stack([np.linspace(0.0, distance, 5), np.zeros(5), np.zeros(5)], axis=1)
    return Trial(0.01 * np.arange(5), np.ones((5, 2)), np.zeros((5, 2)), position)


STATE = RunState(
    phase="estimation",
    number=2,
    controllers=(np.zeros(3), np.ones(3)),
    simulated=(1.0, 0.9),
    diagnoses=(WEAK,),
    residuals=(0.1,),
    probabilities=(0.7,),
    alternatives=(((LOST, 0.2), ((), 0.1)),),
    alarms=(False,),
    before=trial(1.0),
    trials=(trial(0.3), trial(0.8)),
    history=(Row(0, "exploration", 1, 1.0, 0.5, 1),),
)


def test_a_tree_gives_the_state_back() -> None:
    again = RunState.from_tree(STATE.to_tree())
    for name in ("phase", "number", "diagnoses", "probabilities", "alternatives", "alarms", "history"):
        assert getattr(again, name) == getattr(STATE, name)
    np.testing.assert_array_equal(again.trials[1].position, STATE.trials[1].position)
    assert again.before is not None and again.before.distance("x") == 1.0


def test_a_pass_is_complete_with_its_trial() -> None:
    [done] = STATE.passes("x")
    assert (done.diagnosis, done.probability, done.alternatives) == (WEAK, 0.7, ((LOST, 0.2), ((), 0.1)))
    assert (done.simulated, done.hardware) == (0.9, 0.8)
    assert replace(STATE, trials=STATE.trials[:1]).passes("x") == ()
