"""Each recording beside what the nominal and the explained simulator say of it."""

from __future__ import annotations

import numpy as np

from estexp_jax.discovery.diagnosis import Case, Prediction
from estexp_jax.discovery.shown import Shown


def predictions_of(case: Case, shown: Shown) -> tuple[Prediction, ...]:
    """One prediction for each recording of a case."""
    problem, found = shown.problem, []
    for index, recording in enumerate(case.recordings):
        windows = problem.windows_of([index])
        rows = [problem.segments[w].rows for w in windows]
        logged = np.isin(problem.recordings[index].time, recording.time)
        number = np.repeat(np.arange(len(windows)), rows)[logged]
        recorded = problem.channels.recorded(recording)
        prediction = Prediction(
            recording.name,
            recording.role,
            recording.time,
            number,
            problem.channels.names,
            recorded,
            shown.joined("nominal", index)[logged],
            shown.joined("explained", index)[logged],
        )
        found.append(prediction)
    return tuple(found)
