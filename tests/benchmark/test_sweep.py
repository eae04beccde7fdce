"""Speed over the population."""

from estexp_jax.benchmark.engines import runner
from estexp_jax.benchmark.sweep import sweep
from tests.benchmark.fake import Fake


def test_a_sweep_goes_through_the_populations(race, progress) -> None:
    made = lambda name, field: Fake(name) if name == "lanes" else runner(name, field)  # noqa: E731
    points = sweep(race, ("serial", "batch", "lanes"), progress, made, largest=8)
    assert [(p["engine"], p["robots"]) for p in points] == [
        *(("batch", n) for n in (1, 8)),
        *(("lanes", n) for n in (1, 2, 4, 8)),
    ]
    assert [p["share_of_neighbours"] is None for p in points] == [True, True, True, False, False, True]
