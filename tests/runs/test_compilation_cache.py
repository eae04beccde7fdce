"""Compiled programs are kept, counted, and nobody's own settings are touched."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import pytest

from estexp_jax.runs import compilation_cache, forget_programs

COMPILE = """
import json
from estexp_jax.runs import quiet_xla
quiet_xla()
import jax
from estexp_jax.runs import count_compilations, enable_compilation_cache
before = jax.config.jax_compilation_cache_dir
assert before is None or not {fresh}, "importing configures nothing"
folder = enable_compilation_cache()
minimum = jax.config.jax_persistent_cache_min_compile_time_secs
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
with count_compilations() as seen:
    jax.jit(lambda x: x * 2 + 1)(jax.numpy.float32(3.0)).block_until_ready()
once = seen.count
jax.jit(lambda x: x * 3 + 1)(jax.numpy.float32(3.0)).block_until_ready()
print(json.dumps([str(folder), minimum, once, seen.cached, seen.seconds > 0, seen.count == once]))
"""


@pytest.fixture
def compiled(root):
    """Compile a program in a fresh process; what it printed, and its standard error."""

    def run(**environment):
        # JAX sets TF_CPP_MIN_LOG_LEVEL when imported, as it is here once another test has run: a shell has none.
        own = ("JAX_COMPILATION_CACHE_DIR", "XDG_CACHE_HOME", "TF_CPP_MIN_LOG_LEVEL")
        clean = {k: v for k, v in os.environ.items() if k not in own}
        code = COMPILE.replace("{fresh}", str("JAX_COMPILATION_CACHE_DIR" not in environment))
        command, environment = [sys.executable, "-c", code], clean | {"JAX_PLATFORMS": "cpu"} | environment
        done = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout), done.stderr

    return run


def test_a_second_process_loads_what_the_first_compiled(tmp_path, compiled):
    (place, minimum, count, cached, timed, ended), _ = compiled(XDG_CACHE_HOME=str(tmp_path))
    assert Path(place).parent == tmp_path / "estexp_jax" / "xla" and list(Path(place).iterdir())
    assert (minimum, cached, timed, ended) == (0.5, 0, True, True) and count >= 1
    (_, _, again, cached, _, _), stderr = compiled(XDG_CACHE_HOME=str(tmp_path))
    assert again == cached == count
    assert stderr == ""


def test_a_cache_that_is_configured_stays(tmp_path, compiled):
    own = str(tmp_path / "own")
    (place, minimum, *_), _ = compiled(XDG_CACHE_HOME=str(tmp_path / "home"), JAX_COMPILATION_CACHE_DIR=own)
    assert place == own and minimum != 0.5
    assert not (tmp_path / "home").exists()


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path, compiled):
    (tmp_path / "file").write_text("")
    (place, *_), stderr = compiled(XDG_CACHE_HOME=str(tmp_path / "file"))
    assert place == "None"
    assert stderr.count("\n") == 1 and stderr.startswith("estexp: warning: compiled programs are not kept")


def test_programs_are_forgotten_before_a_process_has_too_many_memory_maps(monkeypatch):
    program: Any = jax.jit(lambda x: 2.0 * x)
    program(1.0)
    monkeypatch.setattr(compilation_cache, "_memory_maps", lambda: (32000, 65530))
    assert not forget_programs() and program._cache_size() == 1
    monkeypatch.setattr(compilation_cache, "_memory_maps", lambda: None)
    assert not forget_programs() and program._cache_size() == 1, "a system that does not tell"
    monkeypatch.setattr(compilation_cache, "_memory_maps", lambda: (33000, 65530))
    assert forget_programs() and program._cache_size() == 0
    assert float(program(1.0)) == 2.0


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs /proc")
def test_memory_maps_are_counted():
    count, limit = compilation_cache._memory_maps() or (0, 0)
    assert 10 < count < limit
