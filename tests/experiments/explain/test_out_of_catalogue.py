"""Laws that the catalogue lacks: what the set holds, how forces are compared, what scores count."""

import json

import numpy as np
import pytest

from estexp_jax.physics.effects.registry import effect
from experiments.benchmark.generator.catalogue import CATALOGUE, OTHERS
from experiments.benchmark.generator.making import make
from experiments.explain.out_of_catalogue.figure import explained
from experiments.explain.out_of_catalogue.forces import FORCES
from experiments.explain.out_of_catalogue.plans import LEFT, left_out, planned
from experiments.explain.out_of_catalogue.scores import measured, write_scores
from experiments.explain.out_of_catalogue.study import force_error


def test_with_an_effect_goes_its_whole_ladder() -> None:
    by_name = {p.planted[0].effect: left_out(p) for p in planned(2)}
    assert set(by_name) == {*LEFT, *OTHERS}
    friction = ("coulomb_friction", "hysteresis", "smooth_friction", "stribeck_bristles", "stribeck_friction")
    friction = ("asymmetric_friction", *friction)
    assert by_name["coulomb_friction"] == by_name["stribeck_friction"] == by_name["hysteresis"] == friction
    assert by_name["joint_stiffness"] == ("joint_stiffness", "torque_offset") and by_name["cogging"] == ("cogging",)
    assert by_name["joint_jam"] == by_name["back_emf"] == ("back_emf", "joint_jam", "viscous_friction")
    assert by_name["quadratic_drag"] == ("asymmetric_damping", "quadratic_drag", "viscous_friction")
    assert by_name["viscous_friction"] == tuple(sorted({*by_name["quadratic_drag"], *by_name["back_emf"]}))
    assert by_name["joint_offset"] == ("com_shift", "gravity_tilt", "joint_offset")
    assert all(by_name[law] == () for law in OTHERS)
    for names in by_name.values():
        assert all(effect(name) for name in names)


@pytest.mark.parametrize("law", OTHERS)
def test_a_law_of_no_catalogue_moves_the_robot_otherwise(law: str) -> None:
    plan = next(p for p in planned(7, "own") if p.planted[0].effect == law)
    case = make(plan, shorter=0.15, refit=False)
    assert [r.name for r in case.recorded] == ["train_0.csv", "train_1.csv", "train_2.csv", "test_0.csv", "test_1.csv"]
    assert case.effects[0].parameters and type(case.effects[0]) is CATALOGUE[law].make
    spans = [np.ptp(r.rows.q[:, plan.planted[0].joint]) for r in case.recorded[3:]]
    assert spans[1] > spans[0], "the last recording goes beyond the range of training"


def _answer(law: str, **parameters: float) -> dict:
    effects = [{"effect": "unknown_law", "law": law, "axis": "knee", "parameters": parameters}]
    return {"effects": effects, "axes": {"joint knee": "knee", "joint hip": "hip"}}


def _law(joint: str, given: np.ndarray, q: np.ndarray, w: np.ndarray) -> dict:
    return {"joint": joint, "q": q, "w": w, "motor": 0.0 * q, "given": given}


def test_a_force_is_compared_with_the_true_one_named_effects_beside_it_included() -> None:
    q, w = np.linspace(-1.0, 1.0, 500), np.cos(np.linspace(0.0, 9.0, 500))
    answer = _answer("one_way_damper", c=2.0, way=1.0, share=0.5)
    true = -2.0 * np.where(w > 0.0, w, 0.5 * w)
    viscous = {"effect": "viscous_friction", "kind": "joint", "name": "knee", "parameters": {"c": {"value": 1.5}}}
    found = force_error({"what": [viscous]}, [_law("knee", true + 1.5 * w, q, w)], answer)
    assert found is not None and found["error"] == pytest.approx(0.0, abs=1e-12)
    alone = force_error({"what": []}, [_law("knee", 1.1 * true, q, w)], answer)
    assert alone is not None and alone["error"] == pytest.approx(0.1)
    lag = viscous | {"effect": "hysteresis"}
    assert force_error({"what": [lag]}, [_law("knee", true, q, w)], answer) is None, "it cannot be said by q and w"
    assert force_error({"what": []}, [_law("hip", true, q, w)], answer) is None
    assert force_error({"what": []}, [_law("knee", true, q, w)], _answer("warming_damper")) is None


def test_forces_are_those_of_the_generator() -> None:
    assert set(FORCES) <= set(CATALOGUE)
    q = np.array([0.0, 1.5])
    assert FORCES["tightening_cable"]({"k": 2.0, "q0": 0.5}, q, q, q) == pytest.approx([0.0, -2.0])


def test_what_a_force_depends_on_is_seen() -> None:
    rng = np.random.default_rng(5)
    q, w = rng.normal(size=(2, 2000))
    assert explained(q, np.sin(3.0 * q)) > 0.8 > 0.2 > explained(w, np.sin(3.0 * q))


def test_scores_count_what_they_say(tmp_path) -> None:
    q = np.linspace(-1.0, 1.0, 50)
    force = {"error": 0.08, "q": q.tolist(), "w": (0.0 * q).tolist(), "true": q.tolist(), "found": (1.1 * q).tolist()}
    entry = {
        "case": "c000", "group": "own", "robot": "leg", "truth": "rubber_buffer", "shown": 9.0, "visible": True,
        "verdict": "missing_physics", "claimed": ["unknown_law@knee"], "alarm": True, "detected": True,
        "place_first": True, "place_three": True, "name_first": True, "name_equivalent": True, "named_all": True,
        "wrong_name": False, "sizes": [], "onset_error": None, "probability": 0.9, "gain": 0.9,
        "errors": {"nominal": 0.1, "explained": 0.02}, "floor": 0.001, "converged": None, "wall_s": 60.0,
        "robot_steps": 1e6, "commit": None, "inside": {"explained": 0.9, "true": 1.0},
        "beyond": {"explained": 0.5, "true": 1.0}, "force": force,
    }  # fmt: skip
    wrong = entry | {
        "case": "c001", "claimed": ["cogging@knee"], "name_equivalent": False, "force": None,
        "errors": {"nominal": 0.1, "explained": 0.2},
    }  # fmt: skip
    lost = wrong | {"case": "c002", "errors": {"nominal": 0.1}}
    table = {what: found for what, _, found in measured([entry, wrong])}
    assert table["a wrong name given"].startswith("1 of 2 ")
    assert table["gain inside the range, of the true law's, median (static)"] == "90 % (2)"
    assert table["gain overall, of the true law's, median (static)"] == "70 % (2)"
    assert table["error of the force, median"] == "8 % (1)"
    assert table["predicts the tests worse than the nominal simulator"] == "1 of 2"
    ran_away = {what: found for what, _, found in measured([entry, lost])}
    assert ran_away["predicts the tests worse than the nominal simulator"] == "1 of 2"
    page = write_scores(tmp_path, json.loads(json.dumps([entry, wrong])), 285)
    assert page.read_text().startswith("2 of 285") and (tmp_path / "laws.png").stat().st_size > 5000
