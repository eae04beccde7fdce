"""A checkpoint gives back every bit, and survives what may happen to a run or a file."""

import math
import random
import signal
import subprocess
import sys
import time
from collections import namedtuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from estexp_jax.errors import InputError
from estexp_jax.runs import load_checkpoint, save_checkpoint
from estexp_jax.runs.checkpoint import previous_of

TREE = {
    "key": np.array([1, 2], np.uint32),
    "best": float("nan"),
    "worst": [math.inf, -math.inf, -0.0, 0.1, 5e-324],
    "pair": (1, (2.0, "three", None), [], (), {}),
    "generator": 2**127 + 1,
    (1, "a"): True,
    7: {"nested": [np.zeros((0, 3)), np.float32(0.1), np.int64(-1), np.bool_(True)]},
    "archive": np.asfortranarray(np.arange(6, dtype=">f4").reshape(2, 3)),
    "names": np.array(["a", "knee_f"]),
    "scalar": np.array(2.5),
    "list": ["dict", "array", 0],
}


def same(a, b):
    """Equal to the last bit and type."""
    assert type(a) is type(b)
    if isinstance(a, dict):
        assert list(a) == list(b)
        return all(same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, np.ndarray | np.generic):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, float):
        return a.hex() == b.hex()
    return a == b


leaves = st.none() | st.booleans() | st.integers() | st.floats() | st.text()
leaves |= hnp.arrays(hnp.scalar_dtypes(), hnp.array_shapes(min_dims=0, min_side=0, max_side=3))
keys = st.text() | st.integers() | st.tuples(st.integers(), st.text())
trees = st.recursive(
    leaves,
    lambda inner: st.lists(inner) | st.lists(inner).map(tuple) | st.dictionaries(keys, inner),
    max_leaves=8,
)


def test_round_trip(tmp_path):
    save_checkpoint(tmp_path / "c.npz", TREE)
    assert same(load_checkpoint(tmp_path / "c.npz"), TREE)
    assert [path.name for path in tmp_path.iterdir()] == ["c.npz"]


@given(tree=trees)
def test_round_trip_of_anything(tmp_path_factory, tree):
    path = tmp_path_factory.mktemp("any") / "c.npz"
    save_checkpoint(path, tree)
    assert same(load_checkpoint(path), tree)


def test_jax_arrays_come_back_as_numpy_arrays(tmp_path):
    jnp = pytest.importorskip("jax.numpy")
    save_checkpoint(tmp_path / "c", {"x": jnp.arange(3.0)})
    assert same(load_checkpoint(tmp_path / "c"), {"x": np.arange(3, dtype=np.float32)})


def test_what_would_not_come_back_is_refused(tmp_path):
    point = namedtuple("point", "x")(1)
    for tree in ({"a": [object()]}, {"a": [point]}, {"a": [{1}]}, {"a": [np.array([None])]}, {"a": [1j]}):
        with pytest.raises(TypeError, match=r"checkpoint\['a'\]\[0\] is a "):
            save_checkpoint(tmp_path / "c", tree)
    assert list(tmp_path.iterdir()) == []


def test_no_checkpoint_is_none(tmp_path):
    assert load_checkpoint(tmp_path / "c") is None


def test_the_one_before_is_kept(tmp_path):
    path = tmp_path / "c.npz"
    for number in range(3):
        save_checkpoint(path, number)
    assert (load_checkpoint(path), load_checkpoint(previous_of(path))) == (2, 1)
    path.unlink()
    assert load_checkpoint(path) == 1


def test_a_failed_save_changes_nothing(tmp_path, monkeypatch):
    path = tmp_path / "c"
    save_checkpoint(path, 1)
    save_checkpoint(path, 2)

    def full(stream, **arrays):
        stream.write(b"PK")
        raise OSError("no space left")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="no space"):
        save_checkpoint(path, 3)
    assert load_checkpoint(path) == 2 and load_checkpoint(previous_of(path)) == 1
    assert sorted(item.name for item in tmp_path.iterdir()) == ["c", "c.previous"]


def test_a_cut_file_falls_back_on_the_one_before(tmp_path):
    path = tmp_path / "c"
    save_checkpoint(path, "before")
    save_checkpoint(path, TREE)
    whole = path.read_bytes()
    for length in [0, 1, 21, *range(50, len(whole), 97), len(whole) - 1]:
        path.write_bytes(whole[:length])
        assert load_checkpoint(path) == "before"
    previous_of(path).write_bytes(b"")
    with pytest.raises(InputError, match="damaged.*--force"):
        load_checkpoint(path)


def test_a_flipped_bit_never_gives_other_values(tmp_path):
    path, tree, chance = tmp_path / "c", {"x": np.arange(20.0), "y": [1, 2.5, "z"]}, random.Random(0)
    save_checkpoint(path, "before")
    save_checkpoint(path, tree)
    whole, fallbacks = path.read_bytes(), 0
    for _ in range(300):
        damaged = bytearray(whole)
        damaged[chance.randrange(len(whole))] ^= 1 << chance.randrange(8)
        path.write_bytes(bytes(damaged))
        loaded = load_checkpoint(path)
        fallbacks += loaded == "before" if isinstance(loaded, str) else 0
        assert loaded == "before" if isinstance(loaded, str) else same(loaded, tree)
    assert fallbacks > 100


WRITER = """
import sys
import numpy as np
from estexp_jax.runs import save_checkpoint
for number in range(1, 1_000_000):
    save_checkpoint(sys.argv[1], {"number": number, "array": np.full(200_000, float(number))})
    print(number, flush=True)
"""


def test_a_kill_at_any_moment_leaves_a_checkpoint(tmp_path, root):
    path, chance, drafts = tmp_path / "c", random.Random(1), 0
    for _ in range(12):
        command = [sys.executable, "-c", WRITER, str(path)]
        with subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, text=True) as writer:
            assert writer.stdout is not None and writer.stdout.readline() == "1\n"
            time.sleep(chance.uniform(0.0, 0.05))
            writer.send_signal(signal.SIGKILL)
            saved = [1, *(int(line) for line in writer.stdout.read().split())][-1]
        drafts += len(list(tmp_path.glob(".*.part")))
        loaded = load_checkpoint(path)
        # The one that was told last, or the next, whose message the kill cut off; never one of an earlier writer.
        assert loaded["number"] - saved in (0, 1)
        assert (loaded["array"] == loaded["number"]).all() and len(loaded["array"]) == 200_000
    assert drafts > 0, "no kill came in the middle of a write: the test shows nothing"
