"""Wrong keywords and values at the Python doors: an `InputError` before any work."""

import pytest

from estexp_jax.api.options.keywords import front_door
from estexp_jax.api.options.propose import ProposeOptions
from estexp_jax.errors import InputError


@front_door(ProposeOptions)
def door(folder, *, margin=0.9, seed=0, progress=None):
    """Do nothing."""
    return folder, margin, seed, progress


def test_right_keywords_arrive():
    assert door("a", margin=0.5, progress=print) == ("a", 0.5, 0, print)


def test_a_wrong_keyword_is_answered_with_those_that_exist_the_nearest_first():
    with pytest.raises(InputError) as refused:
        door("a", sed=1)  # pyright: ignore[reportCallIssue]
    assert str(refused.value) == "door(): has no keyword 'sed'; known are: seed, folder, margin, progress"


def test_a_value_out_of_the_commands_range_is_refused():
    with pytest.raises(InputError, match=r"--margin: 1\.5 is not possible; 0\.01 to 1"):
        door("a", margin=1.5)


def test_a_path_that_no_file_can_have_is_refused(tmp_path):
    @front_door()
    def reads(path):
        return path.read_text()

    with pytest.raises(InputError, match="too long for the name of a file"):
        reads(tmp_path / ("x" * 300))
