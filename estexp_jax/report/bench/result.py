"""What `bench` measured, for people."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, final

from estexp_jax.report.bench.text import BENCH_LEGEND, bench_sentences, bench_tables, explaining_table
from estexp_jax.report.tables import TextTable


@final
@dataclass(frozen=True)
class BenchResult:
    """What was measured.

    Attributes:
        measured: the contents of `bench.json`.
    """

    measured: Mapping[str, Any]

    def tables(self) -> Iterator[tuple[TextTable, list[str]]]:
        """A table for each number of physics steps, with a sentence on each engine that was not timed; explaining."""
        yield from bench_tables(self.measured)
        explaining = explaining_table(self.measured)
        if explaining is not None:
            yield explaining, []

    def sentences(self) -> list[str]:
        """What the columns mean, and what the tables do not show."""
        return [BENCH_LEGEND, *bench_sentences(self.measured)]
