"""Effects that begin part-way through recordings: windows are cut there, and what is claimed acts only after it."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import replace
from functools import partial

from estexp_jax.discovery.diagnosis import Case, ExplainConfig
from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.force_residual import driven, force_residuals
from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.onset import helps_before, onsets
from estexp_jax.discovery.onset_by_values import parted
from estexp_jax.discovery.onset_date import Dates, dated, sharpened, short_windows
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import NOISE, Explanation, Selection
from estexp_jax.discovery.stepwise_search import select
from estexp_jax.estimation.windows import fitting_window, window_set_of
from estexp_jax.physics.effects.registry import effect

_MEMORY = "from the onset on"
_LIKELY = 5
"""So many of the best single claims may be the one that begins, where none was worth it from the start."""


def begun(
    case: Case, config: ExplainConfig, problem: Problem, selection: Selection
) -> Generator[Progress, None, Dates]:
    """When the mismatch begins in each training recording; empty: from the start, or nothing is wrong.

    Args:
        case: what is explained.
        config: how.
        problem: the comparison.
        selection: what was chosen as if everything acted from the start.

    Yields:
        Progress.
    """
    chosen = selection.chosen
    if chosen.error <= NOISE:
        return {}
    single = sorted((e for e in selection.tried if len(e.places) == 1), key=lambda e: e.error)
    steady = [e for e in single if not _grows(e)][:_LIKELY]
    likely = [chosen, *(steady if _grows(chosen) else [])] if chosen.places else single[:_LIKELY]
    found = dated(short_windows(case, problem), [e.fitted for e in likely])
    if found is not None:
        starting_at = partial(starting_late, case, config, problem)
        return (yield from sharpened(starting_at, found.began, found.fitted, "from when on"))
    found = yield from parted(case, problem, selection.parameters.fitted.hypothesis)
    if found:
        return found
    train = case.indices("train")
    # Parameters fitted to whole recordings would leave traces of the mismatch before it began: so the nominal robot.
    seen = force_residuals(problem, [robot.model for robot in case.robots], train)
    dofs = driven(case.robot.model, seen).tolist()
    found = onsets(dict(zip(train, seen, strict=True)), dofs, config.seed)
    return {} if found and helps_before(problem, found, chosen.fitted) else found


def _grows(e: Explanation) -> bool:
    """Whether it claims what comes on by itself: that makes up for an onset, and for a date that is a little off.

    Where such an effect is chosen, steady claims are dated, too; and after an onset none of them may be claimed.
    """
    return any(effect(name).grows_in_time for name, _ in e.places)


def starting_late(case: Case, config: ExplainConfig, problem: Problem, began: Mapping[int, float]) -> Problem:
    """The comparison with a window beginning where the mismatch does; claims act from there on, all of it at once.

    Args:
        case: what is explained.
        config: how.
        problem: the comparison as if everything acted from the start.
        began: the onset in each training recording, s.
    """
    window = fitting_window(case.robot, config.window)
    cut = window_set_of(case.robots, problem.recordings, window, began)
    memory = problem.memory.setdefault(_MEMORY, {})
    places = tuple(place for place in problem.places if not effect(place[0]).grows_in_time)
    return replace(problem.with_windows(cut, began), memory=memory, places=places)


def select_late(
    late: Problem, parameters: Hypothesis, whole: Selection, most: int
) -> Generator[Progress, None, tuple[Selection, Problem] | None]:
    """`select` among claims that act from the onset on; None where they predict held-out windows no better.

    Args:
        late: the comparison by `starting_late`.
        parameters: the hypothesis that only values of the model are off.
        whole: what was chosen as if everything acted from the start.
        most: largest number of effects.
    """
    found, about = yield from select(late, parameters, most)
    return (found, about) if found.chosen.places and found.chosen.error < whole.chosen.error else None
