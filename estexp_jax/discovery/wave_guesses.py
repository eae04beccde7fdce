"""Which cogging the forces that joints lack suggest: at what spacing, how strong, at what phase.

A wave over position is found from a start only where it is almost in step with it, so a search would need hundreds of
starts. The missing force shows the spacing at once: least squares of a sine and a cosine at each of many, beside what
friction, wrong values of the model and a smooth force look like. A look only.

Source: Lomb, Astrophysics and Space Science 39 (1976): least squares at each frequency, for uneven samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.force_residual import ForceResidual, force_residuals
from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.problem import Problem
from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.registry import effect, every
from estexp_jax.physics.model.robot import Robot

_SAMPLES = 4000
_MOST, _PEAKS = 600, 6
"""Spacings that are tried, and those that are kept."""
_JOLT = 0.995
"""Quantile of the force beyond which it is cut off: jolts are smeared by smoothing."""
_SMOOTH = 3
"""Degree of the polynomial of position that waves stand beside."""
_STILL = 0.01
"""Share of a joint's speeds (root mean square) over which dry friction turns."""


def likely_waves(robot: Robot, seen: Sequence[ForceResidual], waves: Sequence[Effect]) -> dict[Place, Vectors]:
    """Values (A, n, phase) to start from of forces A sin(n q + phase), at each joint that moved.

    Args:
        robot: the nominal robot.
        seen: what its joints lack, in each training recording.
        waves: effects that are such forces.
    """
    places = [(e, site) for e in waves for site in e.sites(robot)]
    return {(e.name, site): found for e, site in places if (found := _likely_at(robot, seen, e, site))}


def _likely_at(robot: Robot, seen: Sequence[ForceResidual], wave: Effect, site: str) -> Vectors:
    """The best values at one joint; none where it did not move."""
    model, joint = robot.model, robot.index("joint", site)
    place, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
    nth = max(1, sum(len(r.time) for r in seen) // _SAMPLES)
    q, w, force, motor, faster = (
        np.concatenate([x[::nth] for x in columns])
        for columns in zip(*(_motion(r, place, dof) for r in seen), strict=True)
    )
    if not np.ptp(q) > 0.0:
        return []
    return _waves(q, _beside(q, w, motor, faster), force, wave.bounds(robot, site))


def _motion(r: ForceResidual, place: int, dof: int) -> tuple[np.ndarray, ...]:
    """Position, speed, missing force, motor torque, acceleration of one joint, (samples,) each."""
    return r.qpos[:, place], r.qvel[:, dof], r.force[:, dof], r.motor[:, dof], np.gradient(r.qvel[:, dof], r.time)


def _beside(q: np.ndarray, w: np.ndarray, motor: np.ndarray, faster: np.ndarray) -> np.ndarray:
    """What stands beside a wave, (samples, n) orthonormal."""
    way = np.tanh(w / (_STILL * np.sqrt(np.mean(w**2)) + 1e-12))
    smooth = np.polynomial.chebyshev.chebvander(2.0 * (q - q.min()) / np.ptp(q) - 1.0, _SMOOTH)
    return np.linalg.qr(np.column_stack([w, motor, faster, way, np.abs(w) * w, smooth]))[0]


def _waves(q: np.ndarray, beside: np.ndarray, force: np.ndarray, bounds: Sequence[tuple[float, float]]) -> Vectors:
    """The best waves, the best one first."""
    (_, most), (fewest, densest), _ = bounds
    far = np.quantile(np.abs(force), _JOLT)
    force = np.clip(force, -far, far)
    force = force - beside @ (beside.T @ force)
    n = np.linspace(fewest, densest, int(np.clip(2.0 * np.ptp(q) * (densest - fewest), 16, _MOST)))
    taken, values = np.zeros(len(n)), []
    for i, spacing in enumerate(n):
        wave = np.column_stack([np.sin(spacing * q), np.cos(spacing * q)])
        wave -= beside @ (beside.T @ wave)
        sine, cosine = np.linalg.lstsq(wave, force, rcond=1e-3)[0]
        taken[i] = np.sum((wave @ (sine, cosine)) ** 2)
        strength, phase = np.clip(np.hypot(sine, cosine), 0.0, most), np.arctan2(cosine, sine)
        values.append((float(strength), float(spacing), float(phase)))
    higher = np.concatenate([[-np.inf], taken, [-np.inf]])
    peaks = np.flatnonzero((taken >= higher[:-2]) & (taken >= higher[2:]))
    return [values[i] for i in peaks[np.argsort(-taken[peaks])][:_PEAKS]]


def with_waves(case: Case, whole: Problem) -> Problem:
    """The comparison with what missing forces suggest of cogging, where it is known how the robot moved."""
    train = case.indices("train")
    known = {s.recording for s in whole.segments if s.path is not None}
    waves = [e for e in every() if e.sinusoidal and any(name == e.name for name, _ in whole.places)]
    if not waves or not known >= set(train):
        return whole
    seen = force_residuals(whole, [robot.model for robot in case.robots], train)
    found = likely_waves(case.robot, seen, waves)
    return replace(
        whole,
        likely={
            (name, site): [*best, *effect(name).initial_guesses(case.robot, site, whole.seen)]
            for (name, site), best in found.items()
        },
    )
