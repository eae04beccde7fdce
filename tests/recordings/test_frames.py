"""Recordings in memory: dictionaries, structured arrays, data frames; paths and globs beside them."""

import numpy as np
import pyarrow
import pytest

import estexp_jax as ee
from estexp_jax.errors import InputError
from estexp_jax.recordings.frames import Frame, frame_table, logs_of
from tests.recordings.checks.bad_logs import ARM

TIME = np.arange(200) * 0.01
COLUMNS = {"time": TIME, "ctrl.servo": np.sin(3 * TIME), "sensor.angle": np.sin(3 * TIME - 0.2)}


def _structured():
    rows = np.empty(len(TIME), dtype=[(name, "f8") for name in COLUMNS])
    for name, values in COLUMNS.items():
        rows[name] = values
    return rows


def _pandas():
    return pytest.importorskip("pandas").DataFrame(COLUMNS)


def _pandas_by_time():
    pandas = pytest.importorskip("pandas")
    stamps = pandas.Timestamp("2026-01-01T10:00:00Z") + pandas.to_timedelta(TIME, unit="s")
    return pandas.DataFrame({"time": stamps, **dict(list(COLUMNS.items())[1:])}).set_index("time")


def _polars():
    return pytest.importorskip("polars").DataFrame(COLUMNS)


@pytest.mark.parametrize(
    "make", [dict, _structured, _pandas, _pandas_by_time, _polars, pyarrow.table], ids=lambda make: make.__name__
)
def test_every_kind_of_frame_is_the_same_recording(tmp_path, make):
    (tmp_path / "arm.xml").write_text(ARM)
    frame = make(COLUMNS) if make in (dict, pyarrow.table) else make()
    result = ee.check(tmp_path / "arm.xml", frame, test=[frame])
    one, two = result.inputs.recordings
    assert (one.name, one.role, two.name, two.role) == ("frame_0", "train", "test_frame_0", "test")
    for recording in (one, two):
        np.testing.assert_allclose(recording.time, TIME, atol=1e-9)
        np.testing.assert_array_equal(recording.ctrl[:, 0], COLUMNS["ctrl.servo"])
        np.testing.assert_array_equal(recording.sensor[:, 0], COLUMNS["sensor.angle"])


def test_paths_globs_and_frames_together(tmp_path):
    for name in ("b.csv", "a.csv", "[c].csv"):
        (tmp_path / name).write_text("time\n0\n")
    glob = str(tmp_path / "*.csv")
    paths = [str(tmp_path / name) for name in ("[c].csv", "a.csv", "b.csv")]
    assert logs_of(glob) == logs_of(tmp_path / "*.csv") == paths
    assert logs_of(paths[0]) == paths[:1] and logs_of([paths[1], paths[0]]) == [paths[1], paths[0]]
    mixed = logs_of([COLUMNS, paths[1]])
    assert isinstance(mixed[0], Frame) and mixed[0].name == "frame_0" and mixed[1] == paths[1]
    named = logs_of({"slow": COLUMNS, "fast": COLUMNS})
    assert [log.name for log in named if isinstance(log, Frame)] == ["slow", "fast"]
    with pytest.raises(InputError, match="no file fits"):
        logs_of(str(tmp_path / "*.npz"))
    with pytest.raises(InputError, match="is 'int', not a recording"):
        logs_of([3])


def test_what_is_no_number_matters_only_where_it_is_needed():
    table = frame_table(Frame({"x": np.arange(3), "word": np.array(["a", "b", "c"])}, "f"))
    np.testing.assert_array_equal(table.column("x"), [0, 1, 2])
    with pytest.raises(InputError, match="f, column 'word': is no column"):
        table.column("word")
