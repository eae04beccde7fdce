"""What tests of several floors need."""

import gc
import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

from estexp_jax.runs.compilation_cache import compilation_cache_folder, quiet_xla
from tests.pendulum import EFFECT, PENDULUM, SMALL, run

if TYPE_CHECKING:
    from estexp_jax.discovery.diagnosis import Diagnosis

settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")  # how long an example takes depends on what else the machine does

quiet_xla()
with suppress(OSError, RuntimeError):
    # Tests, workers and commands share what one of them compiled. JAX reads this when imported, which is later.
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(compilation_cache_folder()))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.1")
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES", "-1")

ROOT = Path(__file__).resolve().parents[1]


def pytest_configure() -> None:
    """Hear Ctrl-C: background jobs ignore it, what they start does too, and tests of it would wait for ever."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish() -> None:
    """Spare the collector from looking again and again through what importing and tracing make: it stays."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder of published recordings of real hardware; the test is skipped where it is absent."""
    folder = Path(os.environ.get("ESTEXP_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no real recordings at {folder}; set ESTEXP_DATA to their folder")
    return folder


@pytest.fixture(scope="session")
def diagnosed() -> "Callable[[str], Diagnosis]":
    """Maps the name of one of `tests.discovery.planted.CASES` to its diagnosis, computed once a session."""
    from tests.discovery.planted import CASES, case_of, explained

    @cache
    def diagnose(name: str) -> "Diagnosis":
        robot, plant, seed = CASES[name]
        return explained(case_of(robot, plant, seed))

    return diagnose


@pytest.fixture(scope="session")
def root() -> Path:
    """The folder of the repository."""
    return ROOT


def _mount(*arguments: object) -> None:
    """Mount a file system, or skip the test where that is not permitted."""
    try:
        done = subprocess.run(["mount", *map(str, arguments)], capture_output=True, text=True, check=False)
    except FileNotFoundError:
        pytest.skip("there is no mount command here")
    if done.returncode:
        pytest.skip(f"mounting is not permitted here: {done.stderr.strip()}")


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 1 MB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    _mount("-t", "tmpfs", "-o", "size=1m", "tmpfs", folder)
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True)


@pytest.fixture
def remount() -> Callable[[Path, str], None]:
    """Make a mounted disk `ro` or `rw`."""
    return lambda folder, how: _mount("-o", f"remount,{how}", folder)


@pytest.fixture
def read_only(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A folder that may not be written; the superuser needs a whole disk for that."""
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        folder = request.getfixturevalue("small_disk")
        request.getfixturevalue("remount")(folder, "ro")
        return folder
    folder = tmp_path / "locked"
    folder.mkdir(mode=0o500)
    return folder


@pytest.fixture(scope="session")
def recorded(tmp_path_factory) -> Path:
    """Recordings of a pendulum that rubs, as `estexp record` writes them."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "pendulum.xml").write_text(PENDULUM)
    out = folder / "logs"
    sizes = ("--duration", "4", "--rate", "100", "--seed", "31")
    assert run("record", folder / "pendulum.xml", "--effect", EFFECT, "--out", out, *sizes) == 0
    return out


@pytest.fixture(scope="session")
def explained(recorded, tmp_path_factory) -> Path:
    """What `estexp explain` leaves of them."""
    out = tmp_path_factory.mktemp("explained") / "out"
    assert run("explain", recorded / "recordings.toml", "--out", out, *SMALL) == 0
    return out
