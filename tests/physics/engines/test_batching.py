"""Equal chunks of any batch."""

import threading
from typing import Any

import numpy as np
import pytest

from estexp_jax.physics.engines.batching import cores, in_chunks
from estexp_jax.physics.engines.lanes import closed_loop as walk


@pytest.mark.parametrize("n", [1, 3, 4, 5, 8, 17])
def test_every_chunk_has_one_width_and_nothing_is_lost(n: int) -> None:
    widths, lock = [], threading.Lock()

    def double(part: dict[str, Any]) -> dict[str, Any]:
        with lock:
            widths.append(part["x"].shape[0])
        return {"y": 2 * part["x"], "z": part["k"][:, None] + part["x"]}

    batch = {"x": np.arange(3.0 * n).reshape(n, 3), "k": np.arange(n)}
    out = in_chunks(double, batch, 4)
    assert widths == [4] * -(-n // 4)
    np.testing.assert_array_equal(out["y"], 2 * batch["x"])
    np.testing.assert_array_equal(out["z"], batch["k"][:, None] + batch["x"])


def test_an_error_in_one_chunk_is_raised() -> None:
    def fail(part: np.ndarray) -> np.ndarray:
        if part[0] == 4:
            raise RuntimeError("chunk 1")
        return part

    with pytest.raises(RuntimeError, match="chunk 1"):
        in_chunks(fail, np.arange(8), 4)


def test_there_is_a_core() -> None:
    assert cores() >= 1


@pytest.mark.parametrize("n_cores", [1, 2, 16])
def test_chunks_of_lanes_keep_all_cores_busy_whatever_the_population(n_cores, monkeypatch) -> None:
    monkeypatch.setattr(walk, "cores", lambda: n_cores)
    for population in range(8 * n_cores, 6401):
        width = walk.lanes_width(2 * population)
        rounds = -(-population // (width * n_cores))
        assert width % 8 == 0 and width % 32 != 0 and width <= 104
        assert population >= 0.5 * rounds * n_cores * width
        if population >= 200 * n_cores:
            assert population >= 0.75 * rounds * n_cores * width
