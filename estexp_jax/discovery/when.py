"""When the mismatch shows: in which regime of the guilty joint, and from which time on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.regime import THROUGHOUT, located_joint, regime


def when(
    case: Case,
    seen: Sequence[ForceResidual],
    where: Sequence[Mapping[str, Any]],
    began: Mapping[int, float],
    seed: int,
) -> dict[str, Any]:
    """`when` of findings in which something is wrong.

    Args:
        case: what was explained.
        seen: what the joints of the robot with refitted parameters lack, in each training recording.
        where: ranked places.
        began: index of a training recording to the time at which the mismatch begins in it, s.
        seed: of what is drawn.
    """
    joint = located_joint(case.robot, seen, where)
    told = THROUGHOUT if joint is None else regime(case.robot, seen, joint, seed)
    return {"regime": told, "onset_s": {case.recordings[i].name: began.get(i) for i in case.indices("train")}}


def never(case: Case) -> dict[str, Any]:
    """`when` of findings in which nothing is wrong, or only the time step."""
    return {"regime": None, "onset_s": {case.recordings[i].name: None for i in case.indices("train")}}
