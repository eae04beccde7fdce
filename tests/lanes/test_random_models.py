"""Whatever the robot: lanes move it as the C engine does, or say by name what they cannot."""

from __future__ import annotations

from typing import Any

import jax
import mujoco
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from estexp_jax.errors import InputError
from estexp_jax.lanes.capabilities import refusal
from estexp_jax.package_data import model_path
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines import choice
from estexp_jax.physics.engines.c.open_loop import COpenLoop
from estexp_jax.physics.engines.choice import choose_engine
from estexp_jax.physics.engines.closed_loop_agreement import Agreement
from estexp_jax.physics.engines.mjx.model import mjx_model
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.control.network import RecurrentPolicy
from tests.lanes.lanes_twin import exact, stepped, visited
from tests.physics.robots import robot

_GEOMS = {
    "sphere": 'type="sphere" size="0.05"',
    "capsule": 'type="capsule" size="0.03 0.08"',
    "box": 'type="box" size="0.06 0.04 0.05"',
}
params = st.floats(-1.0, 1.0).map(lambda x: round(x, 3))
vectors = st.tuples(params, params, params)


@st.composite
def trees(draw: st.DrawFn) -> str:
    """An MJCF of one to four moving bodies over a plane, most of it drawn at random."""
    n = draw(st.integers(1, 4))
    parents = [draw(st.integers(0, i)) for i in range(n)]
    motors: list[str] = []
    floating = draw(st.booleans())
    integrator = draw(st.sampled_from(["Euler", "implicitfast", "RK4"]))
    inside = _bodies(draw, 0, parents, floating, motors)
    tilt = " ".join(str(round(8 * x, 2)) for x in draw(vectors))
    return f"""
<mujoco>
  <option timestep="0.002" integrator="{integrator}"/>
  <worldbody><geom type="plane" size="0 0 1" euler="{tilt}" contype="1" conaffinity="2"/>{inside}</worldbody>
  <actuator>{"".join(motors)}</actuator>
</mujoco>"""


def _bodies(draw: st.DrawFn, parent: int, parents: list[int], floating: bool, motors: list[str]) -> str:
    return "".join(_body(draw, i + 1, parents, floating, motors) for i, above in enumerate(parents) if above == parent)


def _body(draw: st.DrawFn, index: int, parents: list[int], floating: bool, motors: list[str]) -> str:
    root = parents[index - 1] == 0
    place = [0.15 * x for x in draw(vectors)]
    place[2] += 0.35 if root else 0.0
    turn = " ".join(str(90 * x) for x in draw(vectors))
    joints = "<freejoint/>" if root and floating else _joint(draw, index, motors)
    touches = draw(st.booleans())
    contact = 'contype="2" conaffinity="0"' if touches else 'contype="0" conaffinity="0"'
    geom = f"<geom {_GEOMS[draw(st.sampled_from(sorted(_GEOMS)))]} {contact} condim='{draw(st.sampled_from([1, 3]))}'/>"
    inside = _bodies(draw, index, parents, floating, motors)
    where = " ".join(f"{x:.3f}" for x in place)
    return f'<body name="b{index}" pos="{where}" euler="{turn}">{joints}{geom}{inside}</body>'


def _joint(draw: st.DrawFn, index: int, motors: list[str]) -> str:
    kind = draw(st.sampled_from(["hinge", "hinge", "slide"]))
    axis = draw(vectors.filter(lambda v: np.linalg.norm(v) > 0.3))
    extras = draw(
        st.sets(st.sampled_from(['damping="0.2"', 'armature="0.01"', 'stiffness="1"', 'frictionloss="0.05"', "range"]))
    )
    limits = 'range="-20 30" limited="true"' if kind == "hinge" else 'range="-0.05 0.1" limited="true"'
    words = " ".join(limits if e == "range" else e for e in sorted(extras))
    driven = draw(st.sampled_from(["motor", "position", "none"]))
    name = f"j{index}"
    if driven == "motor":
        motors.append(f'<motor joint="{name}" gear="{1 + index}" ctrlrange="-1 1" ctrllimited="true"/>')
    if driven == "position":
        motors.append(f'<position joint="{name}" kp="5" kv="0.2" forcerange="-2 2" forcelimited="true"/>')
    return f'<joint name="{name}" type="{kind}" axis="{axis[0]} {axis[1]} {axis[2]}" {words}/>'


def _agrees(xml: str) -> None:
    model = mujoco.MjModel.from_xml_string(xml)
    if (reason := refusal(model)) is not None:
        assert "integrator implicitfast for the lone free joint" in reason
        return
    states = visited(exact(model), 64, seed=5, every=31)
    if np.abs(states.next_qvel).max() > 1e3:  # thrown far beyond what any robot does: rounding grows with it
        return
    with jax.enable_x64(True):
        ours = stepped(model, states)
    size = 1.0 + np.abs(states.next_qvel).max(axis=1)
    assert (np.abs(ours.qvel - states.next_qvel).max(axis=1) / size).max() < 1e-8


_ALL: Any = list(HealthCheck)


@settings(max_examples=3, deadline=None, suppress_health_check=_ALL, derandomize=True)
@given(trees())
def test_random_trees_move_as_in_c(xml: str) -> None:
    _agrees(xml)


@pytest.mark.slow
@settings(max_examples=100, deadline=None, suppress_health_check=_ALL)
@given(trees())
def test_many_random_trees_move_as_in_c(xml: str) -> None:
    _agrees(xml)


HIP = '<joint name="hip_f" axis="0 1 0"/>'
SHIN = '<geom class="leg" fromto="0 0 0 0 0 -0.16" mass="0.2"/>'
LINK = '<joint name="linked" joint1="hip_f" joint2="hip_b"/>'
LAZY = '<intvelocity name="lazy" joint="hip_f" kp="1" actrange="-1 1"/>'
LONE = """
<mujoco><option integrator="implicitfast"/><worldbody>
  <body><freejoint name="thrown"/><geom type="box" size="0.1 0.2 0.3"/></body>
</worldbody></mujoco>
"""
BALL = """
<mujoco><worldbody><body><joint type="ball" name="neck"/><geom size="0.1" mass="1"/></body></worldbody></mujoco>
"""


def _quadruped(change: tuple[str, str]) -> str:
    text = model_path("quadruped").read_text()
    assert change[0] in text
    return text.replace(*change, 1)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((HIP, HIP + '<joint name="loose" type="ball" range="0 45"/>'), "ball joint 'loose'"),
        (("</actuator>", f"</actuator><equality>{LINK}</equality>"), "linked"),
        (('integrator="Euler"', 'integrator="implicit"'), "integrator implicit"),
        (('cone="pyramidal"', 'cone="elliptic"'), "elliptic"),
        (('integrator="Euler"', 'integrator="Euler" density="1.2"'), "fluid"),
        ((SHIN, '<geom type="ellipsoid" size="0.1 0.1 0.1" name="egg" conaffinity="1"/>'), "egg"),
        (('condim="3"', 'condim="6"'), "torsional"),
        (("<sensor>", '<sensor><clock name="watch"/>'), "watch"),
        (('<position name="hip_f" joint="hip_f"/>', LAZY), "state of their own"),
    ],
)
def test_what_lanes_cannot_do_they_refuse_by_name(change: tuple[str, str], words: str) -> None:
    reason = refusal(mujoco.MjModel.from_xml_string(_quadruped(change)))
    assert reason is not None and words in reason and reason.endswith("supported")


def test_a_lone_free_body_is_refused_where_c_takes_its_gyroscopic_forces_implicitly() -> None:
    model = mujoco.MjModel.from_xml_string(LONE)
    reason = refusal(model)
    assert reason == "integrator implicitfast for the lone free joint 'thrown' is not supported"
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    assert refusal(model) is None


def test_auto_takes_mjx_for_what_lanes_refuse_and_lanes_alone_is_an_error() -> None:
    on_mjx = mjx_model(Robot.from_string(BALL, "ball.xml"), ())
    taken = choose_engine("auto", on_mjx)
    assert taken.engine == "mjx" and taken.reason == "ball joint 'neck' is not supported by the lanes engine"
    with pytest.raises(
        InputError, match="ball.xml: ball joint 'neck' is not supported by the lanes engine; use --engine"
    ):
        choose_engine("lanes", on_mjx)
    with pytest.raises(InputError, match="auto, lanes, c, mjx"):
        choose_engine("warp", on_mjx)


def test_lanes_that_differ_from_c_are_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = Agreement(states=32, physics_steps=2, median=0.2, high=0.4, largest=0.6)
    right = Agreement(32, 2, 0.0, 0.0, 0.0)
    monkeypatch.setattr(choice, "closed_loop_agreement", lambda s, *_, **__: right if s.choice.engine == "c" else wrong)
    short: Any = {"policy": RecurrentPolicy(), "rows": 5, "control_step": 0.01}
    instead = choice.closed_loop_simulator(robot("cartpole"), catalogue(["body_mass"]), **short)
    assert instead.choice.engine == "c" and "differs from plain MuJoCo" in instead.choice.reason
    with pytest.raises(InputError, match="use --engine c"):
        choice.closed_loop_simulator(robot("cartpole"), catalogue(["body_mass"]), **short, engine="lanes")


def test_replays_in_lanes_that_differ_from_c_are_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    wrong, right = (Agreement(32, 2, *errors) for errors in ((0.2, 0.4, 0.6), (0.0, 0.0, 0.0)))

    def compared(simulator: OpenLoopSimulator, *_: Any, **__: Any) -> Agreement:
        return right if isinstance(simulator, COpenLoop) else wrong

    monkeypatch.setattr(choice, "open_loop_agreement", compared)
    one, effects = robot("cartpole"), catalogue(["body_mass"])
    instead = choice.open_loop_simulator(one, effects, [one])
    assert instead.choice.engine == "c" and "differs from plain MuJoCo" in instead.choice.reason
    with pytest.raises(InputError, match="use --engine c"):
        choice.open_loop_simulator(one, effects, [one], engine="lanes")
