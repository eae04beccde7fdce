"""Laws of effects as NumPy programs over instances: sites and lanes where the effect is at work.

A law is elementwise, so one program serves any robot and any mix of sites and lanes. Everything is in double precision,
as MuJoCo's C engine is.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, BodyForce, CommandLaw, JointState, Term
from estexp_jax.physics.engines.c.law_inputs import (
    MOUNT_ROWS,
    OWN_ROWS,
    MotorFields,
    RobotFields,
    RobotInputs,
    SiteFields,
    TermInputs,
    joint_state,
    mount_of_rows,
)
from estexp_jax.physics.engines.c.numpy_operations import ANY_LENGTH
from estexp_jax.physics.engines.c.numpy_programs import NumpyProgram, instances_shape
from estexp_jax.physics.engines.motors import idle_commands, limited_commands

_PROGRAMS = 512
"""Programs of one kind that are kept."""
_WIDTHS = MotorFields(6, 10, 10, 0, 0, 0, 2, 0, 2)
"""Numbers of a motor in each field; 0: one, without an axis."""


class TermProgram(NamedTuple):
    """A term's program.

    Attributes:
        law: (site and robot, rows, rows of the robot) -> what it does, a row for each of `names`, then its hidden
            variables. Rows are as `TermInputs` and `RobotInputs` take them; the robot's only where it couples joints.
        names: of `JointForce`'s fields that it sets; `command` has a row for each motor.
    """

    law: NumpyProgram
    names: tuple[str, ...]


@lru_cache(maxsize=_PROGRAMS)
def term_program(e: Term, motors: int, others: tuple[int, int] | None) -> TermProgram:
    """A term's program.

    Args:
        e: the term.
        motors: most motors at one of its sites.
        others: numbers of joints and motors of the robot, for one that `couples_joints`.
    """
    names: list[str] = []
    mounts = mount_rows(e)

    def act(fixed: tuple[SiteFields, RobotFields | None], rows_in: Any, *robot_rows: Any) -> list[Any]:
        site, robot = fixed
        now = TermInputs.of_rows(rows_in, motors, site.there, mounts)
        moving = RobotInputs.of_rows(*robot_rows, *robot.drives.shape) if robot is not None else None
        does, state = e.act(site.p, joint_state(site, now, robot, moving), now.state)
        names[:] = [name for name, x in does._asdict().items() if not isinstance(x, float)]
        rows: list[Any] = []
        for name in names:
            x = getattr(does, name)
            rows += list(_further(site, now, x)) if name == "command" else [x]
        return [*rows, *(state if e.n_states else ())]

    rows = [instances_shape(len(OWN_ROWS) + 3 * motors + mounts + e.n_states, ANY_LENGTH)]
    rows += [instances_shape(2 * others[0] + 3 * others[1], ANY_LENGTH)] if others else []
    fixed = _site_shapes(len(e.parameters), motors), _robot_shapes(*others) if others else None
    return TermProgram(NumpyProgram(act, fixed, *rows), tuple(names))


def _motor_shapes(motors: int) -> MotorFields:
    widths = [(width,) if width else () for width in _WIDTHS]
    kinds = [int if "type" in name else bool if "limited" in name else float for name in MotorFields._fields]
    shapes = [instances_shape(motors, ANY_LENGTH, *w, dtype=k) for w, k in zip(widths, kinds, strict=True)]
    return MotorFields(*shapes)


def _site_shapes(parameters: int, motors: int) -> SiteFields:
    one = instances_shape(ANY_LENGTH)
    there, limited = instances_shape(motors, ANY_LENGTH), instances_shape(ANY_LENGTH, dtype=bool)
    return SiteFields((one,) * parameters, _motor_shapes(motors), there, limited, instances_shape(ANY_LENGTH, 2), one)


def _robot_shapes(joints: int, motors: int) -> RobotFields:
    limited, limits = instances_shape(joints, ANY_LENGTH, dtype=bool), instances_shape(joints, ANY_LENGTH, 2)
    drives = instances_shape(joints, motors)
    return RobotFields(instances_shape(joints), _motor_shapes(motors), drives, limited, limits)


def _further(site: SiteFields, now: TermInputs, more: Any) -> Any:
    """Commands (motors, n) that ask for so much more torque, a site's motors for equal parts."""
    strength = site.motors.actuator_gear[..., 0] * site.motors.actuator_gainprm[..., 0] * now.motors.scale
    part = more / jnp.maximum(jnp.sum(site.there, axis=0), 1.0)
    further = jnp.where(strength == 0.0, 0.0, part / jnp.where(strength == 0.0, 1.0, strength))
    return limited_commands(site.motors, now.motors.ctrl) + further * site.there


def couples_joints(e: Term) -> bool:
    """Whether a term asks for another joint's motion or torque, or for what all motors do."""
    return not _asked_by(e).isdisjoint(("torque_of", "motion_of", "load"))


def mount_rows(e: Term) -> int:
    """Numbers of a mount that a term is given."""
    return MOUNT_ROWS if e.kind == "body" else 0


def feels_gravity(e: Term) -> bool:
    """Whether a term asks for the torque that gravity puts on its joint."""
    return "gravity" in _asked_by(e)


@lru_cache(maxsize=_PROGRAMS)
def _asked_by(e: Term) -> frozenset[str]:
    """The functions of a joint's state that a term calls."""
    asked: set[str] = set()

    def probe(x: Any) -> Any:
        def answer(name: str, found: Any) -> Any:
            asked.add(name)
            return found

        answers = {"motion_of": (x, x), "asked": (x, x), "mount": mount_of_rows([x] * MOUNT_ROWS)}
        values = dict.fromkeys(JointState._fields[:7], x)
        calls = {name: lambda *_, name=name: answer(name, answers.get(name, x)) for name in JointState._fields[7:]}
        return jax.tree.leaves(e.act((x,) * len(e.parameters), JointState(**values, **calls), (x,) * e.n_states))

    jax.eval_shape(probe, jax.ShapeDtypeStruct((1,), jnp.result_type(float)))
    return frozenset(asked)


@lru_cache(maxsize=_PROGRAMS)
def command_program(e: CommandLaw) -> NumpyProgram:
    """A command law: ((p, motor (1, n), whether it drives a joint), rows) -> its command and hidden variables.

    Rows that go in: q, w, command, dt, hidden variables.
    """

    def act(fixed: tuple[Arrays, MotorFields, Any], rows: Any) -> list[Any]:
        (p, motor, drives), (q, w, ctrl, dt) = fixed, rows[:4]
        command = limited_commands(motor, ctrl[None])[0]
        idle = jnp.where(drives, idle_commands(motor, ..., q, w)[0], 0.0)  # pyright: ignore[reportArgumentType]
        after, hidden = e.act(p, command, idle, dt, tuple(rows[4:]))
        return [after, *(hidden if e.n_states else ())]

    one = instances_shape(ANY_LENGTH)
    fixed = (one,) * len(e.parameters), _motor_shapes(1), instances_shape(ANY_LENGTH, dtype=bool)
    return NumpyProgram(act, fixed, instances_shape(4 + e.n_states, ANY_LENGTH))


@lru_cache(maxsize=_PROGRAMS)
def rest_program(e: Term | CommandLaw) -> NumpyProgram:
    """Hidden variables at rest: (p, q, w) of a term, ((p, motor (1, n)), command) of a command law."""
    one = instances_shape(ANY_LENGTH)
    p = (one,) * len(e.parameters)
    if isinstance(e, Term):
        return NumpyProgram(e.initial, p, one, one)
    law = e

    def rest(fixed: tuple[Arrays, MotorFields], ctrl: Any) -> Arrays:
        return law.initial(fixed[0], limited_commands(fixed[1], ctrl[None])[0])

    return NumpyProgram(rest, (p, _motor_shapes(1)), one)


@lru_cache(maxsize=_PROGRAMS)
def body_program(e: BodyForce) -> NumpyProgram:
    """A body force: (p, positions (3, n)) -> forces along three axes."""

    def act(p: Arrays, position: Any) -> tuple[Any, Any, Any]:
        x, y, z = position
        return e.force_on_body(p, (x, y, z))

    return NumpyProgram(act, (instances_shape(ANY_LENGTH),) * len(e.parameters), instances_shape(3, ANY_LENGTH))
