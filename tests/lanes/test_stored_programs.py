"""Executables kept on disk beside JAX's own cache."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.lanes.compilation import compile_lowered, lower
from estexp_jax.lanes.stored_programs import stored

_X = np.linspace(0.0, 1.0, 24, dtype=np.float32)
_RUN = """
import sys
import numpy as np
import jax
from estexp_jax.lanes.stored_programs import stored
jax.config.update("jax_compilation_cache_dir", sys.argv[1])
def compile_it(label):
    raise SystemExit("compiled again")
x = np.linspace(0.0, 1.0, 24, dtype=np.float32)
print(np.asarray(stored([b"waves"], (x,), compile_it)(x)).tobytes().hex())
"""


@pytest.fixture
def kept(tmp_path: Path) -> Iterator[Path]:
    before = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue] (made at run time)
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield tmp_path / "steps"
    jax.config.update("jax_compilation_cache_dir", before)


def _waves(x: jax.Array) -> jax.Array:
    return jnp.cumsum(jnp.sin(7.0 * x) * x)


class _Compiler:
    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, label: str) -> object:
        self.calls += 1
        return compile_lowered(lower(_waves, _X, label=label), 1)[0]


def test_another_process_runs_the_same_executable(kept: Path) -> None:
    compiler = _Compiler()
    here = np.asarray(stored([b"waves"], (_X,), compiler)(_X))  # type: ignore[operator]
    run = [sys.executable, "-c", _RUN, str(kept.parent)]
    there = subprocess.run(run, capture_output=True, text=True, check=True).stdout
    assert there.strip() == here.tobytes().hex()
    assert compiler.calls == 1


def test_what_a_program_is_made_from_and_its_arguments_shapes_tell_programs_apart(kept: Path) -> None:
    compiler = _Compiler()
    for identity, given in (([b"a"], _X), ([b"b"], _X), ([b"a", b"b"], _X), ([b"a"], _X[:12]), ([b"a"], _X)):
        stored(identity, (given,), compiler)
    assert compiler.calls == 4
    assert len(list(kept.glob("*.program"))) == 4


def test_a_damaged_file_only_costs_time(kept: Path) -> None:
    compiler = _Compiler()
    stored([b"waves"], (_X,), compiler)
    (file,) = kept.glob("*.program")
    file.write_bytes(file.read_bytes()[:100])
    again = stored([b"waves"], (_X,), compiler)
    np.testing.assert_allclose(np.asarray(again(_X)), np.asarray(_waves(jnp.asarray(_X))), rtol=1e-5)
    assert compiler.calls == 2


def test_what_calls_lapack_is_not_kept(kept: Path) -> None:
    matrix = np.eye(3, dtype=np.float32)
    stored([b"svd"], (matrix,), lambda label: lower(jnp.linalg.svd, matrix, label=label).compile())
    assert not list(kept.glob("*.program"))


def test_nothing_is_kept_where_jax_keeps_nothing(tmp_path: Path, kept: Path) -> None:
    jax.config.update("jax_compilation_cache_dir", None)
    compiler = _Compiler()
    for _ in range(2):
        stored([b"waves"], (_X,), compiler)
    assert compiler.calls == 2
    assert not list(tmp_path.iterdir())
