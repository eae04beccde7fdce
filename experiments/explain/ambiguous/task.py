"""One ambiguity settled, or not: explained, proposed, recorded, explained again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import estexp_jax as ee
from estexp_jax.api.explain import ExplainResult
from estexp_jax.discovery.selection import probabilities
from estexp_jax.experiment_design.excitation import multisine
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.write import write_csv
from estexp_jax.replay.explained_simulator import ExplainedSimulator, Traces
from experiments.explain.ambiguous.ambiguities import AMBIGUITIES, Ambiguity

SECONDS, RATE = 8.0, 50.0
BITS = 12
"""Resolution of the angles over a turn."""
ERROR = 0.01
"""Deviation of the real robot's ordinary errors, in every mass, damping, armature and gain, as a share."""
_FINER = 10
"""The real robot moves at this part of the model's step."""
LISTED, SAME = 0.05, 1.02
"""Least probability of what is open, and how near to the best in squared error on held-out windows what is open is."""
_CAPTURE, _SPEED = 5e-4, 5e-3
"""Noise of motion capture, of places (m) and quaternions and of speeds (m/s and rad/s)."""
_RANDOM = 0.3
"""Peak of the random motion, as a share of the actuators' reach."""


def settled(index: int, seed: int, folder: Path) -> dict[str, Any]:
    """A case: one of an ambiguity's effects is there, in turn.

    Args:
        index: of the ambiguity.
        seed: of the robot's errors, the effect's strength, motions and noise.
        folder: for its files.

    Returns:
        What is claimed before, and after one more recording: the proposed one, or a random one of the same length.
    """
    ambiguity, rng = AMBIGUITIES[index], np.random.default_rng([seed, 31, index])
    which = seed % len(ambiguity.effects)
    real = _Real(ambiguity, which, rng, folder)
    time = np.arange(round(SECONDS * RATE)) / RATE
    train = [real.log(f"train_{k}.csv", ambiguity.motion(time, rng)) for k in range(2)]
    test = real.log("test_0.csv", ambiguity.motion(time, rng))
    first = ee.explain(real.nominal.source, train, test=[test])
    first.write(folder / "first", force=True, pictures=False)
    found = {
        "ambiguity": ambiguity.name,
        "seed": seed,
        "truth": ambiguity.names[which],
        "before": assessed(first, ambiguity, which),
    }
    motions = {"random": multisine(real.nominal, time, _RANDOM, seed)}
    contest = first.diagnosis.competing_models
    if contest is not None and len(contest.models) > 1:
        proposal = ee.propose(folder / "first", duration=SECONDS, seed=seed, speed=10.0)
        motions["proposed"] = proposal.commands[:-1]
    for name, commands in motions.items():
        more = real.log(f"{name}.csv", commands)
        found[name] = assessed(ee.explain(real.nominal.source, [*train, more], test=[test]), ambiguity, which)
    return found


class _Real:
    """The real robot of a case, and its loggers."""

    def __init__(self, ambiguity: Ambiguity, which: int, rng: np.random.Generator, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "nominal.xml").write_text(ambiguity.robot(lambda x: x), encoding="utf-8")
        self.nominal, self._folder, self._rng = Robot.from_xml(folder / "nominal.xml"), folder, rng
        self._noise, self._rest = ambiguity.noise, ambiguity.rest
        wrong = Robot.from_string(ambiguity.robot(lambda x: x * (1.0 + ERROR * rng.standard_normal())), "real.xml")
        effect = parse_change(ambiguity.effects[which](float(rng.uniform())), wrong)
        self._simulator = ExplainedSimulator(wrong, (effect,), finer=_FINER)

    def log(self, name: str, commands: np.ndarray) -> str:
        """Move it and write what it logs; gives the file."""
        before = round(self._rest * RATE)
        whole = self._simulator.rollout(np.concatenate([commands[:1].repeat(before, 0), commands]), period=1.0 / RATE)
        traces = Traces(whole.time[: len(commands)], *(part[before:] for part in whole[1:]))
        step = 2.0 * np.pi / 2**BITS
        noisy = traces.sensors + self._rng.normal(0.0, self._noise, traces.sensors.shape)
        columns = {f"ctrl.{n}": commands[:, i] for i, n in enumerate(self.nominal.names("actuator"))}
        readings = np.round(noisy / step) * step
        columns |= {f"sensor.{n}": readings[:, i] for i, n in enumerate(self.nominal.sensor_columns())}
        if traces.qpos.shape[1] > traces.qvel.shape[1]:
            columns |= self._captured(traces)
        write_csv(self._folder / name, {"time": traces.time, **columns})
        return str(self._folder / name)

    def _captured(self, traces: Traces) -> dict[str, np.ndarray]:
        """Columns of a floating robot's pose and speeds, as motion capture has them."""
        rows, root = len(traces.time), self.nominal.names("joint")[0]
        pose = traces.qpos[:, :7] + self._rng.normal(0.0, _CAPTURE, (rows, 7))
        pose[:, 3:] /= np.linalg.norm(pose[:, 3:], axis=1, keepdims=True)
        speeds = traces.qvel[:, :6] + self._rng.normal(0.0, _SPEED, (rows, 6))
        columns = {f"qpos.{root}.{i}": pose[:, i] for i in range(7)}
        return columns | {f"qvel.{root}.{i}": speeds[:, i] for i in range(6)}


def assessed(found: ExplainResult, ambiguity: Ambiguity, which: int) -> dict[str, Any]:
    """What an explanation says of an ambiguity.

    Returns:
        verdict; claims, all of `what`; listed, those of the ambiguity that are open: of an explanation that is as
        likely as `LISTED`, or as good as the best on held-out windows; probability of the right one; alone, whether
        that one is named first and the only one of the ambiguity that is listed.
    """
    diagnosis, claims = found.diagnosis, [w["effect"] for w in found.findings["what"]]
    tried, shares = diagnosis.selection.tried, probabilities(diagnosis.selection, diagnosis.config.seed)[1:]
    least = min((e.held_out.sum() for e in tried), default=0.0)
    near = [p >= LISTED or e.held_out.sum() <= SAME * least for e, p in zip(tried, shares, strict=True)]
    right = ambiguity.names[which]
    said = [ambiguity.said({effect for effect, _ in e.places}) for e in tried]
    said = [(right,) if right in names else names for names in said]  # beside it, another one is no rival
    listed = tuple(
        name for name in ambiguity.names if any(o and name in names for names, o in zip(said, near, strict=True))
    )
    return {
        "verdict": found.findings["verdict"],
        "claims": [w["effect"] + (f"@{w['name']}" if w["name"] else "") for w in found.findings["what"]],
        "listed": list(listed),
        "probability": float(sum(p for names, p in zip(said, shares, strict=True) if right in names)),
        "alone": listed == (right,) and ambiguity.said(claims[:1]) == (right,),
    }
