"""Comma-separated logs: numbers, empty cells, and errors that name file, row and column."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.columns import Source
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


GOOD = {"time": [0.0, 0.1, 0.2], "x": [1.5, -2.0, 0.25]}


@pytest.mark.parametrize(
    "text",
    [
        "time,x\n0,1.5\n.1,-2\n.2,.25\n",
        "time;x\n0;1,5\n0,1;-2\n,2;2,5e-1\n",  # decimal commas
        "time;x\n0;1.5\n0.1;-2\n0.2;0.25\n",
        "time\tx\n0\t1.5\n0.1\t-2\n0.2\t0.25\n",
        "# my log\n# of today\n\ntime,x\n0,1.5\n# a remark\n0.1,-2\n0.2,0.25\n",
        "# time,x\n0,1.5\n0.1,-2\n0.2,0.25\n",  # as numpy.savetxt has it
        "% time,x\n0,1.5\n0.1,-2\n0.2,0.25\n",
        "time,x\ns,rad\n0,1.5\n0.1,-2\n0.2,0.25\n",
        "time,x\n[s],[-]\n0,1.5\n0.1,-2\n0.2,0.25\n",
        "time,x,\n0,1.5,\n0.1,-2,\n0.2,0.25,\n",
        "time,x\n0,1.5,\n0.1,-2,\n0.2,0.25,\n",
        "time,x,\n0,1.5\n0.1,-2\n0.2,0.25\n",
        "time,x\r\n0,1.5\r\n0.1,-2\r\n0.2,0.25\r\n",
        "time,x\n0,1.5\n0.1,-2\ntime,x\n0.2,0.25\n",
        "time,x,state,state\n0,1.5,a,b\n0.1,-2,a,b\n0.2,0.25,a,b\n",
        "time,x\n0,1.5\n0.1,-2\n0.2,0.25\n0.3,",
        "time,x\n0,1.5\n0.1,-2\n0.2,0.25\n0.3,1",
        'time,x\n0,1.5\n0.1,-2\n0.2,0.25\n0.3,"1',
        "time,x\n2026-03-01T10:00:00,1.5\n2026-03-01T10:00:00.100,-2\n2026-03-01T10:00:00.2000,.25\n",
        "% my log\n%time,word,x\n0,a,1.5\n0.1,b,-2\n0.2,c,0.25\n",  # as rostopic echo -p has it
        "sep=;\ntime;x\n0;1,5\n0,1;-2\n0,2;0,25\n",  # for a spreadsheet
        "time,x\n0.0 sec,1.5\n0.1 sec,-2\n0.2 sec,0.25\n",  # a timetable of MATLAB
        "time,x\n00:00:00,1.5\n00:00:00.1,-2\n00:00:00.2,0.25\n",
        "time,x\n0 days 00:00:00,1.5\n0 days 00:00:00.1,-2\n0 days 00:00:00.200000,.25\n",  # pandas
        "time,x\nPT0S,1.5\nPT0.1S,-2\nPT0.2S,.25\n",  # ISO 8601, as polars writes it
        "time,x\n2026-03-01 10:00:00.9Z,1.5\n2026-03-01 11:00:01+01:00,-2\n2026-03-01 10:00:01.1Z,.25\n",
    ],
)
def test_forms_of_text_logs(tmp_path, text):
    table = read_table(_write(tmp_path / "a.csv", text))
    for name, values in GOOD.items():
        np.testing.assert_allclose(table.column(name), values, atol=1e-12)


@pytest.mark.parametrize(
    "cells", [("0.1 sec", "1.5"), ("0.1 sec", "999999999999 hr"), ("00:01:00", "2026-03-01T10:00"), ("10:00", "1.5")]
)
def test_times_of_two_kinds_are_refused(tmp_path, cells):
    rows = [f"{cell},1" for cell in cells]
    with pytest.raises(
        InputError, match="is not a number; .* times also as 2026-02-03T10:20:30.5, 10:20:30.5 or 0.5 sec"
    ):
        read_table(_write(tmp_path / "a.csv", "\n".join(["time,x", *rows]))).column("time")


def test_times_of_two_kinds_far_apart_are_refused(tmp_path):
    rows = [*(f"{k * 0.1:.1f} sec,1" for k in range(10_000)), "2026-03-01T10:00:00,1"]
    with pytest.raises(InputError, match="row 10002, column 'time'"):
        read_table(_write(tmp_path / "a.csv", "\n".join(["time,x", *rows]))).column("time")


def test_a_quoted_name_may_hold_line_breaks(tmp_path):
    table = read_table(_write(tmp_path / "a.csv", 'time,"left\narm"\n0,1\n1,2\n'))
    assert table.names == ("time", "left\narm") and table.column("time").tolist() == [0.0, 1.0]


def test_tab_separated_files_may_say_so_by_their_name(tmp_path):
    np.testing.assert_array_equal(read_table(_write(tmp_path / "a.tsv", "time\n0\n1\n")).column("time"), [0, 1])


def test_absent_samples_and_switches(tmp_path):
    table = read_table(_write(tmp_path / "a.csv", "x,on\n1,True\nNA,false\nn/a,FALSE\nnull,true\n-,1\n2,0\n"))
    np.testing.assert_array_equal(table.column("x"), [1, np.nan, np.nan, np.nan, np.nan, 2])
    np.testing.assert_array_equal(table.column("on"), [1, 0, 0, 1, 1, 0])


def test_units_that_the_file_states_are_kept_and_told(tmp_path):
    table = read_table(_write(tmp_path / "a.csv", "time,x,y,z [deg/s]\n[ms],deg,V,\n0,1,2,3\n"))
    assert dict(table.units) == {"time": "ms", "x": "deg", "z [deg/s]": "deg/s"}
    assert table.notes == ("row 2 holds units: time in ms, x in deg",)
    np.testing.assert_allclose(Source("x").read(table, 1), [np.pi / 180])
    np.testing.assert_allclose(Source("x", scale=2.0, scaled=True).read(table, 1), [2.0])


def test_a_last_row_that_was_cut_is_left_out_and_told(tmp_path):
    whole = "time,x,y\n" + "".join(f"{k / 100},{float(np.sin(k))!r},{float(np.cos(k))!r}\n" for k in range(12))
    for stop in range(len("time,x,y\n") + 1, len(whole)):
        table = read_table(_write(tmp_path / "a.csv", whole[:stop]))
        rows = len(table.column("y"))
        if rows > 4:
            np.testing.assert_array_equal(table.column("y"), np.cos(np.arange(rows)))
            assert rows in (whole[:stop].count("\n") - 1, whole[:stop].count("\n"))


def test_columns_of_one_name_matter_only_where_they_are_needed(tmp_path):
    table = read_table(_write(tmp_path / "a.csv", "a,b,b\n1,2,3\n"))
    assert table.notes == ("two columns have one name, so neither is read: b",)
    with pytest.raises(InputError, match=r"a\.csv, row 1: two columns are called 'b'"):
        table.column("b")


def test_mixed_decimal_marks_are_refused(tmp_path):
    table = read_table(_write(tmp_path / "a.csv", "a;b\n1,234;1\n0.5;2\n"))
    with pytest.raises(InputError, match=r"row 3, column 'a': '0\.5' is after a decimal point or comma of the other"):
        table.column("a")


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (",goal,goal\n,a,b\ntime,,\n0,1,2\n1,3,4\n", ("time", "goal.a", "goal.b")),
        ("kind,goal,goal\njoint,a,b\ntime,,\n0,1,2\n1,3,4\n", ("time", "goal.a", "goal.b")),
        (",arm,arm\n,goal,goal\n,a,b\nt,,\n0,1,2\n1,3,4\n", ("t", "arm.goal.a", "arm.goal.b")),
        ("t,x,x\ns,rad,rad\n0,1,2\n1,3,4\n", ("t", "x", "x")),
    ],
)
def test_a_header_of_several_lines_is_joined(tmp_path, text, names):
    table = read_table(_write(tmp_path / "a.csv", text))
    assert tuple(dict.fromkeys(table.names)) == tuple(dict.fromkeys(names))
    np.testing.assert_array_equal(table.column(names[0]), [0.0, 1.0])
    assert table.row_numbers is not None and table.row_numbers[0] == text[: text.index("0,1,2")].count("\n") + 1


def test_logs_that_begin_anew_say_where(tmp_path):
    table = read_table(_write(tmp_path / "a.csv", "time,x\ns,rad\n0,1\n1,2\ntime,x\ns,rad\n0,3\n"))
    assert table.restarts == (2,) and table.row_numbers is not None and table.row_numbers.tolist() == [3, 4, 7]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "row 1: has no header"),
        ("a,b\n1,2\n1\n", "row 3: 1 cells under a header of 2 columns"),
        ("a,b\n1,2,3\n", "row 2: 3 cells under a header of 2 columns"),
        ("1,2\n3,4\n", "row 1: has no header: the first line holds '1,2'"),
        ('a,b\n1,"2\n', "row 2: is not well-formed CSV"),
        ("time x y\n0.0  1 2\n0.1  1 3\n", r"row 1: its cells are separated by spaces; .*sep="),
    ],
)
def test_malformed_csv_names_the_row(tmp_path, text, message):
    with pytest.raises(InputError, match=rf"a\.csv, {message}"):
        read_table(_write(tmp_path / "a.csv", text))


def test_csv_that_is_not_utf8(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"time,\xff\xfe\n0,1\n")
    with pytest.raises(InputError, match=r"a\.csv: is not UTF-8"):
        read_table(tmp_path / "a.csv")
