"""An engine in a process of its own."""

import pytest

from estexp_jax.benchmark.process import alone, peak_mb


def test_a_process_of_its_own_tells_time_and_memory(race) -> None:
    found = alone("serial", race)
    assert found["compile_s"] == 0.0 and found["first_result_s"] > 0.0
    assert 10.0 < found["peak_mb"] < 20_000.0 and 0.0 <= found["rise_mb"] <= found["peak_mb"]
    assert peak_mb() > 10.0


@pytest.mark.slow
def test_a_second_process_finds_the_programs_of_the_first(race) -> None:
    found = alone("lanes", race)
    assert 0.0 < found["first_result_s"] < found["compile_s"]
