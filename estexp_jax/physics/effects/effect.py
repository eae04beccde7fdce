"""What a hypothesis about reality is made of: effects, each acting at its own stage of a simulation.

An effect knows where it can act on a robot (its sites) and how strongly (its parameters). Its values on one robot are
an array (n_sites, n_parameters); at `neutral` everywhere, the simulation is the nominal one. It also answers what a
search asks of it: from which values to start, which simpler effect it contains, which value of the model it changes,
whether recordings can show it at all. Nothing outside this folder knows an effect by its name.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, final

import mujoco

from estexp_jax.physics.effects import guesses
from estexp_jax.physics.effects.guesses import Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

Array = Any
"""An array over sites, or a number."""
Arrays = tuple[Array, ...]

NEVER = 1e6
"""Neutral value of limits and the like: no robot gets there."""


@final
@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    Attributes:
        name: as in findings and on the command line.
        unit: SI; empty for a ratio.
        neutral: the value at which the effect is absent.
        signed: whether both signs make sense.
        refers: a kind of element, where the number is 1 + the index of one of these; 0 is none.
    """

    name: str
    unit: str
    neutral: float = 0.0
    signed: bool = False
    refers: str = ""


class Effect(abc.ABC):
    """A way in which a robot may differ from its simulator.

    Class attributes that every effect sets:
        name: as in findings.
        kind: kind of element it acts on: joint, actuator, sensor, body, environment or controller.
        parameters: its numbers, in the order of the value array's columns.
        equation: what it does, as text.
        source: where the law is described.

    Class attributes with defaults, in the order in which they stand below, have their meaning beside them.
    """

    name: ClassVar[str]
    kind: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    equation: ClassVar[str]
    source: ClassVar[str] = ""

    #: What is wrong with it: plant, command or sensor.
    side: ClassVar[str] = "plant"
    #: Whether MJCF has a place for it; then `write_mjcf` puts it there, unless `mjcf_refusal` says why not.
    in_mjcf: ClassVar[bool] = False
    #: Whether it adds states, forces or memory to MJCF, and is not a value of an element that is there.
    extends_mjcf: ClassVar[bool] = False
    #: Parts of the model that must be there when MJX compiles it, or later values of them do nothing; see `mjx_model`.
    arms: ClassVar[tuple[str, ...]] = ()
    #: Flags of MJCF's options with any of which disabled it does nothing.
    flags: ClassVar[tuple[str, ...]] = ()

    #: Whether it is reported under its name; else it is an unknown law, and reported by its equation.
    named: ClassVar[bool] = True
    #: Whether an explanation may claim it; else it is only fitted beside claims, as an error of a value of the model.
    claimable: ClassVar[bool] = True
    #: Name of the simpler effect that it contains or nearly equals: compared with it wherever it is claimed.
    nested_in: ClassVar[str] = ""
    #: Name of the effect of which it is another form: tried wherever that is, and reported under that name.
    variant_of: ClassVar[str] = ""
    #: Name of the effect beside which it is tried, of a law without a name.
    tried_beside: ClassVar[str] = ""
    #: Name of the effect with which it shares one place among the candidates of a search.
    family: ClassVar[str] = ""
    #: Name of the effect at the driven joint that it equals as long as the motor is on.
    alike_while_on: ClassVar[str] = ""
    #: Whether it may act at a joint beside the terms of an unknown law, which need not repeat it.
    beside_laws: ClassVar[bool] = False
    #: Whether it is a force A sin(n q + phase) with these parameters, so that a periodogram shows where to start.
    sinusoidal: ClassVar[bool] = False

    #: Whether it adds a force in proportion to its first parameter, so that a balance of torques can size it. What
    #: scales a motor or a mass cannot be sized so: a balance is best where both its sides are next to nothing.
    additive: ClassVar[bool] = False
    #: Whether it is nothing but a constant torque at each joint.
    is_constant_torque: ClassVar[bool] = False

    #: Element and attribute of MJCF to whose value its first parameter is added; "*" for several attributes. Such
    #: values are usually a little off, so they are fitted beside whatever is claimed.
    model_attribute: ClassVar[tuple[str, str] | None] = None
    #: Whether its first parameter is the lost share of the model's value, not a difference from it.
    is_loss: ClassVar[bool] = False
    #: Whether it comes on by itself during a recording, so that it makes up for an onset.
    grows_in_time: ClassVar[bool] = False
    #: Whether the readings at its site say nothing of the robot.
    masks_readings: ClassVar[bool] = False
    #: Whether it moves the zero of a joint, so that it is no force but acts on the joint's sensor as a bias does.
    moves_zero: ClassVar[bool] = False
    #: Whether the body at its site and all below it are gone.
    removes_part: ClassVar[bool] = False

    @abc.abstractmethod
    def sites(self, robot: Robot) -> tuple[str, ...]:
        """Names of the elements it can act on; `("",)` for the environment; may be empty."""

    @abc.abstractmethod
    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        """Plausible (low, high) of each parameter at a site, in its unit."""

    @abc.abstractmethod
    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        """What it says about the robot, in plain words with numbers."""

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        """The name under which it is reported at these values, and those of them that this name has.

        Numbers that only this form has may be among them, where the sentence and the equation of that name tell them.
        """
        return self.name, values

    def equation_with_values(self, values: Mapping[str, float]) -> str:
        """What it does, as text, with its numbers where it has no name to know it by."""
        return self.equation

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        """Why MJCF has no place for it on this robot, at this site or at these values; empty where it has one."""
        return "" if self.in_mjcf else "MuJoCo has no element for it"

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Put the effect into a description, where MJCF has a place for it; `values` holds every parameter."""
        raise NotImplementedError(f"{self.name} has no place in MJCF")

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        """Values to start a search from, at which the effect is present at a site.

        Costs have several valleys: give sizes orders of magnitude apart, and every place where a limit may lie.
        By default all parameters lie a little, somewhat or strongly towards their bounds.
        """
        return guesses.towards_bounds([p.neutral for p in self.parameters], self.bounds(robot, site))

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        """Values to start from, within its bounds, where those of the effect named by `nested_in` are known."""
        return []

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        """Values to start the effect named by `nested_in` from, where its own are known."""
        return []

    def searched_bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        """Bounds within which it is searched, where another effect says the same better in a part of `bounds`."""
        return self.bounds(robot, site)

    def nominal_value(self, robot: Robot, site: str) -> float:
        """The model's own value that its first parameter changes at a site; 0 where the model has none."""
        return 0.0

    def feasible(self, robot: Robot, site: str, recordings: Sequence[Recording]) -> bool:
        """Whether training recordings can come from a robot with the effect at a site, whatever its values."""
        return True

    def identifiable(self, robot: Robot, site: str, values: Mapping[str, float], observed: Observed) -> bool:
        """Whether training recordings show enough to tell these values of it."""
        return True

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        """What to record next to tell it from what looks alike, a sentence each."""
        return ()


def neutral_values(effect: Effect, n_sites: int) -> list[list[float]]:
    """Values (n_sites, n_parameters) at which an effect does nothing."""
    return [[p.neutral for p in effect.parameters] for _ in range(n_sites)]
