"""When a joint's mismatch is largest: at reversals, at high speed, under load, somewhere, in one direction, throughout.

Of the force that the joint lacks, squared: its mean in each regime over its mean altogether. Chance is what remains of
that where regimes are shifted in time against the force, all the way around each recording: shifts keep both as
correlated from row to row as they are (Lancaster, Iatsenko, Pidde, Ticcinelli and Stefanovska, Physics Reports 748
(2018), section 3.3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np

from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.model.robot import Robot

THROUGHOUT = "throughout"
_NEAR = 0.05
"""So long before and after a reversal counts as at it, s."""
_HIGH = 0.75
"""Share of the samples below what is called high speed or load."""
_STILL = 0.05
"""Share of the largest speed below which a joint moves in no direction."""
_PLACES = 5
"""Parts of a joint's range."""
_LARGER = 1.3
"""A regime's mean square, over the mean, that is worth telling."""
_CHANCE = 0.05
_SHIFTS = 1000


class _Regime(NamedTuple):
    """A regime's samples (samples,) in each recording."""

    words: str
    where: list[np.ndarray]


def regime(robot: Robot, seen: Sequence[ForceResidual], joint: str, seed: int) -> str:
    """In plain words, when a joint lacks most force; `throughout` where nothing stands out.

    Args:
        robot: the nominal robot.
        seen: what its joints lack, in each training recording.
        joint: the joint's name.
        seed: of the shifts.
    """
    dof = int(robot.model.jnt_dofadr[robot.index("joint", joint)])
    power = [r.force[:, dof] ** 2 for r in seen]
    whole = sum(p.sum() for p in power) / sum(map(len, power))
    found, best = THROUGHOUT, 0.0
    regimes = _regimes(robot, seen, joint)
    for words, where in regimes:
        n = sum(map(np.sum, where))
        share = n / sum(map(len, where))
        if not 0.0 < share < 1.0 or whole <= 0.0:
            continue
        larger = _sum(power, where) / n / whole
        contrast = (larger - 1.0) * np.sqrt(share / (1.0 - share))
        if larger >= _LARGER and contrast > best and _chance(power, where, seed) < _CHANCE / len(regimes):
            found, best = words, contrast
    return found


def located_joint(robot: Robot, seen: Sequence[ForceResidual], where: Sequence[Mapping[str, Any]]) -> str | None:
    """The joint that the first of ranked places belongs to; of several, and for the environment, the one lacking most.

    None where there is no such joint.

    Args:
        robot: the nominal robot.
        seen: what its joints lack, in each training recording.
        where: as in findings.
    """
    model, names = robot.model, robot.names("joint")
    kind, name = (where[0]["kind"], where[0]["name"]) if where else ("environment", None)
    if kind == "joint" and name != ALL_ALIKE:
        return name
    choices = list(robot.scalar_joints)
    if name is not None and kind in ("body", "sensor"):
        body = robot.index("body", name) if kind == "body" else robot.body_of_sensor(robot.index("sensor", name))
        choices = [j for j in choices if int(model.jnt_bodyid[j]) == body] or choices
    lacks = np.sum([np.square(r.force).sum(axis=0) for r in seen], axis=0)
    return names[max(choices, key=lambda j: lacks[model.jnt_dofadr[j]])] if choices else None


def _regimes(robot: Robot, seen: Sequence[ForceResidual], joint: str) -> list[_Regime]:
    index = robot.index("joint", joint)
    place, dof = int(robot.model.jnt_qposadr[index]), int(robot.model.jnt_dofadr[index])
    q, w = [r.qpos[:, place] for r in seen], [r.qvel[:, dof] for r in seen]
    load = [np.abs(r.motor[:, dof]) for r in seen]
    speed = [np.abs(x) for x in w]
    fast, loaded = (np.quantile(np.concatenate(x), _HIGH) for x in (speed, load))
    still = _STILL * max(x.max() for x in speed)
    found = [
        _Regime(f"at reversals of {joint}", [_reversals(r.time, x) for r, x in zip(seen, w, strict=True)]),
        _Regime(f"at high speed of {joint}", [x > fast for x in speed]),
        _Regime(f"under load of {joint}", [x > loaded for x in load]),
        _Regime(f"in the positive direction of {joint}", [x > still for x in w]),
        _Regime(f"in the negative direction of {joint}", [x < -still for x in w]),
    ]
    unit = "m" if int(robot.model.jnt_type[index]) == int(mujoco.mjtJoint.mjJNT_SLIDE) else "rad"
    lowest, highest = np.quantile(np.concatenate(q), (0.01, 0.99))
    edges = np.linspace(lowest, highest, _PLACES + 1)
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        words = f"between {low:.2g} and {high:.2g} {unit} of {joint}"
        found.append(_Regime(words, [(x >= low) & (x <= high) for x in q]))
    return found


def _reversals(time: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Which samples (samples,) are near a change of the speed's sign."""
    turns = time[1:][np.sign(speed[1:]) != np.sign(speed[:-1])]
    if not len(turns):
        return np.zeros(len(time), bool)
    after = np.searchsorted(turns, time).clip(0, len(turns) - 1)
    apart = np.minimum(np.abs(turns[after] - time), np.abs(turns[np.maximum(after - 1, 0)] - time))
    return apart <= _NEAR


def _sum(power: Sequence[np.ndarray], where: Sequence[np.ndarray]) -> float:
    return float(sum(p[there].sum() for p, there in zip(power, where, strict=True)))


def _chance(power: Sequence[np.ndarray], where: Sequence[np.ndarray], seed: int) -> float:
    """Chance of a sum this large if the regime had nothing to do with the force."""
    rng, total = np.random.default_rng(seed), np.zeros(_SHIFTS)
    for p, there in zip(power, where, strict=True):
        # The sum under every shift at once: a circular correlation.
        every = np.fft.irfft(np.fft.rfft(p) * np.conj(np.fft.rfft(there.astype(float))), len(p))
        total += every[rng.integers(0, len(p), _SHIFTS)]
    return float((1 + np.sum(total >= _sum(power, where) * (1.0 - 1e-9))) / (_SHIFTS + 1))
