"""All terms of unknown laws, in the order in which they are tried and act.

Nobody claims one by name; a few of them at one joint are reported as its `unknown_law`. The last two act on other
elements than joints: each is claimed as an effect is, not put together of terms.
"""

from estexp_jax.physics.effects.laws.base import JointLaw
from estexp_jax.physics.effects.laws.commands import LawDeafMotor, LawLateCommand
from estexp_jax.physics.effects.laws.coupling import (
    LawFling,
    LawSquareFling,
    LawStir,
    LawTie,
    LawTow,
    LawWhirl,
)
from estexp_jax.physics.effects.laws.friction import LawBristles, LawFrictionWave, LawTightSpot, LawTwoWayFriction
from estexp_jax.physics.effects.laws.motors import (
    LawClippedMotor,
    LawSag,
    LawSlowMotor,
    LawSoftMotor,
    LawWarmMotor,
    LawWeakMotor,
)
from estexp_jax.physics.effects.laws.named_effects import (
    LawDamping,
    LawDrag,
    LawDriven,
    LawDryFriction,
    LawInertia,
    LawLoadFriction,
    LawMotorBrake,
    LawPush,
    LawSpring,
    LawWave,
)
from estexp_jax.physics.effects.laws.position import (
    LawBump,
    LawCube,
    LawDetent,
    LawLowerSpring,
    LawSquare,
    LawUpperSpring,
)
from estexp_jax.physics.effects.laws.sensors import LawDrift
from estexp_jax.physics.effects.laws.speed import (
    LawCubicDrag,
    LawFallingFriction,
    LawHump,
    LawOneWayDamping,
    LawPlaceDamping,
    LawSmoothFriction,
)
from estexp_jax.physics.effects.laws.time_dependent import LawCreep, LawRhythm, LawThinning
from estexp_jax.physics.effects.registry import every, register_effect

for _law in (
    LawSquare(),
    LawCube(),
    LawBump(),
    LawDetent(),
    LawUpperSpring(),
    LawLowerSpring(),
    LawOneWayDamping(),
    LawCubicDrag(),
    LawSmoothFriction(),
    LawHump(),
    LawPlaceDamping(),
    LawTwoWayFriction(),
    LawFrictionWave(),
    LawTightSpot(),
    LawTow(),
    LawFling(),
    LawSquareFling(),
    LawStir(),
    LawWhirl(),
    LawTie(),
    LawRhythm(),
    LawCreep(),
    LawThinning(),
    LawSoftMotor(),
    LawSlowMotor(),
    LawDamping(),
    LawDrag(),
    LawDryFriction(),
    LawInertia(),
    LawPush(),
    LawSpring(),
    LawWave(),
    LawFallingFriction(),
    LawLoadFriction(),
    LawWeakMotor(),
    LawMotorBrake(),
    LawClippedMotor(),
    LawDeafMotor(),
    LawWarmMotor(),
    LawLateCommand(),
    LawDriven(),
    LawBristles(),
    LawSag(),
    LawDrift(),
):
    register_effect(_law)


def law_terms() -> tuple[JointLaw, ...]:
    """The terms that a joint's unknown law may be put together of."""
    return tuple(e for e in every() if isinstance(e, JointLaw))
