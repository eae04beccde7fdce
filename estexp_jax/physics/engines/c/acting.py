"""All that acts in a step of a chunk's lanes: command laws, then terms, in the catalogue's order, and body forces."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

import numpy as np

from estexp_jax.physics.effects.base import BodyForce, CommandLaw, Term
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.elements import element_values
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.engines.c.acting_motors import Chunk
from estexp_jax.physics.engines.c.body_forces import ActingBodyForce
from estexp_jax.physics.engines.c.carried_momenta import CarriedMomenta
from estexp_jax.physics.engines.c.command_laws import ActingCommandLaw
from estexp_jax.physics.engines.c.instances import at_work, instances_of
from estexp_jax.physics.engines.c.lane_models import LaneModels
from estexp_jax.physics.engines.c.laws import feels_gravity
from estexp_jax.physics.engines.c.step_table import StepTable
from estexp_jax.physics.engines.c.terms import ActingTerm
from estexp_jax.physics.model.robot import Robot

LaneHidden = dict[str, np.ndarray]
"""Hidden variables (variables, instances) of each effect that has some and is at work, by its name."""


@final
class ActingEffects:
    """The effects of a catalogue that act during steps, where they are at work.

    Attributes:
        laws, terms, body_forces: those that are anywhere.
    """

    def __init__(self, robot: Robot, catalogue: Catalogue, models: LaneModels, values: Values) -> None:
        """With edited models, and values (lanes, n_sites, n_parameters) of each effect."""
        asks = [e for e in catalogue if isinstance(e, Term) and (feels_gravity(e) or e.kind == "body")]
        asking = np.zeros(models.lanes, bool)
        for e in asks:
            asking |= at_work(e, np.asarray(values[e.name])).any(axis=1)
        carried = CarriedMomenta(models, np.flatnonzero(asking)) if asking.any() else None
        self._chunk = Chunk(robot, models, StepTable(robot.model, models.lanes), carried)
        self.laws: list[ActingCommandLaw] = []
        self.terms: list[ActingTerm] = []
        self.body_forces: list[ActingBodyForce] = []
        for e in catalogue:
            if not isinstance(e, CommandLaw | Term | BodyForce):
                continue
            own = np.asarray(values[e.name])
            there = instances_of(e, own if isinstance(e, BodyForce) else element_values(e, robot, own))
            if there is None:
                continue
            if isinstance(e, CommandLaw):
                self.laws.append(ActingCommandLaw(e, self._chunk, there))
            elif isinstance(e, Term):
                self.terms.append(ActingTerm(e, self._chunk, there))
            elif isinstance(e, BodyForce):
                self.body_forces.append(ActingBodyForce(e, robot, there))
        self._armature = np.array(models.read("dof_armature"))  # a copy: terms change the field itself
        self._disabled = _disabled(robot)

    @property
    def table(self) -> StepTable:
        """Of the present step."""
        return self._chunk.table

    @property
    def written(self) -> set[str]:
        """Parts of the table that terms have changed so far."""
        return set[str]().union(*(term.written for term in self.terms))

    def begin(
        self, qpos: np.ndarray, qvel: np.ndarray, ctrl: np.ndarray, enable: np.ndarray, dt: np.ndarray
    ) -> StepTable:
        """The table filled with the beginning of a step: arrays (lanes, ...), switches of motors among them."""
        table = self.table
        table["qpos"][:], table["qvel"][:], table["ctrl"][:], table["dt"][:, 0] = qpos, qvel, ctrl, dt
        table["on"][:] = self.switches(enable)
        table["share"][:], table["rotor_inertia"][:] = 1.0, self._armature
        for part in ("force", "damping", "friction", "gravity"):
            table[part][:] = 0.0
        if (carried := self._chunk.carried) is not None:
            carried.update(qpos)
            table["gravity"][:] = carried.gravity_torques()
        return table

    def switches(self, enable: np.ndarray) -> np.ndarray:
        """Which motors (lanes, motors) are on, of their switches (lanes, motors); 1.0 or 0.0."""
        return np.where(self._disabled, 0.0, enable)

    def rest(self) -> LaneHidden:
        """Hidden variables of robots that have been where the table says, under its commands, for long."""
        return {e.effect.name: e.rest(self.table) for e in (*self.laws, *self.terms) if e.effect.n_states}

    def act(self, hidden: LaneHidden) -> LaneHidden:
        """Let command laws and terms act in the step that has begun; hidden variables after it."""
        return self._after((*self.laws, *self.terms), hidden)

    def roll(self, hidden: LaneHidden) -> LaneHidden:
        """Hidden variables after a step whose motion is given, so that forces do not matter."""
        return self._after((*self.laws, *(term for term in self.terms if term.lasts)), hidden)

    def _after(self, acting: Iterable[ActingCommandLaw | ActingTerm], hidden: LaneHidden) -> LaneHidden:
        after: LaneHidden = {}
        for e in acting:
            state = e.act(self.table, hidden.get(e.effect.name))
            if e.effect.n_states:
                after[e.effect.name] = state
        return after

    def kept(self, moves: np.ndarray, before: LaneHidden, after: LaneHidden) -> LaneHidden:
        """Hidden variables after a step in lanes that it moves (lanes,), before it in the others."""
        if moves.all():
            return after
        found = {}
        for e in (*self.laws, *self.terms):
            if (name := e.effect.name) in after:
                found[name] = np.where(moves[e.lane], after[name], before[name])
        return found


def _disabled(robot: Robot) -> np.ndarray:
    """Which motors (motors,) are in a group that the model's options switch off."""
    model = robot.model
    group, off = model.actuator_group, int(model.opt.disableactuator)
    return (group >= 0) & (group < 31) & ((off >> np.clip(group, 0, 30)) & 1 == 1)
