"""Reading the three file formats, and being told where a file is wrong."""

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.read import read_table


def _write(path, text, encoding="utf-8"):
    path.write_text(text, encoding=encoding)
    return path


def test_csv_reads_numbers_and_empty_cells(tmp_path):
    table = read_table(_write(tmp_path / "a.csv", 'time,"x, y", z\n0,1.5, -2 \n\n1e-1,,nan\n'))
    assert table.names == ("time", "x, y", "z")
    np.testing.assert_array_equal(table.column("time"), [0.0, 0.1])
    np.testing.assert_array_equal(table.column("x, y"), [1.5, np.nan])
    np.testing.assert_array_equal(table.column("z"), [-2.0, np.nan])


def test_csv_byte_order_mark_is_not_part_of_the_first_name(tmp_path):
    assert read_table(_write(tmp_path / "a.csv", "time\n1\n", "utf-8-sig")).names == ("time",)


def test_text_in_a_number_column_names_file_row_and_column(tmp_path):
    table = read_table(_write(tmp_path / "a.csv", "time,x\n0,1\n\n1,oops\n"))
    np.testing.assert_array_equal(table.column("time"), [0.0, 1.0])
    with pytest.raises(InputError, match=r"a\.csv, row 4, column 'x': 'oops' is not a number"):
        table.column("x")


def test_text_is_found_beyond_the_first_chunk_of_rows(tmp_path):
    rows = [f"{i},{i}" for i in range(10_500)]
    rows[10_400] = "10400,?"
    with pytest.raises(InputError, match=r"row 10402, column 'x'"):
        read_table(_write(tmp_path / "a.csv", "time,x\n" + "\n".join(rows))).column("x")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "row 1: has no header"),
        ("a,b\n1,2\n1\n", "row 3: 1 cells under a header of 2 columns"),
        ("a,b\n1,2,3\n", "row 2: 3 cells under a header of 2 columns"),
        ("a,a\n1,2\n", "row 1: two columns are called 'a'"),
        ("a;b\n1;2\n", "row 1: columns are not separated by commas"),
        ('a,b\n1,"2\n', "row 2: is not well-formed CSV"),
    ],
)
def test_malformed_csv_names_the_row(tmp_path, text, message):
    with pytest.raises(InputError, match=rf"a\.csv, {message}"):
        read_table(_write(tmp_path / "a.csv", text))


def test_csv_that_is_not_utf8(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"time,\xff\xfe\n0,1\n")
    with pytest.raises(InputError, match=r"a\.csv: is not UTF-8"):
        read_table(tmp_path / "a.csv")


def test_npz_columns_lists_and_what_is_no_column(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(
        path, time=np.arange(3), x=np.ones((3, 2), np.float32), name=np.array(["a", "b", "c"]), cube=np.ones((3, 1, 1))
    )
    table = read_table(path)
    assert table.column("time").dtype == np.float64
    np.testing.assert_array_equal(table.column("x", 1), np.ones(3))
    for name in ("name", "cube"):
        with pytest.raises(InputError, match=rf"a\.npz, column '{name}'"):
            table.column(name)


def test_npz_with_pickled_objects_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, time=np.arange(2), x=np.array([{}, None], dtype=object))
    with pytest.raises(InputError, match="column 'x'"):
        read_table(path).column("x")


def test_parquet_numbers_nulls_lists_and_text(tmp_path):
    path = tmp_path / "a.parquet"
    columns = {
        "time": [0, 1],
        "x": [1.0, None],
        "on": [True, False],
        "state": [[1.0, 2.0], [3.0, None]],
        "ragged": [[1.0], [1.0, 2.0]],
        "word": ["a", "b"],
        "words": [["a"], ["b"]],
    }
    parquet.write_table(pyarrow.table(columns), path)
    table = read_table(path)
    np.testing.assert_array_equal(table.column("time"), [0.0, 1.0])
    np.testing.assert_array_equal(table.column("x"), [1.0, np.nan])
    np.testing.assert_array_equal(table.column("on"), [1.0, 0.0])
    np.testing.assert_array_equal(table.column("state", 1), [2.0, np.nan])
    for name in ("ragged", "word", "words"):
        with pytest.raises(InputError, match=rf"a\.parquet, column '{name}'"):
            table.column(name)


@pytest.mark.parametrize("name", ["a.npz", "a.parquet"])
def test_contents_that_are_not_what_the_extension_says(tmp_path, name):
    with pytest.raises(InputError, match=rf"{name}: is not a"):
        read_table(_write(tmp_path / name, "time,x\n0,1\n"))


def test_npy_under_the_name_of_an_archive(tmp_path):
    with (tmp_path / "a.npz").open("wb") as stream:
        np.save(stream, np.arange(3))
    with pytest.raises(InputError, match=r"a\.npz: is not a NumPy \.npz archive"):
        read_table(tmp_path / "a.npz")


def test_missing_and_unknown_formats(tmp_path):
    with pytest.raises(InputError, match=r"none\.csv: no such recording"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(InputError, match=r"unknown kind of recording '\.txt'; known are: \.csv, \.npz, \.parquet"):
        read_table(_write(tmp_path / "a.txt", "time\n"))
    with pytest.raises(InputError, match=r"a\.mcap: is"):
        read_table(_write(tmp_path / "a.mcap", ""))
    with pytest.raises(InputError, match="is a folder, not a recording"):
        read_table(tmp_path)


def test_missing_column_lists_what_exists_and_index_must_fit(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, time=np.arange(2), x=np.ones((2, 3)))
    table = read_table(path)
    with pytest.raises(InputError, match=r"a\.npz: no column 'y'; known are: time, x"):
        table.column("y")
    with pytest.raises(InputError, match="column 'x': has 3 values a row, none at index 3"):
        table.column("x", 3)
    with pytest.raises(InputError, match="column 'x': has 3 values a row"):
        table.column("x")
    with pytest.raises(InputError, match="column 'time': has one value a row"):
        table.column("time", 0)
