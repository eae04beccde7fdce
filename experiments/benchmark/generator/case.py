"""One case: what is concealed in which robot, its recordings, and its answer."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, field, replace

import mujoco
import numpy as np

from experiments.benchmark.generator.catalogue import CATALOGUE, parameters
from experiments.benchmark.generator.effect import Effect
from experiments.benchmark.generator.excitation import KINDS, controller, motion
from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.plant import Plant, Trace, clock
from experiments.benchmark.generator.robots import ROBOTS, Robot, layout, misjudge, perturb
from experiments.benchmark.generator.sensing import Channel, Instruments, channels, deviation, true_reading
from experiments.benchmark.generator.visibility import Visibility, stretch, visibility

TRAIN, TEST = (0.6, 0.6, 0.6), (0.9,)
"""Amplitudes of the recordings, as shares of the full one."""
_PLAIN_ERROR = 0.01
"""Deviation of the parameter errors of plain cases."""


@dataclass(frozen=True)
class Planted:
    """An effect at a place.

    Attributes:
        effect: key of the catalogue.
        joint: index of the joint it is at, or whose motor, sensor or body; -1: everywhere.
        strength: 0.03 barely visible to 0.7 plain.
    """

    effect: str
    joint: int
    strength: float


@dataclass(frozen=True)
class Plan:
    """What a case is to be.

    Attributes:
        group: null, parameters, single, relative, unknown, pair, masked, onset, hidden, absorbed.
        robot: its name.
        planted: what is concealed.
        seed: of everything random in it.
        by_hand: whether the equations written by hand move it.
        plain: parameters are off by 1 %, encoders have 14 bits, noise has no memory, no row is lost.
        tests: amplitudes of the test recordings, as shares of the full one.
    """

    group: str
    robot: str
    planted: tuple[Planted, ...]
    seed: int
    by_hand: bool = False
    plain: bool = False
    tests: tuple[float, ...] = TEST


@dataclass(frozen=True)
class Recorded:
    """A recording before its sensors have spoilt it."""

    name: str
    rows: Trace
    whole: Trace
    onset: float | None = None

    @property
    def steps(self) -> Trace:
        """What happened at the nominal steps since the first row; `whole` begins somewhat earlier."""
        return self.whole.logged()


@dataclass(frozen=True)
class Case:
    """A case with its truth.

    Attributes:
        plan: what it was to be.
        nominal: the MJCF that is given.
        recorded: its recordings.
        effects: made, with their parameters, beside `plan.planted`.
        instruments: how good the sensors are.
        visible: how visible the difference is.
        twin: and how visible it were without the effects, with the same wrong values, where bodies touch: their motions
            part by themselves.
        truth, motors: the true model without its effects, and its motors.
        wrong: relative errors of the parameters that were made wrong on purpose.
        deviation: of the ordinary parameter errors.
        shorter: its recordings have this share of their usual length.
    """

    plan: Plan
    nominal: str
    recorded: tuple[Recorded, ...]
    effects: tuple[Effect, ...]
    instruments: Instruments
    visible: Visibility
    truth: mujoco.MjModel
    motors: Motors
    wrong: dict[str, float] = field(default_factory=dict)
    deviation: float = 0.0
    shorter: float = 1.0
    twin: Visibility | None = None


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
    seen: Sequence[Channel],
    recorded: Sequence[Recorded],
    effects: Sequence[Effect],
    planted: Sequence[Planted],
    instruments: Instruments,
    bound: float,
) -> Visibility:
    place, coarse = layout(robot.name), round(model.opt.timestep / robot.model.opt.timestep)
    traces = {r.name: every(r.steps, coarse) for r in recorded}
    readings = {
        r.name: np.stack([reading(c, r, traces[r.name].time, effects, planted, robot.name) for c in seen], axis=-1)
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
        [deviation(c, instruments, size_of(c, recorded, robot.name), is_slide(model, place, c)) for c in seen]
    )
    return visibility(model, place, seen, roles, spread, bound)


def every(trace: Trace, n: int) -> Trace:
    """Every n-th row; commands are averaged over the rows between."""
    if n == 1:
        return trace
    whole = len(trace.time) // n * n
    mean = trace.command[:whole].reshape(-1, n, trace.command.shape[1]).mean(axis=1)
    thinned = {k: v[:whole:n] for k, v in asdict(trace).items()}
    return Trace(**{**thinned, "command": mean})


def size_of(channel: Channel, recorded: Sequence[Recorded], robot: str) -> float:
    """Deviation of a sensor's true reading over all recordings."""
    return float(np.std(np.concatenate([true_reading(channel, r.steps, layout(robot)) for r in recorded])))


def is_slide(model: mujoco.MjModel, place, channel: Channel) -> bool:
    """Whether a sensor's joint is a slide."""
    return int(model.joint(place.joints[channel.joint]).type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE)


def reading(
    channel: Channel,
    recorded: Recorded,
    at: np.ndarray,
    effects: Sequence[Effect],
    planted: Sequence[Planted],
    robot: str,
) -> np.ndarray:
    """A sensor's reading without noise at some times, spoilt by sensor effects, one after the other."""
    time, true = recorded.whole.time, true_reading(channel, recorded.whole, layout(robot))
    spoilt = None
    for effect, p in zip(effects, planted, strict=True):
        if CATALOGUE[p.effect].kind == "sensor" and p.joint == channel.joint and channel.kind == "position":
            effect.start = -1e9 if recorded.onset is None else recorded.onset
            found = effect.read(time, true, at)
            if found is not None:
                spoilt, true = found, np.asarray(effect.read(time, true, time))
    if spoilt is not None:
        return spoilt
    if channel.kind == "torque":  # jumps with commands, so taken where it was seen
        return (
            true_reading(channel, recorded.rows, layout(robot))
            if len(at) == len(recorded.rows.time)
            else np.interp(at, time, true)
        )
    return np.interp(at, time, true)


def stronger(plan: Plan, factor: float) -> Plan:
    """The same with other strengths."""
    return replace(plan, planted=tuple(replace(p, strength=min(0.9, p.strength * factor)) for p in plan.planted))
