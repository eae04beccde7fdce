"""When the mismatch shows: in which regime of the guilty joint, and from which time on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.fitting import Fit
from estexp_jax.discovery.force_residual import ForceResidual, driven, force_residuals
from estexp_jax.discovery.onset import helps_before, onsets
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.regime import THROUGHOUT, located_joint, regime


def when(
    case: Case,
    problem: Problem,
    seen: Sequence[ForceResidual],
    where: Sequence[Mapping[str, Any]],
    explained: Fit,
    seed: int,
) -> dict[str, Any]:
    """`when` of findings in which something is wrong.

    Args:
        case: what was explained.
        problem: the comparison.
        seen: what the joints of the robot with refitted parameters lack, in each training recording.
        where: ranked places.
        explained: the chosen explanation.
        seed: of what is drawn.
    """
    joint = located_joint(case.robot, seen, where)
    told = THROUGHOUT if joint is None else regime(case.robot, seen, joint, seed)
    train = case.indices("train")
    # Parameters fitted to whole recordings would leave traces of the mismatch before it began: so the nominal robot.
    nominal = force_residuals(problem, [robot.model for robot in case.robots], train)
    dofs = driven(case.robot.model, nominal).tolist()
    began = onsets(dict(zip(train, nominal, strict=True)), dofs, seed)
    if began and helps_before(problem, began, explained):
        began = {}
    return {"regime": told, "onset_s": {case.recordings[i].name: began.get(i) for i in train}}


def never(case: Case) -> dict[str, Any]:
    """`when` of findings in which nothing is wrong, or only the time step."""
    return {"regime": None, "onset_s": {case.recordings[i].name: None for i in case.indices("train")}}
