"""Hand-made findings get the scores they deserve."""

import pytest

from experiments.benchmark.scoring.board import board, ece, wilson
from experiments.benchmark.scoring.judge import judge

AXES = {"joint knee": "knee", "actuator knee_servo": "knee", "sensor knee_angle": "knee", "joint hip": "hip"}


def answer(*effects, group="single", shown=10.0, equivalents=None):
    """The answer of a case with effects (name, kind, element, parameters)."""
    row = [
        {
            "effect": name,
            "law": "odd" if name == "unknown_law" else None,
            "kind": kind,
            "name": element,
            "axis": AXES.get(f"{kind} {element}"),
            "parameters": parameters,
            "scored": list(parameters),
            "accepted": [],
        }
        for name, kind, element, parameters in effects
    ]
    return {
        "group": group,
        "robot": "leg",
        "effects": row,
        "equivalents": equivalents or [[] for _ in row],
        "axes": AXES,
        "onset_s": {"train_0.csv": None},
        "length_s": {"train_0.csv": 8.0},
        "visibility": {"shown": shown},
    }


def findings(verdict, *claims, where=(), probability=0.9, gain=0.95, onset=None):
    """Findings with claims (name, kind, element, parameters as (value, low, high))."""
    return {
        "verdict": verdict,
        "where": [{"kind": k, "name": n} for k, n in where],
        "when": {"onset_s": {"train_0.csv": onset}},
        "what": [
            {
                "effect": name,
                "kind": kind,
                "name": element,
                "probability": probability,
                "parameters": {p: dict(zip(("value", "low", "high"), v, strict=True)) for p, v in parameters.items()},
            }
            for name, kind, element, parameters in claims
        ],
        "fit": {
            "noise_floor": {"train": 0.001, "test": 0.001},
            "nominal": {"train": 0.1, "test": 0.1},
            "parameters_only": {"train": 0.08, "test": 0.09},
            "explained": {"train": 0.01, "test": 0.01},
            "placebo": {},
            "gain": {"value": gain},
        },
        "cost": {"robot_steps": 100},
    }


COULOMB = ("coulomb_friction", "joint", "knee", {"T": 1.0})


def test_a_right_answer():
    claim = ("coulomb_friction", "joint", "knee", {"T": (1.1, 0.9, 1.2)})
    row = judge("c0", answer(COULOMB), findings("missing_physics", claim, where=[("actuator", "knee_servo")]))
    assert row.detected and row.place_first and row.name_first and row.named_all and not row.wrong_name
    assert row.sizes[0].error == pytest.approx(0.1) and row.sizes[0].covered and row.converged is None


def test_the_right_name_at_the_wrong_joint_is_wrong():
    claim = ("coulomb_friction", "joint", "hip", {})
    row = judge("c0", answer(COULOMB), findings("missing_physics", claim, where=[("joint", "hip"), ("joint", "knee")]))
    assert row.detected and not row.name_first and row.wrong_name and not row.place_first and row.place_three


def test_a_name_that_says_the_same_counts_separately():
    claim = ("viscous_friction", "joint", "knee", {})
    row = answer(("back_emf", "actuator", "knee_servo", {}), equivalents=[["viscous_friction"]])
    row = judge("c0", row, findings("missing_physics", claim))
    assert not row.name_first and row.name_equivalent and not row.wrong_name and row.place_first


def test_all_motors_and_the_environment_have_no_joint():
    late = answer(("command_delay", "actuator", "*", {"delay": 0.01}))
    row = judge(
        "c0", late, findings("missing_physics", ("command_delay", "actuator", "*", {"delay": (0.02, 0.0, 0.03)}))
    )
    assert row.name_first and row.sizes[0].error == pytest.approx(1.0)
    tilt = answer(("gravity_tilt", "environment", None, {}))
    found = findings("missing_physics", ("gravity_tilt", "environment", None, {}), where=[("environment", None)])
    assert (row := judge("c0", tilt, found)).name_first and row.place_first


def test_all_motors_are_at_their_only_joint():
    late = answer(("command_delay", "actuator", "*", {"delay": 0.01}))
    claim = ("command_delay", "actuator", "knee_servo", {"delay": (0.01, 0.0, 0.03)})
    for place, right in ((("joint", "knee"), True), (("joint", "hip"), False)):
        assert judge("c0", late, findings("missing_physics", claim, where=[place])).place_first == right


def test_laws_in_no_catalogue_are_declined_or_named_wrong():
    row = answer(("unknown_law", "joint", "knee", {}), group="unknown")
    declined, wrong = (
        judge("a", row, findings("unexplained")),
        judge("b", row, findings("missing_physics", ("armature", "joint", "knee", {}))),
    )
    assert declined.name_first and not declined.wrong_name and wrong.wrong_name
    scores = board([declined, wrong])
    assert scores["wrong_name_outside_catalogue"]["share"] == 0.5
    assert scores["abstains_where_it_should"]["share"] == 0.5


def test_a_failure_is_no_right_answer():
    failed = judge("a", answer(("coulomb_friction", "joint", "knee", {"T": 0.2})), None)
    assert failed.place_first is False and failed.name_first is False and failed.name_equivalent is False
    assert failed.alarm is False and judge("b", answer(group="null"), None).place_first is None


def test_false_alarms_and_failures_are_counted():
    rows = [
        judge("a", answer(group="null"), findings(v))
        for v in ("consistent", "parameters", "unexplained", "missing_physics")
    ]
    rows += [judge("e", answer(group="null"), None)]
    scores = board(rows)
    assert scores["false_alarms"]["null"] == pytest.approx(
        {"k": 2, "n": 5, "share": 0.4, "low": wilson(2, 5)[0], "high": wilson(2, 5)[1]}
    )
    assert scores["failed"]["k"] == 1 and scores["converged"]["k"] == 0 and scores["converged"]["n"] == 4


def test_hidden_effects_are_best_left_alone():
    row = answer(COULOMB, group="hidden", shown=0.2)
    scores = board(
        [judge("a", row, findings("parameters")), judge("b", row, findings("missing_physics", COULOMB[:3] + ({},)))]
    )
    assert scores["abstains_where_it_should"]["share"] == 0.5 and scores["detected"]["n"] == 0


def test_the_onset_counts_as_a_share_of_the_recording():
    row = {**answer(COULOMB, group="onset"), "onset_s": {"train_0.csv": 4.0}}
    assert judge("a", row, findings("missing_physics", onset=4.4)).onset_error == pytest.approx(0.05)
    assert judge("a", row, findings("missing_physics")).onset_error == pytest.approx(0.5)


def test_two_at_once_need_both():
    row = answer(COULOMB, ("armature", "joint", "hip", {}), group="pair")
    one = judge("a", row, findings("missing_physics", ("armature", "joint", "hip", {})))
    assert one.name_first and not one.named_all and board([one])["both_named"]["share"] == 0.0


def test_gain_is_a_share_of_the_oracles():
    rows = [judge("a", answer(COULOMB), findings("missing_physics", gain=0.4))]
    assert board(rows, {"a": 0.8})["gain"]["median_share_of_oracle"] == pytest.approx(0.5)
    assert board(rows)["gain"]["better_than"]["parameters_only"]["share"] == 1.0


def test_known_intervals_and_calibration():
    assert wilson(0, 100) == pytest.approx((0.0, 0.0370), abs=1e-4)
    assert wilson(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)
    assert ece([0.9] * 10, [True] * 9 + [False]) is not None
    assert ece([0.5] * 10, [True, False] * 5, bins=1) == pytest.approx(0.0)
    assert ece([1.0] * 4, [False] * 4) == pytest.approx(1.0) and ece([], []) is None
