"""A run whose every diagnosis is the true damage."""

from pathlib import Path

import numpy as np

from estexp_jax.recovery.state import RunState
from experiments.harness.options import Options
from experiments.harness.oracle import with_true_damage
from experiments.harness.recovery_case import FIRST_SEED, RecoveryCase
from experiments.harness.recovery_rows import row
from experiments.harness.recovery_runs import run_cases, state_of
from experiments.harness.world import job


def test_an_oracle_run_differs_in_nothing_but_what_it_knows(tmp_path: Path) -> None:
    case = RecoveryCase(1, FIRST_SEED, "tiny", "oracle")
    options = Options("tiny", 1, None, None, tmp_path / "table", tmp_path)
    options.out.mkdir()
    run_cases([case], options)
    state, work = state_of(case, tmp_path), job(case)
    assert state.phase == "done" and state.diagnoses == (work.planted,) * 4
    assert state.simulated[1:] == tuple(trial.distance("x") for trial in state.trials[1:])
    early = next(s for s in with_true_damage(work, RunState()) if s.number == 2 and s.search is not None)
    *_, last = with_true_damage(work, RunState.from_tree(early.to_tree()))
    assert all(map(np.array_equal, last.controllers, state.controllers))
    assert row(case, tmp_path)["right_4"]
