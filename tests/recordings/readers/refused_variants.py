"""Forms of the log of `variants` that are refused: what is said of the cause, and of the remedy."""

import re

import numpy as np
import pytest

from tests.recordings.readers.further_variants import _INTERVAL, _duckdb
from tests.recordings.readers.variants import _mcap, _mcap_json, _parquet, _rows, _text


def _encapsulated(mark):
    """MCAP whose messages begin with the mark of another encoding."""

    def write(folder, log):
        return _mcap(folder, log, lambda data: bytes([0, mark]) + data[2:])

    return write


def _flatbuffers(folder, log):
    pytest.importorskip("mcap")
    from mcap.writer import Writer

    with (folder / "log.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("own.Arm", "flatbuffer", b"x")
        for topic in ("/joint_states", "/command"):
            channel = writer.register_channel(topic, "flatbuffer", schema)
            for stamp in log.stamps.tolist():
                writer.add_message(channel, stamp, b"1234", stamp)
        writer.finish()
    return folder / "log.mcap"


def _matlab_5(folder, log):
    pytest.importorskip("scipy.io").savemat(folder / "log.mat", log.columns)
    return folder / "log.mat"


def _pickled_npz(folder, log):
    np.savez(folder / "log.npz", **(log.columns | {"goal_elbow": log.goals[:, 2].astype(object)}), allow_pickle=True)
    return folder / "log.npz"


def _pickled_frame(folder, log):
    pytest.importorskip("pandas").DataFrame(log.columns).to_pickle(folder / "log.pkl")
    return folder / "log.pkl"


def _both_marks(folder, log):
    rows = _rows(log.columns, ";", lambda v: f"{v:.6f}".replace(".", ","))
    return _text(folder, [";".join(log.columns), *rows[:60], *(row.replace(",", ".") for row in rows[60:])])


def _texts(folder, log):
    """A spreadsheet that has put a unit behind each number."""
    return _text(folder, [",".join(log.columns), *_rows(log.columns, cell=lambda v: f"{v!r} rad")])


def _two_of_one_name(folder, log):
    lines = [f"{row},{row.rpartition(',')[2]}" for row in _rows(log.columns)]
    return _text(folder, [",".join([*log.columns, list(log.columns)[-1]]), *lines])


def _no_header(folder, log):
    return _text(folder, _rows(log.columns))


def _ragged(folder, log):
    """Lists of one column that differ in length."""
    import pyarrow
    from pyarrow import parquet

    goals = [row[: 3 - k % 2] for k, row in enumerate(log.goals.tolist())]
    angles = log.angles.tolist()
    parquet.write_table(pyarrow.table({"t": log.time, "goal": goals, "position": angles}), folder / "log.parquet")
    return folder / "log.parquet"


def _cut_parquet(folder, log):
    whole = _parquet(folder, log).read_bytes()
    (folder / "log.parquet").write_bytes(whole[: len(whole) // 2])
    return folder / "log.parquet"


def _intervals(folder, log):
    return _duckdb(folder, log, _INTERVAL, "log.parquet")


def _never_stamped(folder, log):
    """Commands without a stamp in their header, as many controllers send them."""
    pytest.importorskip("mcap_ros2")
    return _mcap(folder, log, stamped=("/joint_states",))


def _two_clocks(folder, log):
    """Readings stamped since the robot was switched on, commands since 1970."""
    pytest.importorskip("mcap_ros2")
    return _mcap(folder, log, stamped=("/joint_states", "/command"), booted=("/joint_states",))


def _headers(text):
    """A manifest whose logs are read by the stamps in the messages' headers."""
    return text.replace("[[recording]]", '[[recording]]\nclock = "header"')


def _by_index(text):
    """A manifest with places in a list instead of names."""
    return re.sub(r"\.position\[(\w+)\]", ".position[0]", text)


def _by_places(text):
    """A manifest completed by hand, as its reader believes the lists to be."""
    return re.sub(r'# ("ctrl.m_\w+" =) "\?".*', r'\1 { column = "goal", index = 0 }', text)


def _same(text):
    return text


_XCDR1 = "plain CDR (XCDR1) is read: record with another middleware setting, or convert the bag"
REFUSED = {
    "CSV, no header": (_no_header, _same, "has no header", "the first line names the columns"),
    "CSV, both decimal marks": (_both_marks, _same, "decimal point or comma of the other kind", "one kind in a column"),
    "CSV, a unit behind each number": (_texts, _same, "row 3, column 't': '0.01 rad' is not a number", "a number, or"),
    "CSV, two columns of one name": (
        *(_two_of_one_name, _same, "two columns are called 'shoulder_position'", "each name once"),
    ),
    "NPZ, objects": (_pickled_npz, _same, "column 'goal_elbow': is no column: it holds object", "not numbers"),
    "pandas, pickled": (_pickled_frame, _same, "unknown kind of recording '.pkl'", "known are: .csv, "),
    "Parquet, lists of several lengths": (
        _ragged,
        _by_places,
        "column 'goal': is no column of numbers",
        "its lists differ",
    ),
    "Parquet, cut": (_cut_parquet, _same, "is not a Parquet file: Parquet magic bytes not found", "written to its end"),
    "Parquet, DuckDB with intervals": (_intervals, _same, "as Parquet stores intervals", "in DuckDB epoch(column)"),
    "MATLAB before v7.3": (_matlab_5, _same, "is not an HDF5 file", "save -v7.3"),
    "MCAP, a parameter list": (_encapsulated(3), _same, "it is encoded as PL_CDR (a parameter list)", _XCDR1),
    "MCAP, XCDR2": (_encapsulated(7), _same, "it is encoded as CDR2 (XCDR2)", _XCDR1),
    "MCAP, XCDR2, delimited": (_encapsulated(9), _same, "it is encoded as D_CDR2 (XCDR2, delimited)", _XCDR1),
    "MCAP, FlatBuffers": (_flatbuffers, _same, "messages in 'flatbuffer' are not read", "protobuf with its schema"),
    "MCAP, headers without stamps": (
        *(_never_stamped, _headers, "messages have the stamp 0 on the clock 'header'", 'clock = "log"'),
    ),
    "MCAP, headers without seconds' parts": (
        *(_mcap, _headers, "120 messages have 2 different times on the clock 'header'", 'clock = "log"'),
    ),
    "MCAP, messages without headers": (
        *(_mcap_json, _headers, "a message has no time on the clock 'header'", 'else clock = "log"'),
    ),
    "MCAP, two clocks": (_two_clocks, _headers, "do not overlap", "stamp both by one clock"),
    "MCAP, places of names that turn": (
        *(_mcap, _by_index, "the order of the names changes", "the name instead of the index"),
    ),
}
"""By the name in docs/recordings.md: writer, what is changed in the manifest of `--init`, cause, remedy."""
