"""What terms of unknown laws do where recordings show a joint, beside the force that it lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.effects.base import JointState
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.laws.base import JointLaw, JointTrajectory, MotionRange
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot

_SAMPLES = 2000
"""Samples of the forces."""
_JOLT = 0.995
"""Quantile of the force beyond which it is cut off: jolts are smeared by smoothing."""
_FAST = 0.98
"""Quantile of the speed that counts as fast, and of the motor torque that counts as hard."""
_RESTS, _OFTEN = 0.05, 0.1
"""Share of the fast speed below which a joint rests, and share of the samples from which on it does so often."""


class Samples(NamedTuple):
    """What was seen of a joint, (samples,), as in `ForceResidual`; q, w and motor torque of the others by index.

    `faster` is its acceleration.
    """

    force: np.ndarray
    q: np.ndarray
    w: np.ndarray
    faster: np.ndarray
    motor: np.ndarray
    told: np.ndarray
    asked: np.ndarray
    on: np.ndarray
    bent: np.ndarray  # (samples, n) orthonormal: what wrong values of the model would look like
    others: Mapping[int, tuple[np.ndarray, np.ndarray, np.ndarray]]
    runs: tuple[JointTrajectory, ...]  # of each recording, unthinned
    thin: tuple[np.ndarray, ...]  # which rows of each recording count
    reach: MotionRange
    counts: np.ndarray  # whether a sample counts: forces are 0 where it does not

    def moving(self) -> Samples | None:
        """The same while the joint moves; None where it rarely rests.

        Dry friction holds a joint at rest with whatever it takes, of which a friction law says nothing.
        """
        moves = np.abs(self.w) > _RESTS * self.reach.speed
        if not 0.0 < moves.mean() < 1.0 - _OFTEN:
            return None
        bent, _ = np.linalg.qr(self.bent * moves[:, None] + 0.0)
        return self._replace(force=self.force * moves, bent=bent, counts=moves)


class LawForces(NamedTuple):
    """What a law does where recordings show its joint, and what the joint lacks without it.

    Attributes:
        joint: its name.
        q, w: (samples,) position and speed, rad or m and rad/s or m/s.
        motor: (samples,) torque of its motors, N m or N.
        lacking: (samples,) force that the joint lacks, N m or N; jolts cut off.
        given: (samples,) what the law gives.
    """

    joint: str
    q: np.ndarray
    w: np.ndarray
    motor: np.ndarray
    lacking: np.ndarray
    given: np.ndarray


def law_forces(robot: Robot, seen: Sequence[ForceResidual], joint: str, terms: Sequence[Change]) -> LawForces:
    """The terms of a law along the training recordings.

    Args:
        robot: the nominal robot.
        seen: what its joints lack without the law, in each training recording.
        joint: the joint's name.
        terms: of the law, with their values.
    """
    samples, given = samples_of(robot, seen, robot.index("joint", joint)), np.zeros(1)
    for term in terms:
        law = effect(term.effect)
        assert isinstance(law, JointLaw)
        given = given + force_of(law, tuple(np.array([term.values[p.name]]) for p in law.parameters), samples)[:, 0]
    return LawForces(joint, samples.q, samples.w, samples.motor, samples.force, given)


def held(robot: Robot, seen: Sequence[ForceResidual], fitted: Fit) -> Fit:
    """The fit whose laws grow no further than recordings show: hidden variables that go beyond add nothing.

    Where recordings do not tell at what heat a motor's loss ends, larger motions would be predicted to lose all of it.

    Args:
        robot: the nominal robot.
        seen: its motions in the training recordings.
        fitted: what is claimed; what it predicts of the training recordings stays (nearly) the same.
    """
    vector, free = fitted.vector.copy(), fitted.hypothesis.free
    for name, site in fitted.hypothesis.places:
        law = effect(name)
        if isinstance(law, JointLaw) and law.n_states:
            own = [i for i, f in enumerate(free) if (f.effect, f.site) == (name, site)]
            values, courses = tuple(vector[own].tolist()), courses_of(robot, seen, robot.index("joint", site))
            each = [[float(np.abs(x).max()) for x in law.hidden_along(values, course)] for course in courses]
            vector[own] = law.saturated_at(values, tuple(map(max, zip(*each, strict=True))))
    return replace(fitted, vector=vector)


def courses_of(robot: Robot, seen: Sequence[ForceResidual], joint: int) -> tuple[JointTrajectory, ...]:
    """What a joint did in each training recording."""
    place, dof = robot.model.jnt_qposadr[joint], robot.model.jnt_dofadr[joint]
    return tuple(
        JointTrajectory(r.time - r.time[0], r.qpos[:, place], r.qvel[:, dof], r.motor[:, dof], r.told[:, dof])
        for r in seen
    )


def samples_of(robot: Robot, seen: Sequence[ForceResidual], joint: int) -> Samples:
    """What each training recording shows of a joint, thinned to a few thousand samples."""
    model = robot.model
    every = max(1, sum(len(r.time) for r in seen) // _SAMPLES)
    thin = tuple(np.arange(0, len(r.time), every) for r in seen)

    def joined(columns: Sequence[np.ndarray]) -> np.ndarray:
        return np.concatenate([c[rows] for c, rows in zip(columns, thin, strict=True)])

    def motion(j: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        place, dof = model.jnt_qposadr[j], model.jnt_dofadr[j]
        each = [[r.qpos[:, place] for r in seen], [r.qvel[:, dof] for r in seen], [r.motor[:, dof] for r in seen]]
        q, w, motor = map(joined, each)
        return q, w, motor

    dof = model.jnt_dofadr[joint]
    moved = [j for j in robot.scalar_joints if any(np.ptp(r.qvel[:, model.jnt_dofadr[j]]) > 0.0 for r in seen)]
    q, w, motor = motion(joint)
    force = joined([r.force[:, dof] for r in seen])
    far = float(np.quantile(np.abs(force), _JOLT))
    faster = joined([np.gradient(r.qvel[:, dof], r.time) for r in seen])
    bent, _ = np.linalg.qr(np.stack([w, motor, faster], axis=1) + 0.0)
    length = max(float(np.ptp(r.time)) for r in seen)
    others = {j: motion(j) for j in moved if j != joint}
    fast, hard = (float(np.quantile(np.abs(x), _FAST)) for x in (w, motor))
    motors = [[r.told for r in seen], [r.asked for r in seen], [r.on for r in seen]]
    told, asked, on = (joined([x[:, dof] for x in each]) for each in motors)
    reach = MotionRange(float(q.min()), float(q.max()), fast, length, hard, tuple(others))
    runs = courses_of(robot, seen, joint)
    counts = np.ones(len(q), bool)
    return Samples(
        np.clip(force, -far, far), q, w, faster, motor, told, asked, on, bent, others, runs, thin, reach, counts
    )


def force_of(law: JointLaw, p: tuple[np.ndarray, ...], samples: Samples) -> np.ndarray:
    """The force (samples, shapes) of a term at values (shapes,) of each parameter, 0 in samples that do not count."""
    q, w, motor = (x[:, None] for x in (samples.q, samples.w, samples.motor))
    one = np.ones_like(q)

    def of_others(number: np.ndarray) -> list[np.ndarray]:
        at = [samples.others[round(float(k)) - 1] for k in np.ravel(number)]
        return [np.stack(columns, axis=1) for columns in zip(*at, strict=True)]

    def motion_of(number: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at, rate, _ = of_others(number)
        return at, rate

    def torque_of(number: np.ndarray) -> np.ndarray:
        return of_others(number)[2]

    told, asked = samples.told[:, None], samples.asked[:, None]
    moment = JointState(
        q=q,
        w=w,
        torque=motor,
        on=samples.on[:, None],
        dt=np.zeros(1),
        limit=one,
        armature=one,
        torque_at=lambda q, w: motor,
        torque_of=torque_of,
        motion_of=motion_of,
        asked=lambda: (told, asked),
    )
    state = _states(law, p, samples)
    does, _ = law.act(tuple(jnp.asarray(x) for x in p), moment, state)
    sign = np.tanh(w / (0.01 * max(samples.reach.speed, 1e-9)))
    total = does.force - does.damping * w - does.friction * sign - does.inertia * samples.faster[:, None]
    total = total + (does.motor - 1.0) * motor + does.command
    return np.asarray(jnp.broadcast_to(total, (len(samples.q), len(p[0]))), float) * samples.counts[:, None]


def _states(law: JointLaw, p: tuple[np.ndarray, ...], samples: Samples) -> tuple[np.ndarray, ...]:
    """The hidden variables (samples, shapes) of a term along the recordings."""
    if not law.n_states:
        return ()
    each = []
    for values in zip(*p, strict=True):
        parts = [law.hidden_along(values, course) for course in samples.runs]
        each.append(
            [
                np.concatenate([part[k][rows] for part, rows in zip(parts, samples.thin, strict=True)])
                for k in range(law.n_states)
            ]
        )
    return tuple(np.stack([one[k] for one in each], axis=1) for k in range(law.n_states))
