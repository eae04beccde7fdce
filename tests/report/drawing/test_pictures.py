"""Robots drawn: strips, films and ghosts; where no GL is, the message that says so."""

import io
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from estexp_jax.discovery.diagnosis import Prediction
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.cycle import job_of
from estexp_jax.recovery.reality_gap_target import RealityGapTarget
from estexp_jax.recovery.state import Row, RunState
from estexp_jax.recovery.target import SameTarget
from estexp_jax.report.drawing import gl
from estexp_jax.report.drawing.film import can_film, captioned, film, strip
from estexp_jax.report.drawing.gl import NoGlError, Shot, render_shots
from estexp_jax.report.drawing.robot_pictures import colours, drawn, ground_covered, standing_view, tinted, walking_view
from estexp_jax.report.explain.ghosts import angles_of, ghosts_of, postures
from estexp_jax.report.explain.marked import guilty, marked_of
from estexp_jax.report.recover import film as recover_film
from estexp_jax.report.recover.film import film_of
from estexp_jax.report.recover.page import recover_page
from tests.physics.robots import robot

BALL = "<mujoco><worldbody><body><freejoint/><geom size='.1' rgba='1 0 0 1'/></body></worldbody></mujoco>"


def _shot(one: Robot, qpos: np.ndarray) -> Shot:
    layers = qpos.shape[1]
    return Shot(qpos, np.stack([one.model.geom_rgba] * layers), np.zeros((len(qpos), 3)), 1.0, 90.0, 0.0)


@pytest.fixture(scope="module")
def drawing() -> None:
    """Skips where nothing can draw."""
    ball = Robot.from_string(BALL)
    try:
        render_shots(ball.model, [_shot(ball, ball.home()[None, None])], width=8, height=8)
    except NoGlError as error:
        pytest.skip(str(error))


def test_without_a_gl_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    ball = Robot.from_string(BALL)
    shot = _shot(ball, ball.home()[None, None])
    monkeypatch.setenv("MUJOCO_GL", "off")
    assert gl.backends() == ()
    with pytest.raises(NoGlError, match="MUJOCO_GL forbids it.*libosmesa6"):
        render_shots(ball.model, [shot], width=8, height=8)
    monkeypatch.setenv("MUJOCO_GL", "nonsense")
    with pytest.raises(NoGlError, match="nonsense: .*invalid value for environment variable MUJOCO_GL"):
        render_shots(ball.model, [shot], width=8, height=8)


def test_robots_are_where_they_should_be(drawing: None) -> None:
    ball = Robot.from_string(BALL)
    qpos = np.tile(ball.home(), (2, 2, 1))
    qpos[:, 1, :3] = [[0.3, 0, 0], [0.3, 0, 0.3]]  # the second robot: to the right, then up
    (pictures,) = render_shots(ball.model, [_shot(ball, qpos)], width=60, height=60)
    red = pictures[..., 0].astype(int) > 60
    assert red[:, 28:32, 28:32].all()  # the first one stays in the middle
    assert red[0, 25:35, 50:58].any() and not red[0, :15, 50:58].any()
    assert red[1, 2:15, 50:58].any() and not red[1, 25:35, 50:58].any()


def test_colours_tell_what_happened() -> None:
    quadruped = robot("quadruped")
    geoms = {quadruped.model.geom(i).name: i for i in range(quadruped.model.ngeom)}
    changes = [parse_change(text, quadruped) for text in ("part_lost@lower_f", "motor_weakness@knee_l loss=0.5")]
    rgba = colours(quadruped, [*changes, parse_change("gravity_tilt angle=0.1", quadruped)])
    assert rgba[geoms["foot_f"], 3] == 0.0 and rgba[geoms["foot_b"], 3] == 1.0
    assert rgba[geoms["foot_l"], 0] > 0.8 and rgba[geoms["foot_b"], 0] < 0.3
    assert (rgba[geoms["floor"]] == quadruped.model.geom_rgba[geoms["floor"]]).all()
    ghost = tinted(quadruped, (0.0, 0.0, 1.0), 0.5)
    assert ghost[geoms["torso"]].tolist() == [0.0, 0.0, 1.0, 0.5] and ghost[geoms["floor"], 3] == 1.0


def test_views_show_all_of_a_robot() -> None:
    quadruped = robot("quadruped")
    centre, radius = ground_covered(quadruped, quadruped.home()[None])
    np.testing.assert_allclose(centre, [0, 0, 0.105], atol=0.02)
    assert 0.3 < radius < 0.4
    assert walking_view("x", radius).azimuth == 110.0 and walking_view("-y", radius).azimuth == 20.0
    assert standing_view(robot("cartpole"), 1.0).distance == pytest.approx(2.4)
    assert drawn(quadruped).ntex == quadruped.model.ntex + 1  # the sky


def test_strips_and_films_hold_what_they_were_given() -> None:
    grey = captioned(np.full((30, 40, 3), 90, np.uint8), "a line")
    assert grey.shape == (48, 40, 3) and grey[30:].min() < 128 < grey[30:].max()
    whole = np.asarray(Image.open(io.BytesIO(strip([[grey, grey], [grey, grey]]))))
    assert whole.shape == (96, 80, 3) and abs(int(whole[10, 10, 0]) - 90) < 4
    if not can_film():
        pytest.skip("no film without the extra `video`")
    content = film([grey] * 10, 10.0)
    assert content[4:8] == b"ftyp" and film([grey] * 10, 10.0) == content


@pytest.fixture(scope="module")
def recovered():
    """A short run, ended, with a leg lost."""
    few: dict[str, Any] = {"population": 8, "generations": 1, "steps": 30, "settle_steps": 10, "passes": 1, "seed": 1}
    quadruped = robot("quadruped")
    job = job_of(quadruped, Settings(situation=None, damage=("part_lost@lower_f",), **few))
    weights = np.random.default_rng(0).uniform(-1, 1, (2, job.simulator.n_weights)).astype(np.float32)
    first, last = (job.simulator.controller(w, 30) for w in weights)
    assert isinstance(job.healthy, SameTarget) and isinstance(job.target, SameTarget)
    trials = (job.target(first), job.target(last))
    rows = tuple(Row(number, "exploration", 1, 0.1, 0.0, 1) for number in (0, 1))
    return job, RunState("done", 1, None, tuple(weights), before=job.healthy(first), trials=trials, history=rows)


def test_motions_are_the_trials_themselves(recovered) -> None:
    job, state = recovered
    rows = [0, 1, 17, 29]
    planted = [(), job.planted]
    found = job.simulator.motions(planted, np.stack([state.controllers[0]] * 2), rows)
    assert found.shape == (2, 4, job.simulator.robot.model.nq)
    for qpos, trial in zip(found, (state.before, state.trials[0]), strict=True):
        np.testing.assert_array_equal(qpos[:, :3].astype(np.float32), trial.position[rows].astype(np.float32))
    foreign = job_of(job.simulator.robot, replace(job.settings, robot="foreign"), world=job.simulator).target
    assert isinstance(foreign, RealityGapTarget)
    controller = job.simulator.controller(state.controllers[0], 30)
    np.testing.assert_allclose(foreign.motion(controller, rows)[:, :3], foreign(controller).position[rows])


def test_a_recovery_is_shown(recovered, drawing: None, monkeypatch: pytest.MonkeyPatch) -> None:
    job, state = recovered
    monkeypatch.setattr(recover_film, "_SIZE", (80, 54))
    shown = film_of(job, state)
    assert shown is not None and "data:image/jpeg" in shown._repr_html_()
    picture = np.asarray(Image.open(io.BytesIO(shown.strip)))
    assert picture.shape == (3 * 72, 5 * 80, 3) and picture[:54].std() > 10
    assert (shown.video is not None) == can_film()
    html = recover_page("run", job.planted, state, "x", {}, shown)
    assert "data:image/jpeg;base64" in html and ("data:video/mp4" in html) == can_film()
    assert film_of(replace(job, healthy=None, target=lambda c: state.trials[0]), state) is None


ARM = """<mujoco><worldbody><body><joint name="a" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02"/>
<body pos="0 0 -.3"><joint name="b" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02"/></body></body>
</worldbody><sensor><jointvel joint="a"/><jointpos name="angle" joint="a"/></sensor></mujoco>"""


@pytest.fixture
def diagnosis():
    """What ghosts need of a diagnosis: an arm whose nominal simulator is late, and then not."""
    arm, time = Robot.from_string(ARM), np.arange(100) * 0.01
    recorded = np.stack([np.cos(5 * time), np.sin(5 * time), 0.5 * np.sin(5 * time)], axis=1)
    nominal = recorded.copy()
    nominal[:50] *= 0.2
    channels = ("sensor_0", "angle", "qpos.b")
    prediction = Prediction("t.csv", "test", time, np.zeros(100), channels, recorded, nominal, recorded)
    qpos = np.stack([np.full(100, np.nan), recorded[:, 2]], axis=1)
    empty = np.zeros((100, 0))
    recording = Recording("t.csv", time, empty, empty, recorded[:, :2], qpos, np.full((100, 2), np.nan), "test")
    return SimpleNamespace(case=SimpleNamespace(robot=arm, recordings=[recording]), predictions=[prediction])


def test_ghosts_stand_as_recorded_and_predicted(diagnosis) -> None:
    (prediction,) = diagnosis.predictions
    angles = angles_of(diagnosis.case.robot, prediction)
    assert angles == {0: 1, 1: 2}
    real, nominal, explained = postures(diagnosis, prediction, angles, np.array([30]))[0]
    np.testing.assert_allclose(real, prediction.recorded[30, 1:])
    np.testing.assert_allclose(nominal, 0.2 * real)
    np.testing.assert_allclose(explained, real)


def test_ghosts_are_drawn(diagnosis, drawing: None) -> None:
    content = ghosts_of(diagnosis)
    assert content is not None
    picture = np.asarray(Image.open(io.BytesIO(content))).astype(int)
    assert picture.shape[0] == 280 and picture.shape[1] % 320 == 0
    orange = (picture[..., 0] - picture[..., 2]) > 60
    assert orange.any()
    diagnosis.predictions[0] = replace(diagnosis.predictions[0], channels=("sensor_0", "sensor_0", "sensor_0"))
    assert ghosts_of(diagnosis) is None


def test_places_to_be_marked_are_those_named_or_else_the_likeliest() -> None:
    knee, tilt = {"kind": "joint", "name": "knee"}, {"kind": "environment", "name": None}
    motors, hip = {"kind": "actuator", "name": "*"}, {"kind": "joint", "name": "hip"}
    named = {"verdict": "missing_physics", "what": [knee, tilt, motors, dict(knee)], "where": [hip]}
    assert guilty(named) == [("joint", "knee")]
    assert guilty({"verdict": "unexplained", "what": [], "where": [hip, knee]}) == [("joint", "hip")]
    assert guilty({"verdict": "unexplained", "what": [], "where": []}) == []
    assert guilty({"verdict": "consistent", "what": [], "where": [hip]}) == []


def test_the_guilty_part_is_marked(diagnosis, drawing: None) -> None:
    arm = diagnosis.case.robot
    shares = []
    for places in ([("joint", "b")], [("joint", "a"), ("sensor", "angle"), ("joint", "b")]):
        content = marked_of(arm, places)
        assert content is not None
        picture = np.asarray(Image.open(io.BytesIO(content))).astype(int)
        assert picture.shape == (348, 840, 3)
        orange = (picture[..., 0] - picture[..., 2]) > 60
        shares.append([half.mean() for half in (orange[:, :420], orange[:, 420:])])
    lower, both = np.array(shares)
    assert (lower > 0.002).all() and (both > 1.5 * lower).all()
    assert marked_of(arm, []) is None
    assert marked_of(arm, [("environment", "gravity"), ("sensor", "no.such")]) is None
