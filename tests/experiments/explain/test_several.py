"""Arms with several effects: what is planned and written, what counts as visible, how a case is judged."""

import json
import re
from collections import Counter
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.registry import effect
from experiments.explain.several.arms import drawn_arm, home
from experiments.explain.several.cases import LOGS, write_case
from experiments.explain.several.effects import drawn_effects, element, said_by
from experiments.explain.several.flaws import Flaw, drawn_flaw
from experiments.explain.several.judging import judged
from experiments.explain.several.plans import FLAWS, planned
from experiments.explain.several.real import RealArm
from experiments.explain.several.scores import write_scores


def test_all_arms_drives_and_flaws_are_planned_and_a_part_keeps_its_ids() -> None:
    whole, first = planned(5, "all"), planned(5, "first")
    kinds = Counter((p.group, p.joints, p.servo) for p in whole.values())
    assert Counter(p.group for p in whole.values()) == {"several": 60, "nothing": 100}
    assert {n for k, n in kinds.items() if k[0] == "several"} == {10} and len(kinds) == 12
    assert all(whole[case] == plan for case, plan in first.items()) and len(first) == 12
    assert {p.flaw for p in first.values()} == set(FLAWS)
    assert len({p.seed for p in whole.values()}) == 160 and planned(6, "all") != whole


def test_a_case_is_written_as_a_user_has_it_and_its_answer_apart(tmp_path) -> None:
    plan = replace(planned(5, "first")["s003"], duration=1.2)
    answer = write_case(tmp_path, "s003", plan)
    folder = tmp_path / "cases" / "s003"
    model = mujoco.MjModel.from_xml_path(str(folder / "nominal.xml"))
    assert {p.name for p in folder.iterdir()} == {"nominal.xml", "recordings.toml", *(file for file, _ in LOGS)}
    header, *rows = (folder / "train_0.csv").read_text().splitlines()
    assert header == "time,ctrl.m1,ctrl.m2,sensor.q1,sensor.q2" and len(rows) == 120
    assert 3 <= len(answer["effects"]) <= 8 and model.nu == 2
    assert all(np.isfinite(e["change"]) and e["change"] > 0.0 for e in answer["effects"] if e["visible"])
    written = (folder / "train_0.csv").stat().st_mtime_ns
    assert write_case(tmp_path, "s003", plan) == answer and (folder / "train_0.csv").stat().st_mtime_ns == written
    assert json.loads((tmp_path / "drawn" / "s003.json").read_text()) == answer


@pytest.mark.parametrize("joints", [2, 6])
def test_what_is_drawn_is_in_the_catalogue_and_once_at_a_joint(joints: int) -> None:
    rng = np.random.default_rng(joints)
    arm = drawn_arm(joints, True, None, rng)
    for _ in range(5):
        found = drawn_effects(arm, rng)
        assert len({(e.effect, e.joint) for e in found}) == len(found)
        for e in found:
            assert element(e)[0] == effect(e.effect).kind
            assert set(said_by(e.effect, e.parameters)) >= {e.effect}


def test_the_real_arm_is_off_by_three_percent_and_has_its_effects() -> None:
    rng = np.random.default_rng(1)
    arm = drawn_arm(3, True, None, rng)
    real = RealArm(arm, (), Flaw("soft_mount", mount={"k": 5e3, "d": 1.0}), np.ones((5, 3)))
    assert real.model.nv == 5 and real.model.opt.timestep == pytest.approx(0.1 * arm.model.opt.timestep)
    for ours, theirs in ((real.model.actuator_gainprm[:, 0], arm.model.actuator_gainprm[:, 0]),
                         (real.model.dof_armature[real.v], arm.model.dof_armature)):  # fmt: skip
        assert ours == pytest.approx(1.03 * theirs)


@pytest.mark.parametrize("name", ["friction_along_path", "varying_inertia"])
def test_what_varies_is_on_average_what_the_model_says(name: str) -> None:
    rng = np.random.default_rng(2)
    arm = drawn_arm(3, False, 1, rng)
    flaw = drawn_flaw(name, 1, arm, rng)
    path = home(3)[1] + np.linspace(-0.6, 0.6, 101)
    assert np.mean(flaw.friction(path)) == pytest.approx(0.0, abs=1e-9)
    assert np.ptp(flaw.friction(path)) > 0.05
    inertia, _ = zip(*(flaw.rotor(q, 1.0) for q in path), strict=True)
    lowest = arm.model.dof_armature[1] * 0.9
    assert np.mean(inertia) == pytest.approx(0.0, abs=1e-9) and min(inertia) > -lowest


def test_the_torque_of_a_varying_inertia_keeps_its_energy() -> None:
    flaw, q, w, step = Flaw("varying_inertia", 0, 0.2, 2.0, 0.3, 1.5), 0.4, 1.7, 1e-6
    slope = (flaw.rotor(q + step, w)[0] - flaw.rotor(q - step, w)[0]) / (2.0 * step)
    assert flaw.rotor(q, w)[1] == pytest.approx(-0.5 * slope * w * w, rel=1e-6)


def _entry(group: str, what: list[dict[str, Any]], verdict: str = "missing_physics") -> dict[str, Any]:
    def truth(name: str, kind: str, at: str, visible: bool = True, **values: float) -> dict[str, Any]:
        return {"effect": name, "kind": kind, "name": at, "axis": f"j{at[-1]}", "accepted": accepted.get(name, []),
                "parameters": values, "visible": visible}  # fmt: skip

    accepted = {"viscous_friction": ["back_emf"]}
    effects = [
        truth("viscous_friction", "joint", "j1", c=2.0),
        truth("sensor_bias", "sensor", "q2", bias=0.02),
        truth("body_mass", "body", "link2", visible=False, dm=0.01),
    ]
    effects = effects if group == "several" else []
    places = (("joint", "j"), ("body", "link"), ("actuator", "m"), ("sensor", "q"))
    answer = {
        "effects": effects,
        "equivalents": [[] for _ in effects],
        "axes": {f"{kind} {p}{j}": f"j{j}" for kind, p in places for j in (1, 2)},
        "flaw": {"name": "varying_inertia", "joint": 1},
        "known": {"link1": 2.0, "link2": 1.0, "j1": 1.0, "j2": 0.5},
    }
    findings = {"verdict": verdict, "what": what}
    return {"case": "s000", "group": group, "robot": "arm2", "truth": "", "wall_s": 9.0, "answer": answer,
            "findings": findings}  # fmt: skip


def _claim(name: str, kind: str, at: str, probability: float = 0.9, **values: tuple[float, float, float]) -> dict:
    numbers = {p: dict(zip(("value", "low", "high"), v, strict=True)) for p, v in values.items()}
    return {"effect": name, "kind": kind, "name": at, "probability": probability, "parameters": numbers}


def test_claims_are_named_wrong_of_the_flaw_or_of_the_model() -> None:
    what = [
        _claim("back_emf", "actuator", "m1", k=(2.3, 1.8, 2.8)),
        _claim("sensor_bias", "sensor", "q1", bias=(0.02, 0.01, 0.03)),
        _claim("sensor_bias", "sensor", "q2", 0.4, bias=(0.02, 0.01, 0.03)),
        _claim("body_mass", "body", "link1", dm=(0.1, 0.0, 0.2)),
        _claim("armature", "joint", "j1", I=(0.1, 0.0, 0.2)),
        _claim("unknown_law", "joint", "j2"),
        _claim("unknown_law", "joint", "j1"),
    ]
    score = judged(_entry("several", what))
    assert score.named == ("viscous_friction@j1",) and score.missed == ("sensor_bias@q2",)
    assert score.hidden == ("body_mass@link2",) and score.of_the_model == ("body_mass@link1",)
    assert score.wrong == ("sensor_bias@q1", "armature@j1", "unknown_law@j1")
    assert score.of_the_flaw == ("unknown_law@j2",)
    assert [(s.right, s.inside) for s in score.sizes] == [(True, True)]


def test_the_page_counts_both_kinds_of_cases_and_failures_as_missed(tmp_path) -> None:
    failed = {"case": "s001", "group": "several", "robot": "arm2", "truth": "armature+body_mass", "wall_s": None}
    alarm = _entry("nothing", [_claim("armature", "joint", "j1", I=(0.1, 0.0, 0.2))]) | {"case": "n000"}
    quiet = _entry("nothing", [], "consistent") | {"case": "n001"}
    page = write_scores(tmp_path, [_entry("several", []), failed, alarm, quiet], 160).read_text()
    assert re.search(r"visible effects named .*\| 0 of 4 ", page)
    assert re.search(r"cases with a claim above 50 % .*\| 1 of 2 ", page)
    assert "consistent 1, missing_physics 1" in page and page.startswith("4 of 160 cases")
