"""Equal chunks of any batch."""

import threading
from typing import Any

import numpy as np
import pytest

from estexp_jax.physics.engines.batching import cores, in_chunks


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
