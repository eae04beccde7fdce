"""A full disk or a folder that may not be written: told in one message, and what was there stays."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.write import write_csv
from estexp_jax.runs import load_checkpoint, open_run, save_checkpoint, write_json
from estexp_jax.runs.checkpoint import previous_of

BIG = np.random.default_rng(0).random(200_000)


def test_on_a_full_disk_the_old_files_stay(small_disk):
    folder = open_run(small_disk / "run", marker={"seed": 0})
    for number in (1, 2):
        save_checkpoint(folder.file("c"), number)
    write_json(folder.file("a.json"), 1)
    write_csv(folder.file("a.csv"), {"x": np.arange(2)})
    for write in (
        lambda: save_checkpoint(folder.file("c"), BIG),
        lambda: write_json(folder.file("a.json"), BIG),
        lambda: write_csv(folder.file("a.csv"), {"x": BIG}),
    ):
        with pytest.raises(InputError, match="cannot be written: No space left on device.*--resume"):
            write()
    assert load_checkpoint(folder.path / "c") == 2 and load_checkpoint(previous_of(folder.path / "c")) == 1
    assert (folder.path / "a.json").read_text() == "1\n" and (folder.path / "a.csv").read_text() == "x\n0\n1\n"
    assert not list(folder.path.glob(".*.part"))
    assert open_run(folder.path, resume=True, marker={"seed": 0}).resumed


def test_a_read_only_folder_is_told(read_only):
    with pytest.raises(InputError, match="cannot be written: .*a folder that you may write in"):
        open_run(read_only / "run", marker={"seed": 0})
    with pytest.raises(InputError, match="cannot be written"):
        write_json(read_only / "a.json", 1)


def test_results_on_a_disk_that_has_become_read_only_are_told(small_disk, remount):
    open_run(small_disk / "run", marker={"seed": 0})
    remount(small_disk, "ro")
    for flags in ({"resume": True}, {"force": True}):
        with pytest.raises(InputError, match="cannot be written: Read-only file system"):
            open_run(small_disk / "run", **flags, marker={"seed": 0})
