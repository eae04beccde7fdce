"""Made-up results of all three jobs, with names that a page might stumble over: what report tests draw."""

import numpy as np

from estexp_jax.discovery.competing_models import CompetingModel, CompetingModels
from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig, NativeModel, Prediction
from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.discovery.slopes import Fit
from estexp_jax.experiment_design.predictive_simulation import PredictedReadings
from estexp_jax.experiment_design.propose import ProposeConfig, ProposedExperiment
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.state import Row, RunState

LONG = "left_front_upper_leg_abduction_and_rotation_joint"
ARM = """<mujoco><worldbody><body><joint name="{0}" axis="0 1 0"/><geom size=".1"/></body></worldbody>
<actuator><position name="servo" joint="{0}" ctrlrange="-1 1"/></actuator>
<sensor><jointpos name="&lt;i&gt;angle&lt;/i&gt;$\\x$" joint="{0}"/></sensor></mujoco>"""
XML = f"""<mujoco><worldbody><body><joint name="{LONG}"/><geom size="1"/><site name="s"/></body></worldbody>
<sensor><jointpos name="angle" joint="{LONG}"/><force name="force" site="s"/></sensor></mujoco>"""
ROWS = 60
NUMBERS = {"train": 0.05, "test": 0.04}


def explanation(places: tuple, error: float) -> Explanation:
    return Explanation(Fit(Hypothesis(places, ()), np.zeros(0), error**2), np.full(4, error**2 / 4.0))


def prediction(name: str, role: str, offset: float) -> Prediction:
    time = np.arange(ROWS) / 10.0
    recorded = np.stack([np.sin(time), 100.0 * np.cos(time)], axis=1)
    recorded[5] = np.nan
    nominal, explained = recorded + [offset, 2.0], recorded + 0.01
    window = np.repeat([0, 1, 2], ROWS // 3)
    return Prediction(name, role, time, window, ("angle", "force.0"), recorded, nominal, explained)


def recording(p: Prediction) -> Recording:
    one = np.ones((ROWS, 1))
    return Recording(p.recording, p.time, one, one, p.recorded, one, one, p.role)


def claim(effect: str, sentence: str, in_mjcf: bool) -> dict:
    number = {"value": 1.0234, "low": 0.97, "high": 1.08, "unit": "N m"}
    told = {"sentence": sentence, "equation": "tau = -T sign(w) & more", "parameters": {"T": number}}
    return {"effect": effect, "kind": "joint", "name": LONG, "probability": 0.94, "in_mjcf": in_mjcf, **told}


FINDINGS = {
    "schema": "estexp.findings/1",
    "verdict": "missing_physics",
    "side": "plant",
    "where": [{"kind": "joint", "name": LONG, "share": 0.91, "p_value": 1e-9}],
    "when": {"regime": "at reversals", "onset_s": {"a.csv": None, "b <i>$\\x$.csv": 1.5}},
    "what": [
        claim("coulomb_friction", "the joint resists motion with 1.02 N m", True),
        claim("load_dependent_friction", "the joint resists motion with 40 % <of> its load", False),
    ],
    "alternatives": [
        {"effects": [f"viscous_friction@{LONG}", "gravity_tilt"], "probability": 0.004, "test_error": 0.013},
        {"effects": [], "probability": 0.05, "test_error": None},
    ],
    "fit": {
        "metric": "nrmse",
        "window_s": None,
        "noise_floor": {"train": 0.001, "test": 0.0},
        **dict.fromkeys(("nominal", "parameters_only", "explained", "mjcf"), NUMBERS),
        "black_box": {},
        "placebo": {"train": 0.0333, "test": 0.0444},
        "gain": {"value": 0.93, "low": 0.9, "high": 0.95},
    },
    "advice": ["Record a motion with the motor off."],
    "data": [{"file": "b <i>$\\x$.csv", "role": "test", "rows": 60, "hz": 10.0, "notes": ["ignored: <b>x</b>"]}],
    "engine": {"name": "lanes", "largest_difference": 2e-6},
    "cost": {"wall_s": 61.2, "compile_s": None, "robot_steps": 1500000},
    "seed": 5,
    "versions": {"jax": "0.9.2", "mujoco": "4.0.1"},
}
QUIET = {"side": None, "what": []}
NOTHING = {"value": None, "low": None, "high": None}
OTHERS = {
    "missing_physics": {},
    "consistent": {**QUIET, "where": [], "alternatives": [], "advice": [], "fit": {**FINDINGS["fit"], "gain": NOTHING}},
    "parameters": {"what": FINDINGS["what"][:1]},
    "unexplained": QUIET,
}


def diagnosis(verdict: str = "missing_physics") -> Diagnosis:
    predictions = (prediction("a.csv", "train", 0.1), prediction("b <i>$\\x$.csv", "test", 0.3))
    robot = Robot.from_string(XML, "folder/legs <1>.xml")
    case = Case(robot, tuple(recording(p) for p in predictions), (robot, robot))
    friction, load = ("coulomb_friction", LONG), ("load_dependent_friction", LONG)
    tried = [
        explanation((friction,), 0.01),
        explanation((("body_mass", "trunk"),), 0.03),
        explanation((friction, load), 2e-3),
    ]
    own = explanation((), 0.04)
    chosen = tried[2] if verdict == "missing_physics" else own
    nominal = explanation((), 0.05)
    selection = Selection(nominal, nominal, own, tuple(tried), chosen)
    findings = {**FINDINGS, "verdict": verdict, **OTHERS[verdict]}
    load = Change("load_dependent_friction", LONG, {"mu": 0.4})
    left_out = ((load, "MuJoCo has no element for it"),) if verdict == "missing_physics" else ()
    native = NativeModel((), left_out, {"train": 0.01, "test": 0.01})
    finer = 1 if verdict == "unexplained" else 16
    return Diagnosis(case, ExplainConfig(), findings, selection, (), native, predictions, finer, 16)


WEAK = Change("motor_weakness", "knee_f", {"loss": 0.48})
LOST = Change("part_lost", "upper_<b>f</b>", {"lost": 1.0})


def trial(distance: float) -> Trial:
    way = np.linspace(0.0, distance, 30)
    position = np.stack([way, 0.1 * way**2, np.full(30, 0.2)], axis=1)
    return Trial(np.arange(30) * 0.01, np.zeros((30, 8)), np.ones((30, 8)), position)


def recovered() -> RunState:
    rows = [Row(n, p, g, 0.5 * g + n, 0.1, 1) for n, p in ((0, "exploration"), (1, "exploration")) for g in (1, 2, 3)]
    return RunState(
        phase="done",
        number=1,
        controllers=(np.zeros(68), np.ones(68)),
        simulated=(2.0, 1.8),
        diagnoses=((WEAK,),),
        residuals=(0.01,),
        probabilities=(0.9,),
        before=trial(2.0),
        trials=(trial(0.4), trial(1.7)),
        history=tuple(rows),
    )


def proposal(apart: tuple[float, float, float] = (9.0, 0.2, 12.0)) -> ProposedExperiment:
    """Three rivals; `apart`: separations of 1 and 2, 1 and 3, 2 and 3."""
    robot = Robot.from_string(ARM.format(LONG), "folder/arms <1>.xml")
    time = np.arange(200) / 100.0
    angle = np.sin(3.0 * time)
    readings = np.stack([angle, angle + 0.09 * time, angle + 0.002], axis=0)[:, :, None]
    changes = [Change(e, LONG, {p: 0.3}) for e, p in (("coulomb_friction", "T"), ("viscous_friction", "c"))]
    changes.append(Change("sensor_bias", "<i>angle</i>$\\x$", {"bias": 0.002}))
    rivals = [CompetingModel((c,), (c,), p, 1.0) for c, p in zip(changes, (0.6, 0.395, 0.005), strict=True)]
    logs = (("a.csv", "train"), ("b.csv", "test"))
    one, names = np.array([0.01]), ("<i>angle</i>$\\x$",)
    contest = CompetingModels(tuple(rivals), names, one, 100.0, np.array([[-1.0, 1.0]]), one, logs)
    between = np.zeros((3, 3))
    between[np.triu_indices(3, 1)] = apart
    shown, commands = PredictedReadings(readings, between, 0.05), np.cos(3.0 * time)[:, None]
    config = ProposeConfig(duration=2.0)
    return ProposedExperiment(
        robot, contest, config, time, commands, shown, between / 3.0, 120_000, ("lanes", "it can")
    )
