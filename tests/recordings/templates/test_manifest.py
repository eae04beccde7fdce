"""The first manifest: what its lines say of the guesses, units by name and by values, and names that do harm."""

import tomllib

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings import read_manifest
from estexp_jax.recordings.templates.manifest import write_manifest
from estexp_jax.recordings.write import write_csv
from tests.recordings.readers.variants import MODEL, truth


def _written(tmp_path, **columns):
    """The manifest of a log, as text."""
    (tmp_path / "arm.xml").write_text(MODEL)
    write_csv(tmp_path / "log.csv", columns)
    path = tmp_path / "recordings.toml"
    path.unlink(missing_ok=True)
    write_manifest(path, [str(tmp_path / "arm.xml"), str(tmp_path / "log.csv")], [], [])
    tomllib.loads(path.read_text())
    return path


def test_order_is_told_in_each_line(tmp_path):
    log = truth()
    goals = {f"goal_{k}": log.goals[:, k] for k in range(3)}
    path = _written(tmp_path, time=log.time, **goals, **{f"{n}_pos": log.angles[:, k] for k, n in enumerate("xyz")})
    assert path.read_text().count("by its order: check this") == 6
    np.testing.assert_array_equal(read_manifest(path).recordings[0].sensor, log.angles)


def test_what_is_open_says_which_columns_it_may_be(tmp_path):
    log = truth()
    text = _written(tmp_path, time=log.time, left_elbow_pos=log.time, right_elbow_pos=log.time).read_text()
    assert '# "sensor.q_elbow" = "?"  # which of these? left_elbow_pos, right_elbow_pos' in text
    assert '# "ctrl.m_base" = "?"  # needed' in text


@pytest.mark.parametrize(("unit", "factor"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
@pytest.mark.parametrize("name", ["time", "stamp"])
def test_units_of_clocks_by_their_values(tmp_path, name, unit, factor):
    log = truth()
    columns = {column: values for column, values in log.columns.items() if column != "t"}
    path = _written(tmp_path, **{name: factor * log.time}, **columns)
    assert f'time = {{ column = "{name}", unit = "{unit}" }}  # ' in path.read_text()
    np.testing.assert_allclose(read_manifest(path).recordings[0].time, log.time)


def test_names_cannot_write_lines_of_their_own(tmp_path):
    log = truth()
    hostile = 'x\n[[recording]]\nfile = "/etc/passwd"'
    text = _written(tmp_path, **log.columns, **{hostile: log.time}).read_text()
    assert len(tomllib.loads(text)["recording"]) == 1


def test_a_log_without_a_clock_has_a_rate(tmp_path):
    log = truth()
    path = _written(tmp_path, **{column: values for column, values in log.columns.items() if column != "t"})
    with pytest.raises(InputError, match="no column 'time'"):
        read_manifest(path)
    path.write_text(path.read_text().replace("[columns]", "[columns]\ntime = { hz = 100 }"))
    np.testing.assert_allclose(read_manifest(path).recordings[0].time, log.time)
    path.write_text(path.read_text().replace("hz = 100", "hz = 0"))
    with pytest.raises(InputError, match="hz is 0"):
        read_manifest(path)
