"""The format follows the extension; missing, unknown and mislabelled files are refused."""

import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.read import read_table


def _write(path, text, encoding="utf-8"):
    path.write_text(text, encoding=encoding)
    return path


@pytest.mark.parametrize("name", ["a.npz", "a.parquet"])
def test_contents_that_are_not_what_the_extension_says(tmp_path, name):
    with pytest.raises(InputError, match=rf"{name}: is not a"):
        read_table(_write(tmp_path / name, "time,x\n0,1\n"))


def test_missing_and_unknown_formats(tmp_path):
    with pytest.raises(InputError, match=r"none\.csv: no such recording"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(InputError, match=r"unknown kind of recording '\.txt'; known are: \.csv, \.npz, \.parquet"):
        read_table(_write(tmp_path / "a.txt", "time\n"))
    with pytest.raises(InputError, match=r"a\.mcap: is"):
        read_table(_write(tmp_path / "a.mcap", ""))
    with pytest.raises(InputError, match="is a folder, not a recording"):
        read_table(tmp_path)
