"""What a search asks before it goes on."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from estexp_jax.discovery import growing, stepwise_search
from estexp_jax.discovery.growing import Setting, Standing, at_odds
from estexp_jax.discovery.hypotheses import Free, Hypothesis, parameters_only
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import Explanation
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.stepwise_search import _added, _goes_on, _simplified, _unbound, select
from estexp_jax.discovery.verdict import verdict as verdict_of
from estexp_jax.physics.model.robot import Robot
from tests.discovery import planted


def problem(steps: int, joints: int = 1) -> Any:
    """After so many steps, with a chain of joints, each with a motor."""
    names, links = ["shoulder", "elbow", *map(str, range(2, joints))][:joints], ""
    for name in reversed(names):
        links = f'<body><joint name="{name}"/><geom size=".1"/>{links}</body>'
    motors = "".join(f'<motor name="{name}_motor" joint="{name}"/>' for name in names)
    xml = f"<mujoco><worldbody>{links}</worldbody><actuator>{motors}</actuator></mujoco>"
    return SimpleNamespace(counted=[steps], replayer=SimpleNamespace(robot=Robot.from_string(xml, "chain")))


def explanation(error: float) -> Explanation:
    return Explanation(Fit(Hypothesis((), ()), np.zeros(0), error**2), np.full(4, error**2 / 4.0))


def steps(result: Any) -> Any:
    """A search that comes to a result at once."""
    yield from ()
    return result


def test_more_effects_are_looked_for_where_some_explain_and_it_is_not_too_long() -> None:
    much, little = explanation(8.0), explanation(15.0)
    nominal = explanation(30.0)
    assert _goes_on(problem(10**8), much, nominal)
    assert not _goes_on(problem(10**8), little, nominal)
    assert not _goes_on(problem(10**9), much, nominal)
    assert not _goes_on(problem(2 * 10**8, joints=6), much, nominal)


def test_a_search_ends_where_everything_is_claimed() -> None:
    """`--effects` may name fewer effects than would explain all."""
    place = ("viscous_friction", "elbow")
    there = problem(0)
    there.places = (place,)
    best = explanation(4.0)
    fitted = Fit(Hypothesis((place,), ()), np.zeros(0), 16.0)
    steps = _added(Setting(Hypothesis((), ()), []), Standing(there, best, ()), [fitted], 2)
    with pytest.raises(StopIteration) as end:
        next(steps)
    assert end.value.value.chosen is best


@pytest.mark.parametrize("as_bent", [False, True])
def test_an_effect_is_looked_for_beside_what_is_fitted_where_that_is_asked(
    monkeypatch: pytest.MonkeyPatch, as_bent: bool
) -> None:
    bases = list[Fit]()

    def nothing(_: Any, base: Fit, *__: Any, **___: Any) -> Any:
        bases.append(base)
        yield from ()
        return []

    monkeypatch.setattr(growing, "extended", lambda *_: None)
    monkeypatch.setattr(growing, "looked_at", nothing)
    monkeypatch.setattr(growing, "at_first", nothing)
    there = problem(0)
    there.places = (("sensor_gain", "angle"),)
    free = Free("body_mass", "arm", "dm", 0, 0, -0.3, 0.3, 0.0, 0.03)
    bent = Fit(Hypothesis((), (free,)), np.array([0.2]), 60.0)
    found, search = Standing(there, explanation(8.0), ()), Setting(bent.hypothesis, [])
    assert not list(growing.grown_from(search, found, bent, "one effect", as_bent=as_bent))
    assert bases[0].vector == pytest.approx([0.2 if as_bent else 0.0])


@dataclass
class Nothing:
    """A comparison that `select` may pass on."""

    step: None = None
    rough: None = None

    def heard(self, _: Any) -> Any:
        return self


@pytest.mark.parametrize(
    ("helps", "looks"),
    [
        ((1, False), [(1, False), (2, False)]),
        ((1, True), [(1, False), (1, True), (2, False)]),
        (None, [(1, False), (1, True)]),
    ],
)
def test_what_shows_no_effect_from_values_as_modelled_is_looked_at_once_more(
    monkeypatch: pytest.MonkeyPatch, helps: tuple[int, bool] | None, looks: list[tuple[int, bool]]
) -> None:
    own, better, seen = explanation(8.0), explanation(4.0), list[tuple[int, bool]]()

    def added(_: Any, found: Standing, __: Any, n: int, *, as_bent: bool = False) -> Any:
        seen.append((n, as_bent))
        return steps(replace(found, chosen=better) if (n, as_bent) == helps else found)

    there: Any = Nothing()
    monkeypatch.setattr(stepwise_search, "folds_of", lambda *_: [])
    monkeypatch.setattr(stepwise_search, "about", lambda problem, _: problem)
    monkeypatch.setattr(stepwise_search, "fitted", lambda *_: steps(([own.fitted], there)))
    monkeypatch.setattr(stepwise_search, "as_fitted", lambda *_: [explanation(30.0)])
    monkeypatch.setattr(stepwise_search, "compared", lambda *_: steps(([own], there)))
    monkeypatch.setattr(stepwise_search, "_added", added)
    monkeypatch.setattr(stepwise_search, "_simplified", lambda _, found, __: steps(found))
    monkeypatch.setattr(stepwise_search, "_all_exchanged", lambda _, found, __: steps(found))
    with pytest.raises(StopIteration) as end:
        next(select(there, Hypothesis((), ()), 2))
    assert seen == looks
    assert end.value.value[0].chosen is (better if helps else own)


@pytest.mark.parametrize(("known", "alike", "exchanged"), [(2.0, 6.0, True), (6.0, 2.0, False)])
def test_an_effect_is_exchanged_for_what_one_comparison_finds_better(
    monkeypatch: pytest.MonkeyPatch, known: float, alike: float, exchanged: bool
) -> None:
    """By comparisons about different fits, with other doubts, errors differ several times."""

    def claims(name: str, error: float) -> Explanation:
        return Explanation(Fit(Hypothesis(((name, "elbow"),), ()), np.zeros(0), error**2), np.full(4, error**2 / 4.0))

    chosen, other = claims("cogging", known), claims("backlash", 4.0)
    judged = {"cogging": claims("cogging", alike), "backlash": other}

    def compared(_: Any, there: Any, fits: list[Fit], __: str) -> Any:
        return steps(([judged[f.hypothesis.places[0][0]] for f in fits], there))

    monkeypatch.setattr(stepwise_search, "without", lambda *_: (Hypothesis((), ()), [np.zeros(0)]))
    monkeypatch.setattr(stepwise_search, "grown_from", lambda *_: steps([other.fitted]))
    monkeypatch.setattr(stepwise_search, "compared", compared)
    found = Standing(problem(0), chosen, ())
    ends = stepwise_search._exchanged(Setting(Hypothesis((), ()), []), found, chosen.places[0])
    with pytest.raises(StopIteration) as end:
        next(ends)
    assert end.value.value.chosen is (other if exchanged else chosen)


@pytest.mark.parametrize(
    ("left", "n", "k", "added"),
    [
        (40.0, 4, 113.0, "armature"),
        (40.0, 4, 60.0, "external_force"),
        (40.0, 3, 113.0, "external_force"),
        (8.0, 4, 113.0, "external_force"),
    ],
)
def test_a_fourth_effect_that_is_as_large_as_it_may_be_is_not_added_where_much_is_left(
    monkeypatch: pytest.MonkeyPatch, left: float, n: int, k: float, added: str
) -> None:
    """Seen: as stiff a spring to the world as there may be, which lost a real pendulum as it swung up."""
    old = tuple(("coulomb_friction", f"joint{i}") for i in range(n - 1))

    def claiming(share: float, place: tuple[str, str], **values: float) -> Explanation:
        free = tuple(Free(*place, name, 0, 0, -30.0, 113.0, 0.0, np.inf) for name in values)
        hypothesis = Hypothesis((*old, place), free)
        return Explanation(Fit(hypothesis, np.array([*values.values()]), 1.0), np.full(4, share * left**2 / 4.0))

    before = Explanation(Fit(Hypothesis(old, ()), np.zeros(0), 2.0), np.full(4, left**2 / 4.0))
    judged = [claiming(0.7, ("armature", "joint0"), I=113.0), claiming(0.6, ("external_force", "arm"), x=0.1, k=k)]
    monkeypatch.setattr(stepwise_search, "grown_from", lambda *_, **__: steps([e.fitted for e in judged]))
    monkeypatch.setattr(stepwise_search, "compared", lambda *_: steps(([before, *judged], problem(0))))
    with pytest.raises(StopIteration) as end:
        next(_added(Setting(Hypothesis((), ()), []), Standing(problem(0), before, ()), [before.fitted], n))
    assert end.value.value.chosen.places[-1][0] == added
    assert end.value.value.tried == (tuple(judged) if added == "external_force" else tuple(judged[:1]))


@pytest.mark.parametrize(("claims", "share", "added"), [(True, 0.99, False), (True, 0.5, True), (False, 0.99, True)])
def test_one_effect_more_must_help_the_windows_that_it_is_fitted_to(
    monkeypatch: pytest.MonkeyPatch, claims: bool, share: float, added: bool
) -> None:
    """Seen: a torque of 0.0001 N m beside a law that left nothing but noise, for what held-out windows made of it."""
    old = (("motor_fade", "servo"),) if claims else ()

    def fitted_to(cost: float, held_out: float, *places: tuple[str, str]) -> Explanation:
        return Explanation(Fit(Hypothesis(places, ()), np.zeros(0), cost), np.full(4, held_out / 4.0))

    before, after = fitted_to(1.0, 600.0, *old), fitted_to(share, 60.0, *old, ("torque_offset", "shaft"))
    monkeypatch.setattr(stepwise_search, "grown_from", lambda *_, **__: steps([after.fitted]))
    monkeypatch.setattr(stepwise_search, "compared", lambda *_: steps(([before, after], problem(0))))
    with pytest.raises(StopIteration) as end:
        next(_added(Setting(Hypothesis((), ()), []), Standing(problem(0), before, ()), [before.fitted], 1 + claims))
    assert end.value.value.chosen is (after if added else before)
    assert end.value.value.tried == (after,)


def test_forms_of_one_effect_and_laws_beside_names_of_a_motor_make_no_sense() -> None:
    fade, heat, sag = ((name, "hip") for name in ("motor_fade", "motor_heat", "law_sag"))
    assert at_odds(fade, heat) and at_odds(sag, heat) and at_odds(fade, sag)
    assert not at_odds(sag, ("motor_fade", "knee")) and not at_odds(fade, ("torque_saturation", "hip"))
    assert not at_odds(("law_drift", "angle"), ("sensor_bias", "angle")), "an offset may drift"


def test_a_value_that_is_bent_far_is_claimed_if_windows_are_predicted_no_worse(monkeypatch: pytest.MonkeyPatch) -> None:
    place = ("viscous_friction", "elbow")
    free = Free(*place, "c", 0, 0, -0.3, 0.3, 0.0, 0.03)
    hypothesis, asked = Hypothesis((), (free,)), list[Any]()
    there, search, alike = problem(0, joints=2), Setting(hypothesis, []), ("viscous_friction", "*")
    drags = ("back_emf", "elbow_motor")
    there.places = (place, alike, ("armature", "elbow"), drags, ("back_emf", "shoulder_motor"))

    def bent(value: float) -> Standing:
        return Standing(there, Explanation(Fit(hypothesis, np.array([value]), 1.0), np.full(4, 0.28)), ())

    def judged(error: float) -> Any:
        def steps(*_: Any) -> Any:
            yield
            claimed = Hypothesis((place,), (replace(free, high=5.0, spread=np.inf),))
            return [Explanation(Fit(claimed, np.array([0.9]), error**2), np.full(4, error**2 / 4.0))]

        return steps

    monkeypatch.setattr(stepwise_search, "extended", lambda *arguments: (asked.append(arguments), []))
    monkeypatch.setattr(stepwise_search, "about", lambda problem, _: problem)
    for value, error, claimed in ((0.2, 0.9, False), (0.29, 0.9, True), (0.29, 1.2, False), (-0.29, 0.9, True)):
        monkeypatch.setattr(stepwise_search, "judged_apart", judged(error))
        steps, begin = _unbound(search, bent(value)), len(asked)
        with pytest.raises(StopIteration) as end:
            while True:
                next(steps)
        assert (len(asked) > begin) == (abs(value) > 0.24)
        assert (end.value.value.chosen.places == (place,)) == claimed
    assert {looked for *_, looked in asked} == {place, alike, drags}
    for _, _, base, _ in asked:
        assert base.vector == pytest.approx(0.0), "values bent to stand in for it are no place to begin"


def test_beside_an_effect_a_value_at_its_bound_is_claimed_where_only_noise_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Elbow's motor bent to its bound beside a moved centre of mass, which fits as well with the motor claimed."""
    moved, weak = ("com_shift", "upper"), ("motor_weakness", "elbow_motor")
    loss, own = Free(*weak, "loss", 0, 0, -0.3, 0.3, 0.0, 0.03), Free(*moved, "x", 0, 0, -1.0, 1.0, 0.0, np.inf)
    there, search = problem(0, joints=2), Setting(Hypothesis((), (loss,)), [])
    there.places = (moved, weak)
    bent = Explanation(Fit(Hypothesis((moved,), (loss, own)), np.array([0.3, 0.04]), 0.1), np.full(4, 0.025))
    both = Hypothesis((moved, weak), (own, replace(loss, high=0.9, spread=np.inf)))
    starts = list[Any]()

    def extended(_: Any, __: Any, base: Fit, place: Any) -> Any:
        starts.append(base.vector)
        return both, [base.vector]

    def judged(_: Any, __: Any, tasks: Any, stage: str) -> Any:
        yield
        assert len(tasks) == 1, "what is claimed already is not asked for again"
        return [Explanation(Fit(both, np.array([0.028, 0.39]), 0.1), np.full(4, 0.0251))]

    monkeypatch.setattr(stepwise_search, "extended", extended)
    monkeypatch.setattr(stepwise_search, "about", lambda problem, _: problem)
    monkeypatch.setattr(stepwise_search, "judged_apart", judged)
    steps = _unbound(search, Standing(there, bent, ()))
    with pytest.raises(StopIteration) as end:
        while True:
            next(steps)
    found = end.value.value.chosen
    assert found.places == (moved, weak)
    np.testing.assert_allclose(starts, [[0.0, 0.04]], err_msg="bent values are no place to begin, claims are")

    def fewer(*_: Any) -> Any:
        yield
        return [bent]

    monkeypatch.setattr(stepwise_search, "simpler", lambda *_: [bent.fitted])
    monkeypatch.setattr(stepwise_search, "judged_apart", fewer)
    steps = _simplified(search, Standing(there, found, ()), lambda _: True)
    with pytest.raises(StopIteration) as end:
        while True:
            next(steps)
    assert end.value.value.chosen is found, "to bend a value far is not simpler than to claim it"


def test_what_could_be_instead_is_made_simpler_like_what_was_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    """A joint's offset and its encoder's bias say the same; Stribeck friction beside them turns out to be plain."""
    rich, plain, third = ("stribeck_friction", "hip"), ("coulomb_friction", "hip"), ("armature", "knee")
    offset, bias = ("joint_offset", "knee"), ("sensor_bias", "angle")
    names = {rich: ("T", "S"), plain: ("T",), offset: ("x",), bias: ("bias",), third: ("I",)}

    def fitted(places: Any, squared: float, value: float = 0.1) -> Explanation:
        free = tuple(Free(p[0], p[1], n, 0, 0, -1.0, 1.0, 0.0, np.inf) for p in places for n in names[p])
        return Explanation(Fit(Hypothesis(places, free), np.full(len(free), value), squared), np.full(4, squared / 4.0))

    chosen, twin, worse = fitted((rich, offset), 4.0), fitted((rich, bias), 4.02, 0.7), fitted((rich, third), 4.4)
    simple, asked = fitted((plain, offset), 4.1), list[Any]()

    def instead(_: Any, __: Any, base: Fit, old: Any, new: Any, values: Any) -> Any:
        asked.append((base, old, new, values))
        return fitted((plain, bias), 4.1).fitted.hypothesis, []

    def judged(_: Any, __: Any, tasks: Any, stage: str) -> Any:
        yield
        return [fitted((plain, bias), 4.12)] if "instead" in stage else [simple]

    monkeypatch.setattr(stepwise_search, "instead", instead)
    monkeypatch.setattr(stepwise_search, "about", lambda problem, _: problem)
    monkeypatch.setattr(stepwise_search, "judged_apart", judged)
    for helps in (True, False):
        left = iter([[simple.fitted], []] if helps else [[]])
        monkeypatch.setattr(stepwise_search, "simpler", lambda *_, left=left: next(left))
        there = Standing(problem(0), chosen, (chosen, twin, worse))
        steps = _simplified(Setting(Hypothesis((), ()), []), there, lambda _: True)
        with pytest.raises(StopIteration) as end:
            while True:
                next(steps)
        found = end.value.value
        assert found.chosen is (simple if helps else chosen)
        assert [set(e.places) for e in found.tried[3:]] == ([{plain, offset}, {plain, bias}] if helps else [])
    assert asked == [(simple.fitted, offset, bias, [[0.7]])]


@pytest.mark.parametrize(("enough", "simpler"), [(4.2, True), (4.05, False), (3.0, True)])
def test_what_explains_is_not_made_so_simple_that_it_explains_nothing(
    monkeypatch: pytest.MonkeyPatch, enough: float, simpler: bool
) -> None:
    """Where nothing explains enough, the simplest of what is as good stands."""
    rich, poor = explanation(4.0), explanation(4.1)
    left = iter([[poor.fitted], []])
    monkeypatch.setattr(stepwise_search, "about", lambda problem, _: problem)
    monkeypatch.setattr(stepwise_search, "judged_apart", lambda *_: steps([poor]))
    monkeypatch.setattr(stepwise_search, "simpler", lambda *_: next(left))
    found = _simplified(Setting(Hypothesis((), ()), []), Standing(problem(0), rich, ()), lambda e: e.error <= enough)
    with pytest.raises(StopIteration) as end:
        while True:
            next(found)
    assert end.value.value.chosen is (poor if simpler else rich)


@pytest.mark.parametrize(("doubted", "verdict", "error"), [(0.9, "consistent", 0.9), (2.0, "parameters", 24.0)])
def test_a_model_that_only_the_doubt_about_its_step_parts_from_recordings_lacks_nothing(
    monkeypatch: pytest.MonkeyPatch, doubted: float, verdict: str, error: float
) -> None:
    """In a window in which motions part, the step's error is in more doubt than it is large."""
    case = planted.case_of("one", planted.Plant(), 743)
    there = planted.problem_of(case, replace(planted.CONFIG, effects=("viscous_friction",)))
    parameters = parameters_only(planted.nominal("one"), there.replayer.catalogue)

    def judged(problem: Problem, fits: list[Fit], _: list[Any]) -> list[Explanation]:
        left = 27.0 if problem.step is None else 24.0 if problem.rough is None else doubted
        return [Explanation(fit, np.full(4, left**2 / 4)) for fit in fits]

    def compared(_: Setting, problem: Problem, fits: list[Fit], *__: Any) -> Any:
        yield from ()
        return judged(problem, fits, []), problem

    monkeypatch.setattr(stepwise_search, "as_fitted", judged)
    monkeypatch.setattr(stepwise_search, "compared", compared)
    selection, _ = planted.finished(select(there, parameters, 0))
    assert selection.corrected.error == pytest.approx(error)
    assert verdict_of(planted.nominal("one"), selection, ()) == verdict
