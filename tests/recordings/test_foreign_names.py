"""Twenty logs with names, orders, signs and units of other recorders: no joint is crossed, nothing silently assumed."""

import tomllib

import mujoco
import numpy as np
import pytest

from estexp_jax.cli.main import main
from estexp_jax.recordings.write import write_csv
from tests.recordings import foreign_logs
from tests.recordings.readers.variants import JOINTS, MODEL


@pytest.fixture(scope="module")
def motion():
    """Time, commands and angles (rows, 3) of the arm, with masses other than the model's."""
    model = mujoco.MjModel.from_xml_string(MODEL.replace('damping="1"', 'damping="1.3"'))
    data, rows = mujoco.MjData(model), []
    for k in range(600):
        t = k * 0.01
        rows.append((t, *np.sin(np.array([2.1, 2.7, 3.3]) * t + [0, 1, 2]), *data.qpos))
        data.ctrl[:] = rows[-1][1:4]
        mujoco.mj_step(model, data, 2)
    table = np.array(rows)
    return table[:, 0], table[:, 1:4], table[:, 4:]


def _named(goal, angle, order=(2, 0, 1), names=JOINTS, wrong=(), **factors):
    """Columns of a log: the names' patterns, the joints' order and names (`wrong` ones of readings), and factors."""

    def columns(time, goals, angles):
        found = {factors.get("clock", "time"): time * factors.get("ticks", 1.0)}
        for pattern, values, kind in ((goal, goals, "goals"), (angle, angles, "angles")):
            for j in order:
                found[pattern.format((wrong if kind == "angles" and wrong else names)[j], j, j + 1)] = (
                    values[:, j] * factors.get(kind, (1, 1, 1))[j]
                )
        return found

    return columns, {f"ctrl.m_{JOINTS[j]}": goal.format(names[j], j, j + 1) for j in range(3)} | {
        f"sensor.q_{JOINTS[j]}": angle.format((wrong or names)[j], j, j + 1) for j in range(3)
    }


DEGREES = (180 / np.pi,) * 3
LOGS = {
    "PlotJuggler": (_named("/cmd/joint_trajectory/{}/position", "/joint_states/{}/position", clock="__time"), ()),
    "camel case": (_named("{}TargetAngle", "{}ActualAngle", names=("Base", "Shoulder", "Elbow")), ()),
    "a prefix of the robot": (_named("cmd_left_arm_{}", "pos_left_arm_{}", order=(1, 2, 0)), ()),
    "a suffix of the joint": (_named("{}_joint_cmd", "{}_joint_pos", order=(0, 2, 1)), ()),
    "degrees in the name": (_named("{}_goal_deg", "{}_pos_deg", goals=DEGREES, angles=DEGREES), ('unit = "deg"',)),
    "degrees without a word": (_named("{}.goal", "{}.pos", goals=DEGREES, angles=DEGREES), ('unit = "deg"',)),
    "a sign": (_named("goal {}", "{} position", angles=(1, 1, -1)), ("scale = -1.0",)),
    "milliseconds": (_named("target/{}", "state/{}", clock="timestamp", ticks=1000.0), ('unit = "ms"',)),
    "numbers from 0": (_named("des_{1}", "meas_pos_{1}", order=(0, 1, 2)), ("check this", "?")),
    "numbers from 1": (_named("des_{2}", "meas_pos_{2}", order=(0, 1, 2)), ("check this", "?")),
    "other names": (_named("goal_{}", "pos_{}", order=(0, 1, 2), names=("pan", "lift", "tilt")), ("check this", "?")),
    "exchanged names": (_named("goal_{}", "pos_{}", wrong=("base", "elbow", "shoulder")), ("exchanged",)),
}


@pytest.mark.parametrize("name", LOGS)
def test_no_joint_is_crossed_and_what_is_open_is_said(tmp_path, name, motion, capsys, monkeypatch):
    (columns, right), words = LOGS[name]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(MODEL)
    write_csv(tmp_path / "log.csv", columns(*motion))
    assert main(["check", "arm.xml", "log.csv", "--init", "--out", "out"]) == 0
    text = next(tmp_path.rglob("recordings.toml")).read_text()
    told = text + "".join(capsys.readouterr())
    mapped = tomllib.loads(text)["columns"]
    for ours, theirs in right.items():
        source = mapped.get(ours)
        column = source["column"] if isinstance(source, dict) else source
        crossed = column not in (None, theirs)
        assert not crossed or "check this" in told, f"{ours} is read from {column}, not from {theirs}"
        assert column is not None or f'# "{ours}" = "?"' in text
    assert not words or any(word in told for word in words)


@pytest.mark.parametrize("name", foreign_logs.LOGS)
def test_logs_of_other_robots_in_other_formats(tmp_path, name, capsys, monkeypatch):
    log = foreign_logs.LOGS[name]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.xml").write_text(foreign_logs.model_of(log.joints))
    path = log.write(tmp_path, *foreign_logs.motion(log.joints))
    assert main(["check", "robot.xml", str(path), "--init", "--out", "out"]) == 0
    text = next(tmp_path.rglob("recordings.toml")).read_text()
    told = text + "".join(capsys.readouterr())
    mapped, lines = tomllib.loads(text)["columns"], text.splitlines()
    for k, joint in enumerate(log.joints):
        right = {f"ctrl.m_{joint}": log.command(joint, k), f"sensor.q_{joint}": log.position(joint, k)}
        right |= {f"sensor.w_{joint}": log.speed(joint, k)} if log.speed else {}
        for ours, theirs in right.items():
            [line] = [each for each in lines if each.removeprefix("# ").startswith(f'"{ours}"')]
            source = mapped.get(ours)
            column, place = (source["column"], source.get("index")) if isinstance(source, dict) else (source, None)
            found = f"{column}|{place}" if place is not None else column
            assert found == theirs, line
            assert place is None or "check this" in line
    assert log.said in told
