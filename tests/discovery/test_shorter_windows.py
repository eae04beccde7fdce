"""Where teeth of cogging hold a joint now here, now there, shorter windows show which cogging it is."""

from collections.abc import Generator
from dataclasses import replace
from unittest.mock import patch

import mujoco
import numpy as np
import pytest

from estexp_jax.discovery import comparison, shorter_windows
from estexp_jax.discovery import explain as explain_module
from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.fitting import FAR, Progress
from estexp_jax.discovery.hypotheses import claiming, parameters_only
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import Explanation, Selection, folds_of
from estexp_jax.discovery.shorter_windows import as_nearer, bent, hangs_on_hairs, says_all, shows_unparted
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.verdict import QUIET
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from tests.discovery.planted import CASES, CONFIG, XML, Plant, case_of, explained, finished, nominal, problem_of

_SERVO = '<position name="servo" joint="shaft" kp="4" kv="0.1" forcerange="-3 3"/>'
TEETH, STRENGTH, PHASE = 14.0, 0.3, 0.8
FEW = replace(CONFIG, effects=("viscous_friction", "coulomb_friction", "cogging"), most=1)


def asked(case: Case) -> tuple[list[bool], dict[str, float]]:
    """Whether shorter windows were found worth a try, if that was asked; values of the first finding."""
    answers = list[bool]()

    def spy(problem: Problem, selection: Selection) -> bool:
        assert selection.chosen.error > FAR
        answers.append(hangs_on_hairs(problem, selection))
        return answers[-1]

    with patch.object(explain_module, "hangs_on_hairs", spy):
        [first, *_] = explained(case, FEW).findings["what"]
    return answers, {name: p["value"] for name, p in first["parameters"].items()}


def teeth(_: float, q: np.ndarray, __: np.ndarray) -> list[float]:
    return [0.0, STRENGTH * np.sin(TEETH * q[1] + PHASE)]


@pytest.mark.slow
def test_shorter_windows_find_teeth_that_throw_the_joint_about():
    answers, found = asked(case_of("two", Plant(law=teeth), 661))
    assert answers == [True]
    assert found["A"] == pytest.approx(STRENGTH, rel=0.05)
    assert found["n"] == pytest.approx(TEETH, rel=2e-3), "as near as if no motion had parted"
    assert found["phase"] == pytest.approx(PHASE, abs=0.2), "at zero, turns away from where the joint is thrown to"


@pytest.mark.slow
def test_shorter_windows_find_the_law_of_such_teeth_where_it_has_no_name():
    nameless = replace(FEW, effects=("viscous_friction", "coulomb_friction"))
    [law] = explained(case_of("two", Plant(law=teeth), 665), nameless).findings["what"]
    assert (law["effect"], law["name"]) == ("unknown_law", "elbow")
    values = {name: p["value"] for name, p in law["parameters"].items()}
    assert values == pytest.approx({"A": STRENGTH, "n": TEETH, "phase": PHASE}, rel=0.1)
    assert values["n"] == pytest.approx(TEETH, rel=5e-3)


@pytest.mark.slow
def test_a_servo_that_holds_its_joint_needs_no_shorter_windows():
    def pull(time: float, _: np.ndarray, __: np.ndarray) -> list[float]:
        return [0.5 * np.sign(np.sin(9.0 * time))]

    answers, _ = asked(case_of("one", Plant('damping="0.02"', 'damping="0.12"', law=pull), 642))
    assert answers == [False]


def test_starts_that_are_known_exactly_part_nowhere():
    problem = problem_of(case_of("two", Plant(), 643), FEW)
    replays = problem.replays
    exact = tuple(replace(s, start=s.start._replace(covariance=None)) for s in replays.cut.whole)
    problem = replace(problem, replays=replace(replays, cut=replays.cut._replace(whole=exact)))
    own = parameters_only(problem.replayer.robot, problem.replayer.catalogue)
    far = Explanation(Fit(own, own.start(), 1.0), np.full(len(problem.fitted), 2.0 * FAR**2))
    assert not hangs_on_hairs(problem, Selection(far, far, far, (), far))


def test_where_the_usual_windows_took_long_shorter_ones_are_not_tried(monkeypatch: pytest.MonkeyPatch):
    problem = problem_of(case_of("two", Plant(), 644), FEW)
    monkeypatch.setattr(shorter_windows, "_parting", lambda problem, _: np.ones(len(problem.fitted)))
    own = parameters_only(problem.replayer.robot, problem.replayer.catalogue)
    far = Explanation(Fit(own, own.start(), 1.0), np.full(len(problem.fitted), 2.0 * FAR**2))
    selection = Selection(far, far, far, (), far)
    assert hangs_on_hairs(problem, selection)
    problem.counted[0] = 10**9  # steps of a robot with two joints
    assert not hangs_on_hairs(problem, selection)


@pytest.mark.parametrize(("usual", "nearer", "flattered"), [("coulomb", "viscous", 1e3), ("viscous", "coulomb", 1e-3)])
def test_what_shorter_windows_choose_and_the_usual_choice_are_judged_by_one_comparison(usual, nearer, flattered):
    """Each as another comparison may have it, by which the wrong one seems better."""
    problem = problem_of(case_of("one", CASES["coulomb_friction@shaft"][1], 645), FEW)
    robot, parameters = problem.replayer.robot, parameters_only(problem.replayer.robot, problem.replayer.catalogue)

    def fit_of(name: str) -> Fit:
        hypothesis = claiming(robot, parameters, ((f"{name}_friction", "shaft"),))
        return Fit(hypothesis, hypothesis.with_values(hypothesis.places[0], [0.05]), 1.0)

    before = Explanation(fit_of(usual), np.full(len(problem.fitted), flattered))
    named = Selection(before, before, before, (before,), before)
    found, _ = finished(as_nearer(problem, named, fit_of(nearer)))
    assert found.chosen.places == (("coulomb_friction", "shaft"),)
    if nearer == "coulomb":
        old, new = found.tried
        assert new is found.chosen and old.error > 2.0 * new.error


RUBS, TEETHED = (("coulomb_friction", "elbow"),), (("cogging", "elbow"),)


@pytest.mark.parametrize(
    ("usual", "nearer", "enough"),
    [
        ((RUBS, 30.0), ((), 0.9), True),  # seen: an arm that falls about, as modelled, of which much was claimed
        ((RUBS, 30.0), ((), 1.4), False),
        ((RUBS, 8.0), ((), 0.9), False),
        ((RUBS, 8.0), (RUBS, 0.9), False),
        ((RUBS, 8.0), (TEETHED, 0.9), True),
        ((RUBS, 8.0), (TEETHED, 1.4), False),
        (((), 8.0), ((), 0.9), True),
    ],
)
def test_shorter_windows_say_all_where_they_leave_only_noise_and_nothing_is_given_up_for_it(usual, nearer, enough):
    robot = nominal("two")
    parameters = parameters_only(robot, catalogue(FEW.effects))

    def chosen(places: tuple[tuple[str, str], ...], error: float) -> Selection:
        hypothesis = claiming(robot, parameters, places)
        one = Explanation(Fit(hypothesis, hypothesis.start(), error**2), np.full(4, error**2 / 4.0))
        return Selection(one, one, one, (one,), one)

    assert says_all(chosen(*nearer), chosen(*usual)) is enough


@pytest.mark.parametrize(
    ("truth", "size", "parted", "kept"),
    [
        ("nothing, two joints", 0.05, [], True),  # motions stay together
        ("nothing, two joints", 0.05, [1, 4], False),
        ("coulomb_friction@elbow", 0.05, [1, 4], True),  # it shows in the others, too
        ("coulomb_friction@elbow", 0.05, [0, 1, 3, 4], False),  # too few are left
        ("coulomb_friction@elbow", 0.05, range(6), False),
        ("coulomb_friction@elbow", 0.0, [1, 4], False),
    ],
)
def test_what_shows_only_where_motions_part_does_not_stay(monkeypatch, truth, size, parted, kept):
    robot, (_, plant, seed) = nominal("two"), CASES[truth]
    problem = problem_of(case_of("two", plant, seed + 40), replace(CONFIG, effects=FEW.effects))
    parameters = parameters_only(robot, catalogue(FEW.effects))
    rubs = claiming(robot, parameters, [("coulomb_friction", "elbow")])
    vector = np.where([f.effect == "coulomb_friction" for f in rubs.free], size, rubs.start())
    fits = [Fit(parameters, parameters.start(), 1.0), Fit(rubs, vector, 1.0)]
    there = about(problem, fits[0])
    order = np.concatenate([held for _, held in folds_of(there)])
    left = there.residuals([fit.member for fit in fits], order)
    without, chosen = (
        Explanation(fit, np.square(r, dtype=np.float64).sum(axis=1)) for fit, r in zip(fits, left, strict=True)
    )
    monkeypatch.setattr(shorter_windows, "bent", lambda *_: np.where(np.isin(np.arange(6), parted), 20.0, 0.1))
    assert shows_unparted(there, Selection(without, without, without, (chosen,), chosen)) is kept


def test_values_fitted_to_a_window_in_which_motions_part_make_nothing_show_in_others(monkeypatch):
    """They are wrong there; as it is, the model lacks nothing in these."""
    robot = nominal("two")
    problem = problem_of(case_of("two", Plant(), 741), replace(CONFIG, effects=FEW.effects))
    parameters = parameters_only(robot, catalogue(FEW.effects))
    rubs = claiming(robot, parameters, [("coulomb_friction", "elbow")])
    own, other = (Fit(h, h.start(), 1.0) for h in (parameters, rubs))
    there = about(problem, own)
    order = np.concatenate([held for _, held in folds_of(there)])
    fallen = order == order[1]

    def with_errors(fit: Fit, error: float, where_fallen: float) -> Explanation:
        return Explanation(fit, np.square(np.where(fallen, where_fallen, error)) / len(order))

    monkeypatch.setattr(shorter_windows, "bent", lambda *_: np.where(np.sort(problem.fitted) == order[1], 20.0, 0.1))
    as_it_is, pulled, chosen = with_errors(own, 1.0, 50.0), with_errors(own, 4.0, 48.0), with_errors(other, 0.8, 6.0)
    assert not shows_unparted(there, Selection(as_it_is, as_it_is, pulled, (chosen,), chosen))
    assert shows_unparted(there, Selection(pulled, pulled, pulled, (chosen,), chosen)), "it lacks as much as it is"


def released(robot: Robot, angle: float, seed: int) -> Recording:
    """What an encoder of 12 bits reads of a pendulum let go somewhere."""
    data, rng, quantum = mujoco.MjData(robot.model), np.random.default_rng(seed), 2.0 * np.pi / 2**12
    data.qpos[:], read = angle, np.zeros((126, 1))
    for row in read:
        row[:] = np.round((data.qpos + 2e-4 * rng.standard_normal(1)) / quantum) * quantum
        mujoco.mj_step(robot.model, data, 2)
    nothing = np.full_like(read, np.nan)
    return Recording(
        "let go", 0.01 * np.arange(len(read)), 0.0 * read, 1.0 + 0.0 * read, read, nothing, nothing, "train"
    )


def test_only_a_pendulum_that_may_fall_to_either_side_is_far_from_linear_in_its_start():
    pole = Robot.from_string(XML["one"].replace(_SERVO, '<motor name="servo" joint="shaft" ctrlrange="-1 1"/>'))
    recordings = tuple(released(pole, angle, 742) for angle in (0.5, np.pi - 1e-3, -1.0))
    problem = comparison.problem_of(Case(pole, recordings, (pole,) * 3), FEW, {})
    parameters = parameters_only(pole, problem.replayer.catalogue)
    there = about(problem, Fit(parameters, parameters.start(), 1.0))
    hangs, stands, also_hangs = bent(there, (parameters, parameters.start()))
    assert stands > 3.0 > 0.3 > max(hangs, also_hangs)


@pytest.mark.parametrize("asked", ["at once", pytest.param("at last", marks=pytest.mark.slow), "never"])
def test_what_shows_only_in_long_windows_in_which_motions_part_is_no_mismatch(monkeypatch, asked):
    """Asked at once, no law is looked for; at last, none was found."""
    looked = []

    def no_law(*_: object) -> Generator[Progress, None, None]:
        looked.append(True)
        return None
        yield

    def hanging(_: Problem, selection: Selection, well: float = FAR) -> bool:
        assert selection.chosen.error > QUIET
        return asked == "at once" if well == FAR else asked == "at last"

    def nudge(time: float, _: np.ndarray, __: np.ndarray) -> list[float]:
        return [0.0, 0.004 * np.sign(np.sin(4.0 * time))]

    monkeypatch.setattr(explain_module, "hangs_on_hairs", hanging)
    monkeypatch.setattr(explain_module, "unknown_law", no_law)
    config = replace(CONFIG, effects=("armature",), most=1)
    findings = explained(case_of("two", Plant(law=nudge), 773), config).findings
    assert findings["verdict"] == ("unexplained" if asked == "never" else "consistent")
    assert looked == ([] if asked == "at once" else [True])
