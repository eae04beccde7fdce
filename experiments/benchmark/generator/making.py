"""From a plan to a case: everything it leaves open is drawn, and the robot is moved."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace

import mujoco
import numpy as np

from experiments.benchmark.generator.case import Case, Plan, Planted, Recorded
from experiments.benchmark.generator.catalogue import CATALOGUE, parameters
from experiments.benchmark.generator.effect import Effect
from experiments.benchmark.generator.excitation import KINDS, controller, motion
from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.plant import Plant, clock
from experiments.benchmark.generator.readings import every, is_slide, reading, size_of
from experiments.benchmark.generator.robots import ROBOTS, Robot, layout, misjudge, perturb
from experiments.benchmark.generator.sensing import Channel, Instruments, channels, deviation
from experiments.benchmark.generator.visibility import Visibility, stretch, visibility

TRAIN = (0.6, 0.6, 0.6)
"""Amplitudes of the training recordings, as shares of the full one."""
_PLAIN_ERROR = 0.01
"""Deviation of the parameter errors of plain cases."""


def make(plan: Plan, *, shorter: float = 1.0, bound: float = 0.3, clean: bool = False, refit: bool = True) -> Case:
    """Draw everything a plan leaves open and move the robot.

    Args:
        plan: what it is to be; equal plans give equal cases.
        shorter: recordings have this share of their usual length.
        bound: of the refit that decides how visible it is.
        clean: no parameter errors (for tests).
        refit: whether to refit at all (tests do without).
    """
    rng, robot = np.random.default_rng([plan.seed, 1]), ROBOTS[plan.robot]
    place, nominal = layout(plan.robot), nominal_xml(robot, plan.planted, rng)
    model = mujoco.MjModel.from_xml_string(nominal)
    truth, deviation = robot.model, float(rng.uniform(0.01, 0.03))
    deviation = _PLAIN_ERROR if plan.plain else deviation
    if not clean:
        perturb(truth, deviation, rng)
    wrong = misjudge(truth, 0.15, rng) if plan.group == "parameters" else {}
    motors = Motors.of(truth, place)
    effects = tuple(build(p, plan.robot, motors, rng) for p in plan.planted)
    instruments = Instruments.draw(rng)
    instruments = replace(instruments, bits=14, coloured=0.0, dropped=0.0, memory=0.0) if plan.plain else instruments
    rate = float(rng.choice(robot.rates, p=_shares(len(robot.rates))))
    bound = bound if refit else 0.0

    def moved(effects: tuple[Effect, ...], rng: np.random.Generator) -> tuple[tuple[Recorded, ...], Visibility]:
        plant = Plant(robot, truth, motors, effects, plan.by_hand)
        recorded = tuple(_recordings(plan, robot, plant, effects, instruments, rate, shorter, rng))
        planted = plan.planted if effects else ()
        return recorded, _visible(model, robot, channels(model, place), recorded, effects, planted, instruments, bound)

    same = deepcopy(rng)
    recorded, measure = moved(effects, rng)
    twin = moved((), same)[1] if place.free and effects and refit else None
    return Case(plan, nominal, recorded, effects, instruments, measure, truth, motors, wrong, deviation, shorter, twin)


def _shares(n: int) -> list[float]:
    return [1.0] if n == 1 else [0.7, 0.3]


def nominal_xml(robot: Robot, planted: Sequence[Planted], rng: np.random.Generator) -> str:
    """The MJCF that is given: a coarser step where that is what is wrong."""
    if any(p.effect == "time_step" for p in planted):
        step = robot.model.opt.timestep
        times = int(rng.integers(4, 7))
        return robot.xml.replace(f'timestep="{step:g}"', f'timestep="{step * times:g}"')
    return robot.xml


def build(planted: Planted, robot: str, motors: Motors, rng: np.random.Generator) -> Effect:
    """An effect with parameters of its strength."""
    place, kind = layout(robot), CATALOGUE[planted.effect]
    values = parameters(planted.effect, planted.strength, robot, planted.joint, rng)
    at = planted.joint
    if kind.kind == "actuator" and at >= 0:
        at = place.drives.index(at)
        if "source" in values:
            values["source"] = float(place.drives.index(int(values["source"])))
    return kind.make(values, place, at, motors)


def _recordings(
    plan: Plan,
    robot: Robot,
    plant: Plant,
    effects: Sequence[Effect],
    instruments: Instruments,
    rate: float,
    shorter: float,
    rng: np.random.Generator,
) -> list[Recorded]:
    seconds = robot.seconds * shorter * (1.5 if rate == 50.0 else 1.0)
    sizes = (*TRAIN, *plan.tests)
    kinds = (
        ["gait"] * len(sizes)
        if robot.style == "gait"
        else [*rng.permutation(KINDS)[:3].tolist(), *["sines"] * len(plan.tests)]
    )
    if robot.style in ("torque", "mixed"):
        kinds[0] = "open"
    off = any(p.effect == "back_emf" for p in plan.planted) or rng.random() < 0.2
    found = []
    for i, (size, kind) in enumerate(zip(sizes, kinds, strict=True)):
        train = i < len(TRAIN)
        onset = float(rng.uniform(0.35, 0.65) * seconds) if plan.group == "onset" and train else None
        for effect in effects:
            effect.start = onset or -1e9
        reach = size * np.array(robot.reach)
        if plan.group == "hidden":
            reach[_hidden_joints(plan)] = 0.0
        if plan.group == "absorbed" and train:
            reach *= 0.6
        moved = motion("sines" if kind == "open" else kind, reach, seconds, rng)
        ask = controller(robot, Motors.of(robot.model, layout(robot.name)), moved, kind, size, rng)
        rows = clock(seconds, rate, instruments.jitter, plant.step, rng)
        pause = (0.45 * seconds, 0.55 * seconds) if off and i == 1 and not layout(robot.name).free else None
        traces = plant.run(ask, rows, pause, 0.5)
        found.append(Recorded(f"train_{i}.csv" if train else f"test_{i - len(TRAIN)}.csv", *traces, onset))
    return found


def _hidden_joints(plan: Plan) -> list[int]:
    return [p.joint for p in plan.planted if p.joint >= 0]


def _visible(
    model: mujoco.MjModel,
    robot: Robot,
    sensors: Sequence[Channel],
    recorded: Sequence[Recorded],
    effects: Sequence[Effect],
    planted: Sequence[Planted],
    instruments: Instruments,
    bound: float,
) -> Visibility:
    place, coarse = layout(robot.name), round(model.opt.timestep / robot.model.opt.timestep)
    traces = {r.name: every(r.steps, coarse) for r in recorded}
    readings = {
        r.name: np.stack([reading(c, r, traces[r.name].time, effects, planted, robot.name) for c in sensors], axis=-1)
        for r in recorded
    }
    roles = {
        role: stretch(
            model,
            [traces[n] for n in traces if n.startswith(role)],
            [readings[n] for n in traces if n.startswith(role)],
        )
        for role in ("train", "test")
    }
    spread = np.array(
        [deviation(c, instruments, size_of(c, recorded, robot.name), is_slide(model, place, c)) for c in sensors]
    )
    return visibility(model, place, sensors, roles, spread, bound)
