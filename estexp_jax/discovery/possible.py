"""Claims that a look at the recordings rules out, before anything is simulated or by the values that were found."""

from __future__ import annotations

from collections.abc import Sequence

from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.reading_noise import holds_still
from estexp_jax.physics.recording import Recording


def possible(robot: Robot, place: Place, recordings: Sequence[Recording]) -> bool:
    """Whether an effect at a place can be what training recordings show: a sensor that moves is not stuck."""
    name, site = place
    return effect(name).feasible(robot, site, recordings)


def conceivable(robot: Robot, fitted: Fit, seen: Observed) -> bool:
    """Whether training recordings can show what a fit claims: half a wave is the least of cogging."""
    claims = fitted.hypothesis.changes(fitted.vector, claimed=True)
    return all(effect(c.effect).identifiable(robot, c.name or "", c.values, seen) for c in claims)


def still_throughout(robot: Robot, sensor: str, recordings: Sequence[Recording]) -> bool:
    """Whether training recordings show a sensor at one value from the first row on."""
    return all(holds_still(robot, r, sensor, 0.0) for r in recordings if r.role == "train")
