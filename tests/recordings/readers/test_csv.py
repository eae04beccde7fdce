"""Comma-separated logs: numbers, empty cells, and errors that name file, row and column."""

import numpy as np
import pytest

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
