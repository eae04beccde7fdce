"""Laws that every effect obeys, of the catalogue or a user's own: asked when one is registered, and by the tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.base import (
    BodyForce,
    CommandLaw,
    CommandShift,
    Distortion,
    Edit,
    Effect,
    JointForce,
    JointState,
    ReadingDrift,
    ReadingShift,
    Term,
    neutral_values,
)
from estexp_jax.physics.effects.changes import Change, encode, fixed_values, neutral, parse_change
from estexp_jax.physics.effects.controller_fault import ControllerFault
from estexp_jax.physics.effects.logging_fault import LoggingFault
from estexp_jax.physics.effects.search_checks import guess_faults, relation_faults
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

KINDS = ("joint", "actuator", "sensor", "body", "environment", "recording", "controller")
SIDES = ("plant", "command", "sensor", "numerics")
_INSIDE = 0.7
"""Where between its bounds an effect is tried."""


def effect_faults(effect: Effect, robot: Robot | None = None) -> list[str]:
    """What is wrong with an effect, a clause each; nothing where it is sound.

    Args:
        effect: of the catalogue or registered; what it says of itself can be asked of any.
        robot: on which it is tried; None: only what it says of itself.
    """
    found = [*_said(effect)] or [*relation_faults(effect)]
    if found or robot is None:
        return found
    for law in (_places, _ranges, guess_faults, _sentences, _carried, _neutral):
        found = [f"{robot.source}: {fault}" for fault in _asked(law, effect, robot)]
        if found:
            return found
    return []


def middle_values(effect: Effect, robot: Robot, site: str) -> dict[str, float]:
    """Parameters well inside the bounds."""
    bounds = effect.bounds(robot, site)
    return {p.name: low + _INSIDE * (high - low) for p, (low, high) in zip(effect.parameters, bounds, strict=True)}


def _said(e: Effect) -> Iterator[str]:
    for name in ("name", "kind", "parameters", "equation"):
        if not getattr(e, name, None):
            yield f"has no {name}"
            return
    if not (e.name.isidentifier() and e.name.islower()):
        yield f"is called '{e.name}', which is no lower-case identifier"
    if e.kind not in KINDS:
        yield f"has the kind '{e.kind}', which is none of {', '.join(KINDS)}"
    if e.side not in SIDES:
        yield f"has the side '{e.side}', which is none of {', '.join(SIDES)}"
    if not e.source:
        yield "has no source: where its law is described"
    if len({p.name for p in e.parameters}) < len(e.parameters):
        yield "has two parameters of one name"


def _asked(law: Callable[[Effect, Robot], Iterator[str]], e: Effect, robot: Robot) -> list[str]:
    """What a law finds, or that the effect cannot be asked."""
    try:
        return list(law(e, robot))
    except (ArithmeticError, AttributeError, IndexError, InputError, KeyError, TypeError, ValueError) as error:
        return [f"cannot be used: {type(error).__name__}: {error}"]


def _places(e: Effect, robot: Robot) -> Iterator[str]:
    sites = list(e.sites(robot))
    if len(set(sites)) < len(sites):
        yield "names a place twice"
    if e.kind == "controller":
        return
    elements = {"environment": "body", "recording": "channel"}.get(e.kind, e.kind)
    exist = {*robot.names(elements), *(("",) if e.kind == "environment" else (ALL_ALIKE,))}
    exist |= {""} if e.kind == "recording" else set()
    for site in sorted(set(sites) - exist):
        yield f"names the place '{site}', where no {e.kind} is"


def _ranges(e: Effect, robot: Robot) -> Iterator[str]:
    for site in e.sites(robot):
        bounds = np.array(e.bounds(robot, site), dtype=float)
        if bounds.shape != (len(e.parameters), 2):
            yield f"gives bounds {bounds.shape} at '{site}'; one (low, high) a parameter is wanted"
        elif not (np.isfinite(bounds).all() and (bounds[:, 0] <= bounds[:, 1]).all()):
            yield f"gives bounds at '{site}' that are not finite or not in order"
        else:
            yield from _signs(e, site, bounds)


def _signs(e: Effect, site: str, bounds: np.ndarray) -> Iterator[str]:
    for parameter, low in zip(e.parameters, bounds[:, 0], strict=True):
        if low < 0.0 and not parameter.signed:
            yield f"has a lower bound of {low:g} for '{parameter.name}' at '{site}', which is not said to be signed"
        if parameter.refers and parameter.neutral != 0.0:
            yield f"has a reference '{parameter.name}' whose neutral value is not 0"
    if not np.any(bounds != np.array([p.neutral for p in e.parameters])[:, None]):
        yield f"cannot be present at '{site}': its bounds are its neutral values"


def _sentences(e: Effect, robot: Robot) -> Iterator[str]:
    for site in e.sites(robot):
        said = e.sentence(site, middle_values(e, robot, site))
        if site not in said:
            yield f"says nothing of '{site}' in its sentence there"
        if not any(c.isdigit() for c in said.replace(site, "")) and not fixed_values(e, robot, site):
            yield "says no number in its sentence"
        if "\n" in said or said.endswith("."):
            yield "says more than one clause: no line break, no full stop at the end"


def _carried(e: Effect, robot: Robot) -> Iterator[str]:
    """Text, JSON and arrays carry it unchanged."""
    for row, site in enumerate(e.sites(robot)):
        change = Change(e.name, site or None, middle_values(e, robot, site))
        text = " ".join([change.place, *(f"{k}={v!r}" for k, v in change.parameters.items())])
        if parse_change(text, robot) != change or Change.from_json(change.to_json()) != change:
            yield f"is another when it was written and read, at '{site}'"
        wanted = neutral(robot, (e,))[e.name]
        wanted[row] = list(change.parameters.values())
        if not np.allclose(encode(robot, (e,), [change])[e.name], wanted, rtol=1e-6):
            yield f"has other values in arrays, at '{site}'"


def _neutral(e: Effect, robot: Robot) -> Iterator[str]:
    values = jnp.asarray(neutral_values(e, len(e.sites(robot))), jnp.float32).reshape(-1, len(e.parameters))
    before, after = _both(e, robot, values)
    if jax.tree.structure(before) != jax.tree.structure(after):
        yield "gives another structure than it was given"
        return
    for x, y in zip(jax.tree.leaves(before), jax.tree.leaves(after), strict=True):
        if not np.array_equal(np.asarray(x), np.asarray(y)):
            yield "changes something at its neutral values"
            return


def _both(e: Effect, robot: Robot, values: jax.Array) -> tuple[Any, Any]:
    """What an effect acts on, before and after, at values (n_sites, n_parameters)."""
    model, n = robot.model, len(values)
    p, line = tuple(values.T), jnp.linspace(-1.0, 1.0, len(values))
    match e:
        case Edit():
            before = mjx.put_model(model)
            return before, e.edit(robot, before, values)
        case Term():
            joint = sample_joint_state(n)
            force, _ = e.act(p, joint, e.initial(p, joint.q, joint.w))
            nothing = JointForce()
            return jax.tree.map(lambda x: jnp.broadcast_to(x, n), (nothing, force))
        case Distortion():
            readings = jnp.arange(2.0 * model.nsensordata).reshape(2, -1)
            return readings, e.distort(robot, readings, values)
        case ControllerFault():
            neurons = n if e.kind == "controller" else 1
            healthy = SampleParameters(jnp.linspace(0.5, 1.0, neurons), jnp.arange(model.nu, dtype=jnp.int32))
            return healthy, e.damage(robot, healthy, values)
        case CommandShift():
            return np.zeros(model.nu), e.shift(robot, np.asarray(values))
        case ReadingShift():
            return np.zeros(model.nsensordata), e.shift(robot, np.asarray(values))
        case ReadingDrift():
            return np.zeros(model.nsensordata), e.rate(robot, np.asarray(values))
        case CommandLaw():
            return line, e.act(p, line, 0.3 * line, 0.002, e.initial(p, line))[0]
        case LoggingFault():
            recording = sample_recording(model)
            columns = _columns(recording)
            for site in e.sites(robot):
                recording = e.logged(robot, recording, site, {p.name: p.neutral for p in e.parameters})
            return columns, _columns(recording)
        case BodyForce():
            nothing, place = jnp.zeros(n), jnp.ones(n)
            return (nothing,) * 3, e.force_on_body(p, (place, place, place))
        case _:
            raise TypeError(
                "it is no Edit, Term, BodyForce, CommandLaw, CommandShift, ReadingShift, Distortion or LoggingFault"
            )


def sample_recording(model: mujoco.MjModel) -> Recording:
    """A log in which everything moves."""
    time = 0.01 * np.arange(200.0)
    sizes = model.nu, model.nactuator, model.nsensordata, model.nq, model.nv
    ctrl, _, sensor, qpos, qvel = (np.sin(time[:, None] * (2.0 + np.arange(n)) + n) for n in sizes)
    return Recording("sample.csv", time, ctrl, np.ones((len(time), model.nactuator)), sensor, qpos, qvel)


def _columns(recording: Recording) -> tuple[np.ndarray, ...]:
    return recording.time, recording.ctrl, recording.sensor, recording.qpos, recording.qvel


class SampleParameters(NamedTuple):
    """As much of a controller's parameters as faults act on."""

    hidden_gain: jax.Array
    output_of: jax.Array


def sample_joint_state(n: int) -> JointState:
    """Joints (n,) that move, pulled by springs as motors."""
    ones, q = jnp.ones(n), jnp.linspace(-1.0, 1.0, n)
    return JointState(
        q=q,
        w=2.0 * ones,
        torque=_spring(q, 2.0 * ones),
        on=ones,
        dt=0.002,
        limit=5.0 * ones,
        armature=0.01 * ones,
        torque_at=_spring,
        torque_of=_other,
        motion_of=_moved,
        asked=lambda: (3.0 * ones, 3.0 - q),
    )


def _spring(q: jax.Array, w: jax.Array) -> jax.Array:
    return 3.0 - q - 0.1 * w


def _other(number: jax.Array) -> jax.Array:
    return 0.5 * number


def _moved(number: jax.Array) -> tuple[jax.Array, jax.Array]:
    return 0.2 * number, 0.3 * number
