"""The readings that a reader of a report may choose among."""

import base64

import numpy as np
import pytest

from estexp_jax.report.explain import traces as module
from estexp_jax.report.explain.traces import in_unit, traces, traces_script, traces_style
from tests.report.examples import ROWS, diagnosis


def unpacked(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), kind)


def test_every_reading_of_every_recording_is_there_with_gaps_between_windows():
    d = diagnosis()
    told = traces(d)
    assert [r["name"] for r in told["recordings"]] == ["b <i>$\\x$.csv", "a.csv"]  # what was not fitted comes first
    assert told["first"] == [0, 0] and told["every"] == 1
    for one, p in zip(told["recordings"], (d.predictions[1], d.predictions[0]), strict=True):
        time = unpacked(one["time"], "<f4")
        assert len(time) == ROWS + 2 and np.all(np.diff(time) > 0.0)
        for i, reading in enumerate(one["readings"]):
            assert reading["name"] == p.channels[i]
            for text, name in zip(reading["values"], ("recorded", "nominal", "explained"), strict=True):
                levels = unpacked(text, "<i2")
                shown = np.where(levels == -32768, np.nan, reading["low"] + levels * reading["step"])
                wanted = np.insert(getattr(p, name)[:, i], [ROWS // 3, 2 * ROWS // 3], np.nan)
                np.testing.assert_allclose(shown, wanted, atol=reading["step"])


def test_of_many_rows_some_are_shown_and_every_gap(monkeypatch):
    monkeypatch.setattr(module, "_MOST_VALUES", 300)
    told = traces(diagnosis())
    assert told["every"] == 3
    for one in told["recordings"]:
        levels = unpacked(one["readings"][0]["values"][0], "<i2")
        assert len(levels) < 0.5 * ROWS and np.sum(levels == -32768) >= 2


@pytest.mark.parametrize(
    ("unit", "told"),
    [("rad", "1 % = 0.57 deg"), ("rad/s", "1 % = 0.57 deg/s"), ("N m", "1 % = 0.01 N m"), ("", "1 % = 0.01")],
)
def test_errors_have_units(unit, told):
    assert in_unit(0.01, 1.0, unit) == told and in_unit(0.01, 0.0, "m") == "0.01 m"


def test_the_errors_of_a_reading_are_told_in_its_unit():
    [shown, _] = traces(diagnosis())["recordings"][0]["readings"]
    assert (
        shown["unit"] == "rad"
        and "Nominal simulator off by 15 % = 17 deg, explained simulator by 0.5 %" in shown["errors"]
    )


def test_the_library_is_small_and_bears_its_licence():
    assert len(traces_script()) + len(traces_style()) < 200_000
    folder = module._FOLDER.parent / "uplot"
    assert "MIT" in (folder / "LICENSE").read_text() and "1.6.32" in (folder / "README.md").read_text()
    assert "v1.6.32" in traces_script()[:2000] and "Permission is hereby granted" in traces_script()[:2000]
