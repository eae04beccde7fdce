"""A law term made of a named effect of the catalogue: the same physics, with the bounds and the words of a law.

The physics stands once, in the effect. The term takes over what the effect is: its parameters, equation, hidden
variables, force and place in MJCF. A subclass states only what differs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import mujoco

from estexp_jax.physics.effects.base import Array, Arrays, Effect, JointForce, JointState, Term
from estexp_jax.physics.effects.laws.base import JointLaw
from estexp_jax.physics.model.robot import Robot


class EffectLaw(JointLaw):
    """A term that says of a joint what a named effect says.

    A subclass names the effect with the keyword `effect`. Each of `parameters`, `equation`, `in_mjcf`, `extends_mjcf`,
    `arms` and `n_states` that the subclass (or a class it lists before this one) does not state is the effect's. A
    joint takes over nothing that an effect on actuators has in the model or in MJCF.

    Attributes:
        effect: the named effect.
        adds_to: field of `JointForce` to which the first parameter adds; for an effect that edits the model, which has
            no force of its own. Empty where the effect has one, or the subclass states `act` itself.
    """

    effect: ClassVar[Effect]
    adds_to: ClassVar[str] = ""

    def __init_subclass__(cls, effect: type[Effect], **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        before = cls.__mro__[: cls.__mro__.index(EffectLaw)]
        stated = {name for c in before for name in vars(c)}
        cls.effect = effect()
        for name, value in _taken_over(cls.effect).items():
            if name not in stated:
                setattr(cls, name, value)

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        return self.effect.initial(p, q, w) if isinstance(self.effect, Term) else super().initial(p, q, w)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        if self.adds_to:
            return JointForce()._replace(**{self.adds_to: p[0]}), state
        assert isinstance(self.effect, Term), f"{self.name} has to state its force: {self.effect.name} has none"
        return self.effect.act(p, joint, state)

    def effect_values(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """The effect's values, of the term's; a term with parameters of its own states them, or is not `in_mjcf`."""
        return values

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        if not self.in_mjcf:
            return super().mjcf_refusal(robot, site, values)
        return self.effect.mjcf_refusal(robot, site, self.effect_values(values))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        if not self.in_mjcf:
            super().write_mjcf(robot, spec, site, values)
        self.effect.write_mjcf(robot, spec, site, self.effect_values(values))


def _taken_over(effect: Effect) -> dict[str, Any]:
    """Class attributes that a term has of its effect."""
    at_joint = effect.kind == "joint"
    return {
        "stands_for": effect.name,
        "parameters": effect.parameters,
        "equation": effect.equation,
        "in_mjcf": at_joint and effect.in_mjcf,
        "extends_mjcf": at_joint and effect.extends_mjcf,
        "arms": effect.arms if at_joint else (),
        "n_states": effect.n_states if isinstance(effect, Term) else 0,
    }
