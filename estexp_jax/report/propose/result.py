"""What `propose` found, for Python and Jupyter."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from estexp_jax.experiment_design.propose import ProposedExperiment
from estexp_jax.report.propose.files import write_proposal
from estexp_jax.report.propose.text import propose_rows, propose_summary, propose_table
from estexp_jax.report.tables import data_frame
from estexp_jax.runs import open_run


@final
@dataclass(frozen=True, eq=False)
class Proposal:
    """What `propose` found; prints itself as a table in a notebook.

    Attributes:
        proposed: everything, with its arrays.
    """

    proposed: ProposedExperiment

    @property
    def time(self) -> np.ndarray:
        """Of each row (rows,) of the commands, s."""
        return self.proposed.time

    @property
    def commands(self) -> np.ndarray:
        """What to record next: (rows, nu), in each actuator's control unit."""
        return self.proposed.commands

    def summary(self) -> str:
        """The competing explanations, and how far apart the proposed motion brings them."""
        return propose_summary(self.proposed)

    def table(self) -> Any:
        """The pairs of explanations, one a row: a DataFrame where pandas is present, else a list of dicts."""
        return data_frame(propose_rows(self.proposed))

    def write(self, out: str | Path, *, force: bool = False) -> Path:
        """Write commands, predictions, advice and report into a folder, as the command does; gives the report's path.

        Raises:
            InputError: the folder holds results and `force` is not set.
        """
        return write_proposal(open_run(out, force=force), self.proposed)

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return propose_table(self.proposed)
