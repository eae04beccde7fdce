"""Laws of effects as small compiled programs over instances: sites and lanes where the effect is at work.

A law is elementwise, so one program serves any robot and any mix of sites and lanes; it is compiled for few lengths of
its arrays. Everything is in double precision, as MuJoCo's C engine is.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, BodyForce, CommandLaw, JointState, Term
from estexp_jax.physics.engines.c.law_inputs import (
    MotorFields,
    RobotFields,
    RobotInputs,
    SiteFields,
    TermInputs,
    joint_state,
)
from estexp_jax.physics.engines.motors import idle_commands, limited_commands

_PROGRAMS = 512
"""Programs of one kind that are kept."""


class TermProgram(NamedTuple):
    """A term, compiled as it is used.

    Attributes:
        act: (site, rows, robot, rows of the robot) -> what it does, a row (n,) for each of `names`, then its hidden
            variables; rows as `TermInputs` and `RobotInputs` take them.
        names: of `JointForce`'s fields that it sets, once it was called; `command` has a row for each motor.
    """

    act: Callable[[SiteFields, Any, RobotFields | None, Any], jax.Array]
    names: list[str]


@lru_cache(maxsize=_PROGRAMS)
def term_program(e: Term, motors: int) -> TermProgram:
    """A term's program for sites with at most so many motors."""
    names: list[str] = []

    def act(site: SiteFields, rows_in: Any, robot: RobotFields | None, robot_rows: Any) -> jax.Array:
        now = TermInputs.of_rows(rows_in, motors, site.there)
        moving = RobotInputs.of_rows(robot_rows, *robot.drives.shape) if robot is not None else None
        does, state = e.act(site.p, joint_state(site, now, robot, moving), now.state)
        names[:] = [name for name, x in does._asdict().items() if not isinstance(x, float)]
        rows: list[Any] = []
        for name in names:
            x = jnp.broadcast_to(getattr(does, name), now.q.shape)
            rows += list(_further(site, now, x)) if name == "command" else [x]
        rows += [jnp.broadcast_to(x, now.q.shape) for x in (state if e.n_states else ())]
        return jnp.stack(rows) if rows else jnp.zeros((0, *now.q.shape))

    return TermProgram(jax.jit(act), names)


def _further(site: SiteFields, now: TermInputs, more: Any) -> Any:
    """Commands (motors, n) that ask for so much more torque, a site's motors for equal parts."""
    strength = site.motors.actuator_gear[..., 0] * site.motors.actuator_gainprm[..., 0] * now.motors.scale
    part = more / jnp.maximum(jnp.sum(site.there, axis=0), 1.0)
    further = jnp.where(strength == 0.0, 0.0, part / jnp.where(strength == 0.0, 1.0, strength))
    return limited_commands(site.motors, now.motors.ctrl) + further * site.there


@lru_cache(maxsize=_PROGRAMS)
def couples_joints(e: Term) -> bool:
    """Whether a term asks for another joint's motion or torque."""
    asked: list[Any] = []

    def other(number: Any) -> Any:
        asked.append(number)
        return jnp.zeros_like(number)

    def probe(x: Any) -> Any:
        joint = JointState(
            *(x,) * 7, lambda q, w: x, other, lambda number: (other(number), x), lambda: (x, x)
        )
        return e.act((x,) * len(e.parameters), joint, (x,) * e.n_states)

    does = jax.eval_shape(lambda x: jax.tree.leaves(probe(x)), jax.ShapeDtypeStruct((1,), float))
    return bool(asked) and bool(does)


@lru_cache(maxsize=_PROGRAMS)
def command_program(e: CommandLaw) -> Callable[[Arrays, MotorFields, Any, Any], jax.Array]:
    """A command law: (p, motor (1, n), whether it drives a joint, rows) -> rows of its command and hidden variables.

    Rows that go in: q, w, command, dt, hidden variables.
    """

    def act(p: Arrays, motor: MotorFields, drives: Any, rows: Any) -> jax.Array:
        q, w, ctrl, dt = rows[:4]
        command = limited_commands(motor, ctrl[None])[0]
        idle = jnp.where(drives, idle_commands(motor, ..., q, w)[0], 0.0)  # pyright: ignore[reportArgumentType]
        after, hidden = e.act(p, command, idle, dt, tuple(rows[4:]))
        return jnp.stack([jnp.broadcast_to(x, q.shape) for x in (after, *(hidden if e.n_states else ()))])

    return jax.jit(act)


@lru_cache(maxsize=_PROGRAMS)
def rest_program(e: Term | CommandLaw) -> Callable[..., jax.Array]:
    """Hidden variables at rest: (p, position and speed) of a term, (p, motor (1, n), command) of a command law."""
    if isinstance(e, Term):
        term = e

        def rest(p: Arrays, q: Any, w: Any) -> jax.Array:
            return jnp.stack([jnp.broadcast_to(x, q.shape) for x in term.initial(p, q, w)])

        return jax.jit(rest)
    law = e

    def rest_of(p: Arrays, motor: MotorFields, ctrl: Any) -> jax.Array:
        return jnp.stack(law.initial(p, limited_commands(motor, ctrl[None])[0]))

    return jax.jit(rest_of)


@lru_cache(maxsize=_PROGRAMS)
def body_program(e: BodyForce) -> Callable[..., jax.Array]:
    """A body force: (p, positions (3, n)) -> forces (3, n)."""

    def act(p: Arrays, position: Any) -> jax.Array:
        x, y, z = position
        return jnp.stack([jnp.broadcast_to(f, x.shape) for f in e.force_on_body(p, (x, y, z))])

    return jax.jit(act)
