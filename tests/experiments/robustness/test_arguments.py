"""Command lines with impossible arguments, made from the options; all of them in the study."""

import pytest

from estexp_jax.api.options.ranges import Range
from estexp_jax.cli.commands import COMMANDS
from experiments.robustness.arguments import draw
from experiments.robustness.fuzz.trial import run

MOST = 4
"""Lines of each command that are tried here."""


def test_ends_of_a_range_are_met_and_passed():
    assert {0.0, 1.0, 2.0, 9.0, 10.0, 1e12} <= set(draw.ends_of(Range(1, 9), whole=True))
    assert {0.999, 1.0, 1.001} <= set(draw.ends_of(Range(1.0, None), whole=False))


def test_every_option_of_every_command_is_tried(tmp_path):
    for command in COMMANDS:
        lines = [*draw.lines_of(command, tmp_path)]
        for name in draw.options_of(command).__dataclass_fields__:
            flag = f"--{name.replace('_', '-')}"
            positional = any(len(line) == 4 and line[2] == "--out" for line in lines)
            assert any(flag in line for line in lines) or positional, (command, name)


@pytest.mark.parametrize("command", COMMANDS)
def test_what_is_beyond_a_range_is_refused_before_anything_is_read(command, tmp_path):
    beyond = [line for line in draw.lines_of(command, tmp_path) if line[-1] in ("-1", "nan")]
    for line in beyond[:MOST]:
        code, message = run(line, tmp_path, short=False)
        assert code == 2 and message and "Traceback" not in message, (line, message)
