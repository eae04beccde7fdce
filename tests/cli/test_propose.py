"""`estexp propose`: what it writes, what it refuses, and the same from Python."""

import json
import shutil

import numpy as np
import pytest

import estexp_jax as ee
from estexp_jax.experiment_design.excitation import multisine
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.recordings.readers.read import read_table
from estexp_jax.recordings.write import write_csv
from estexp_jax.replay.explained_simulator import ExplainedSimulator
from estexp_jax.report.explain.result import ExplainResult
from tests.pendulum import PENDULUM, run

SHORT = ("--duration", "2", "--seed", "4")


@pytest.fixture(scope="module")
def proposed(explained, tmp_path_factory):
    out = tmp_path_factory.mktemp("proposed") / "out"
    assert run("propose", explained, "--out", out, *SHORT) == 0
    return out


def kept(explained) -> dict:
    return json.loads((explained / "rivals.json").read_text())


def test_the_files_are_what_was_promised(proposed, explained):
    rivals = kept(explained)["rivals"]
    names = {str(path.relative_to(proposed)) for path in proposed.rglob("*") if path.is_file()}
    promised = {"commands.csv", "advice.md", "report.html", *(f"rivals/{n}.csv" for n in range(1, len(rivals) + 1))}
    assert names - {".estexp-run.json", ".estexp-run.lock"} == promised
    commands = read_table(proposed / "commands.csv")
    assert commands.names == ("time", "ctrl.servo")
    np.testing.assert_allclose(commands.column("time"), np.arange(201) / 100)
    assert np.abs(commands.column("ctrl.servo")).max() <= 0.9 * 1.5
    for n in range(1, len(rivals) + 1):
        told = read_table(proposed / "rivals" / f"{n}.csv")
        assert told.names == ("time", "sensor.angle")
        np.testing.assert_array_equal(told.column("time"), commands.column("time"))


def test_the_first_rival_predicts_what_the_explained_simulator_does(proposed, explained):
    commands = read_table(proposed / "commands.csv").column("ctrl.servo")[:, None]
    traces = ee.load_explained(explained).rollout(commands, period=0.01)
    first, second = (read_table(proposed / "rivals" / f"{n}.csv").column("sensor.angle") for n in (1, 2))
    np.testing.assert_allclose(first, traces.sensors[:, 0], atol=1e-5)
    assert np.abs(second - first).max() > 0.02


def test_the_advice_names_rivals_sensor_and_what_comes_next(proposed, explained):
    advice = (proposed / "advice.md").read_text()
    for rival in kept(explained)["rivals"]:
        assert rival["effects"][0] in advice and rival["sentence"] in advice
    assert "`angle`" in advice and "deviations" in advice and "rad" in advice
    assert "train_0.csv train_1.csv proposed.csv --test test_0.csv" in advice


def test_it_is_the_same_from_python_and_prints_itself(proposed, explained):
    told = []
    proposal = ee.propose(explained, duration=2.0, seed=4, progress=told.append)
    np.testing.assert_array_equal(proposal.commands[:, 0], read_table(proposed / "commands.csv").column("ctrl.servo"))
    assert [step.done for step in told if step.stage == "searching motions"] == list(range(1, 17))
    assert "coulomb_friction@elbow" in repr(proposal)
    assert proposal._repr_html_().count("<tr>") == 1 + len(proposal.table())


def test_a_part_of_a_range_is_not_left(explained, tmp_path):
    assert run("propose", explained, "--out", tmp_path / "out", *SHORT, "--margin", "0.1") == 0
    commands = read_table(tmp_path / "out" / "commands.csv").column("ctrl.servo")
    assert 0.0 < np.abs(commands).max() <= 0.1 * 1.5 + 1e-12


def test_results_are_replaced_only_when_asked(proposed, explained, tmp_path, capsys):
    out = tmp_path / "out"
    shutil.copytree(proposed, out)
    (out / "advice.md").write_text("mine")
    assert run("propose", explained, "--out", out, *SHORT) == 2
    assert "--force" in capsys.readouterr().err
    assert (out / "advice.md").read_text() == "mine"
    assert run("propose", explained, "--out", out, *SHORT, "--force") == 0
    assert (out / "advice.md").read_text() == (proposed / "advice.md").read_text()


def test_interrupted_it_leaves_no_half_and_can_be_done_again(proposed, explained, tmp_path, monkeypatch, capsys):
    from estexp_jax.api.propose import search_experiment

    def stopped(*arguments):
        for step in search_experiment(*arguments):
            yield step
            if step.done == 2:
                raise KeyboardInterrupt

    out = tmp_path / "out"
    with monkeypatch.context() as patched:
        patched.setattr("estexp_jax.api.propose.search_experiment", stopped)
        assert run("propose", explained, "--out", out, *SHORT) == 3
    assert "--resume" in capsys.readouterr().err
    assert sorted(path.name for path in out.iterdir()) == [".estexp-run.json", ".estexp-run.lock"]
    assert run("propose", explained, "--out", out, *SHORT, "--resume") == 0
    assert (out / "commands.csv").read_bytes() == (proposed / "commands.csv").read_bytes()


@pytest.mark.slow
def test_what_is_proposed_settles_what_one_more_random_motion_does_not(tmp_path):
    """A tired motor and a payload move a pendulum alike, unless it swings just so."""
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    robot, time = ee.Robot.from_xml(tmp_path / "pendulum.xml"), np.arange(400) / 100
    real = ExplainedSimulator(robot, (parse_change("motor_weakness@servo loss=0.35", robot),), finer=5)

    def log(name: str, commands: np.ndarray, seed: int) -> str:
        traces = real.rollout(commands)
        angle = traces.sensors[:, 0] + np.random.default_rng(seed).normal(0.0, 3e-3, len(commands))
        write_csv(tmp_path / name, {"time": traces.time, "ctrl.servo": commands[:, 0], "sensor.angle": angle})
        return str(tmp_path / name)

    def probability(*more: str) -> tuple[ExplainResult, float]:
        effects = ("body_mass", "motor_weakness", "com_shift")
        found = ee.explain(robot.source, [*logs, *more], test=[test], effects=effects, most=1, window=1.0)
        what = found.findings["what"]
        return found, sum(w["probability"] for w in what if w["effect"] == "motor_weakness")

    *logs, test, random = (log(f"{k}.csv", multisine(robot, time, 0.15, k), k) for k in (0, 1, 2, 77))
    explanation, before = probability()
    explanation.write(tmp_path / "explained")
    proposal = ee.propose(tmp_path / "explained", duration=4.0)
    _, after = probability(log("proposed.csv", proposal.commands[:-1], 9))
    _, otherwise = probability(random)
    assert before < 0.9 and otherwise < 0.95 < after


def _without(key):
    return lambda rivals: rivals.pop(key)


BROKEN = {
    "no rivals": (lambda k: k.update(rivals=k["rivals"][:1]), ("no rivals", "rivals.json")),
    "another schema": (lambda k: k.update(schema="estexp.effects/1"), ("estexp.rivals/1", "rivals.json")),
    "no commands": (_without("commands"), ("damaged", "commands")),
    "an unknown effect": (lambda k: k["rivals"][0]["changes"][0].update(effect="magic"), ("magic", "known are")),
    "an unknown place": (lambda k: k["rivals"][0]["changes"][0].update(name="wrist"), ("wrist", "known are")),
    "another robot": (lambda k: k.update(speeds=[1.0, 2.0]), ("another robot", "explain again")),
    "an unknown reading": (lambda k: k.update(channels=["force"]), ("force", "angle")),
    "no model": (lambda k: k.update(nominal="lost.xml"), ("lost.xml",)),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_folder_that_says_too_little_is_told(name, explained, tmp_path, capsys):
    change, told = BROKEN[name]
    folder = tmp_path / "explained"
    shutil.copytree(explained, folder)
    document = kept(folder)
    change(document)
    (folder / "rivals.json").write_text(json.dumps(document))
    assert run("propose", folder, "--out", tmp_path / "out", *SHORT) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert error.startswith("estexp: error: ") and all(words in error for words in told)


def test_a_folder_that_is_no_explanation_is_told(recorded, tmp_path, capsys):
    for folder in (recorded, tmp_path / "nowhere"):
        assert run("propose", folder, "--out", tmp_path / "out") == 2
        error = capsys.readouterr().err.strip()
        assert "rivals.json" in error and "estexp explain" in error and "\n" not in error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments",
    [("--margin", "0"), ("--margin", "1.1"), ("--duration", "0.1"), ("--speed", "-1"), ("--seed", "-1")],
    ids=" ".join,
)
def test_wrong_options_are_told(arguments, explained, tmp_path, capsys):
    assert run("propose", explained, "--out", tmp_path / "out", *arguments) == 2
    assert arguments[0] in capsys.readouterr().err
    assert run("propose", explained, "--out", tmp_path / "out", "--engine", "magic") == 2
    assert "--engine" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
