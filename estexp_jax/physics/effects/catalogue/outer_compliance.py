"""Joint compliance inside a servo's loop, reported as joint compliance."""

from collections.abc import Mapping
from typing import ClassVar, final

from estexp_jax.physics.effects.catalogue.joint_compliance import Compliance
from estexp_jax.physics.effects.registry import register_effect


@register_effect
@final
class OuterCompliance(Compliance):
    """The motor's own loop sees the joint, by an encoder behind the spring; reported as joint compliance."""

    name: ClassVar[str] = "outer_compliance"
    collocated: ClassVar[bool] = False
    variant_of: ClassVar[str] = "joint_compliance"

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "joint_compliance", values
