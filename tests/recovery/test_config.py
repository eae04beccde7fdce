"""Settings of a run: what is refused, and what follows from what."""

from typing import Any

import pytest

from estexp_jax.errors import InputError
from estexp_jax.recovery.config import Settings, quick_settings


def test_impossible_settings_are_the_users_errors() -> None:
    wrongs: list[dict[str, Any]] = [
        {"situation": 14},
        {"population": 2},
        {"window": 5},
        {"steps": 20},
        {"settle_steps": 2000},
        {"ensemble": 0},
        {"ensemble": 4},
    ]
    for wrong in wrongs:
        with pytest.raises(InputError, match=f"--{next(iter(wrong)).replace('_', '-')}"):
            Settings(**wrong)
    assert quick_settings(Settings(seed=5)).seed == 5


def test_the_papers_search_keeps_no_rivals() -> None:
    with pytest.raises(InputError, match="next-trial"):
        Settings(next_trial="informative", paper=True)
