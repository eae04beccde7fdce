"""Sources of columns, from a manifest's entries and from `--map`."""

import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.columns import Source, parse_map


def test_parse_map():
    assert parse_map(" ctrl.servo = goal_position") == ("ctrl.servo", Source(column="goal_position"))
    for text in ("ctrl.servo", "=goal", "ctrl.servo="):
        with pytest.raises(InputError, match="--map"):
            parse_map(text)
