"""Effects that begin part-way act only from there on, are named and dated, and cost nothing where there are none."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from estexp_jax.discovery import explain as module
from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.hypotheses import claiming, parameters_only
from estexp_jax.discovery.onset_by_values import parted
from estexp_jax.discovery.onset_claims import starting_late
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.discovery.slopes import Fit
from estexp_jax.estimation.windows import window_rows
from estexp_jax.physics.recording import Recording
from tests.discovery.planted import (
    CASES,
    CONFIG,
    RATE,
    XML,
    Plant,
    case_of,
    commands,
    explained,
    finished,
    nominal,
    problem_of,
)

LENGTH = 6.0
BEGAN = (2.3, 3.7, 3.05)
TORQUE = 0.3


def late_recording(seed: int, began: float, role: str, torque: float = TORQUE, loss: float = 0.0) -> Recording:
    """A servo's arm, simulated by C at a fifth of the step, that resists its motion or is weaker from some time on."""
    model = mujoco.MjModel.from_xml_string(XML["one"])
    model.opt.timestep /= 5
    data, rng, n = mujoco.MjData(model), np.random.default_rng(seed), round(LENGTH * RATE)
    servo, bias = model.actuator_gainprm[0, 0].copy(), model.actuator_biasprm[0].copy()
    command, angles = commands(rng, np.arange(n) / RATE, np.array([1.2])), np.zeros((n, 1))
    for k in range(n):
        angles[k], data.ctrl[:] = data.qpos, command[k]
        late = k / RATE >= began
        left = 1.0 - loss * late
        model.dof_frictionloss[0] = torque * late
        model.actuator_gainprm[0, 0], model.actuator_biasprm[0] = servo * left, bias * left
        for _ in range(10):
            mujoco.mj_step(model, data)
    quantum, nothing = 2.0 * np.pi / 2**12, np.full((n, 1), np.nan)
    read = np.round((angles + 2e-4 * rng.standard_normal(angles.shape)) / quantum) * quantum
    return Recording(f"{role}_{seed}.csv", np.arange(n) / RATE, command, np.ones((n, 1)), read, nothing, nothing, role)


@pytest.fixture(scope="module")
def case() -> Case:
    found = [late_recording(900 + i, t, "train") for i, t in enumerate(BEGAN)]
    return Case(nominal("one"), (*found, late_recording(903, -1.0, "test")), (nominal("one"),) * 4)


def test_a_cut_begins_a_window_and_leaves_all_rows_in_order():
    time = np.arange(500) / 100.0
    rows = window_rows(time, 2.0, 2.5)
    assert rows == [(0, 199), (200, 249), (250, 399), (400, 499)]
    assert window_rows(time, np.inf, 2.5) == [(0, 249), (250, 499)]
    assert window_rows(time, 2.0, 2.0) == window_rows(time, 2.0)
    for cut in (1.995, 3.995, 4.985):  # a lone row joins its neighbour
        found = window_rows(time, 2.0, cut)
        assert [a for a, _ in found[1:]] == [b + 1 for _, b in found[:-1]] and all(b > a for a, b in found)


def test_before_the_onset_nothing_claimed_acts():
    whole = problem_of(case_of("one", Plant(), 12, trains=1))
    late = starting_late(case_of("one", Plant(), 12, trains=1), CONFIG, whole, {0: 0.8})
    own = parameters_only(whole.replayer.robot, whole.replayer.catalogue)
    claim = claiming(whole.replayer.robot, own, [("viscous_friction", "shaft")])
    vector = claim.with_values(("viscous_friction", "shaft"), [0.3])
    windows = late.windows_of([0])
    assert [s.first for s in late.segments if s.recording == 0] == [0, 80, 125]
    damped, free = (late.simulated([m], windows)[0] for m in ((claim, vector), (own, own.start())))
    changed = np.nanmax(np.abs(damped - free), axis=(1, 2))
    assert changed[0] == 0.0 and changed[1] > 0.01 and changed[2] > 0.01
    test = late.windows_of([1])
    assert (
        np.nanmax(np.abs(late.simulated([(claim, vector)], test) - late.simulated([(own, own.start())], test))) > 0.01
    )
    assert claim.unclaimed(vector) == pytest.approx(claim.start())


def test_laws_are_looked_for_in_the_windows_of_the_selection_not_those_of_refined_dates(monkeypatch):
    one = case_of("one", Plant(), 12, trains=1)
    whole = problem_of(one)
    late = starting_late(one, CONFIG, whole, {0: 0.8})
    refined = starting_late(one, CONFIG, whole, {0: 1.25})
    assert len(late.fitted) != len(refined.fitted), "one cut coincides with the end of a window"
    own = parameters_only(whole.replayer.robot, whole.replayer.catalogue)
    seen = []

    def looked(unnamed, _):
        seen.append(unnamed.problem)
        yield from ()

    monkeypatch.setattr(module, "needed", lambda *_: True)
    monkeypatch.setattr(module, "doubled", lambda *_: None)
    monkeypatch.setattr(module, "manifold", lambda *_: None)
    monkeypatch.setattr(module, "unknown_law", looked)
    nothing = Explanation(Fit(own, own.start(), 0.0), np.ones(len(late.fitted)))
    selection = Selection(nothing, nothing, nothing, (), nothing)
    finished(module._unnamed(one, CONFIG, whole, module._Named(selection, late, {0: 1.25}, None), own))
    assert len(seen[0].fitted) == len(late.fitted)


def test_values_fitted_to_the_beginnings_tell_when_something_begins(case):
    problem = problem_of(case)
    own = parameters_only(problem.replayer.robot, problem.replayer.catalogue)
    began = finished(parted(case, problem, own))
    assert np.array(list(began.values())) == pytest.approx(BEGAN, abs=0.25)


@pytest.mark.parametrize("name", ["nothing", "coulomb_friction@shaft"])
def test_what_is_there_from_the_start_or_never_has_no_beginning(name):
    robot, plant, seed = CASES[name]
    whole = case_of(robot, plant, seed + 421, length=6.0)
    problem = problem_of(whole)
    own = parameters_only(problem.replayer.robot, problem.replayer.catalogue)
    assert finished(parted(whole, problem, own)) == {}


@pytest.mark.slow
def test_a_motor_that_weakens_part_way_is_no_motor_that_fades():
    recordings = [late_recording(910 + i, t, "train", 0.0, 0.35) for i, t in enumerate(BEGAN)]
    weak = Case(nominal("one"), (*recordings, late_recording(913, -1.0, "test", 0.0, 0.35)), (nominal("one"),) * 4)
    few = ("motor_weakness", "motor_fade", "motor_heat")
    findings = explained(weak, replace(CONFIG, most=1, effects=few)).findings
    assert [w["effect"] for w in findings["what"]] == ["motor_weakness"]
    assert findings["what"][0]["parameters"]["loss"]["value"] == pytest.approx(0.35, rel=0.1)
    assert np.array(list(findings["when"]["onset_s"].values())) == pytest.approx(BEGAN, abs=0.08)  # windows have 0.2 s


def test_what_begins_part_way_does_not_come_on_by_itself():
    one = case_of("one", Plant(), 12, trains=1)
    places = tuple((name, "servo") for name in ("motor_weakness", "motor_fade", "motor_heat"))
    late = starting_late(one, CONFIG, replace(problem_of(one), places=places), {0: 0.8})
    assert late.places == places[:1]


@pytest.mark.slow
def test_what_begins_part_way_is_named_and_dated(case):
    findings = explained(case, replace(CONFIG, most=1)).findings
    assert findings["verdict"] == "missing_physics"
    assert [(w["effect"], w["name"]) for w in findings["what"]] == [("coulomb_friction", "shaft")]
    assert findings["what"][0]["parameters"]["T"]["value"] == pytest.approx(TORQUE, rel=0.1)
    told = list(findings["when"]["onset_s"].values())
    assert np.median(np.abs(np.array(told) - BEGAN)) < 0.02 * LENGTH
    assert findings["fit"]["explained"]["train"] < 0.5 * findings["fit"]["parameters_only"]["train"]
    assert findings["fit"]["gain"]["value"] > 0.8
