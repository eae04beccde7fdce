"""Runs of `recover` as studies name them."""

from experiments.harness.recovery_case import FIRST_SEED, RecoveryCase, seeds


def test_cases_have_folders_of_their_own() -> None:
    cases = [RecoveryCase(s, seed, "quick", m) for s in range(1, 14) for seed in seeds(3) for m in ("paper", "set")]
    assert len({case.name for case in cases}) == len(cases)
    assert min(case.seed for case in cases) == FIRST_SEED
