"""Two Ray nodes on this machine, one of them killed in the middle: the tables are those of a serial run."""

import json
import os
import secrets
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from experiments.harness.rows import read_rows

pytestmark = pytest.mark.slow
OWN = ("--num-cpus=1", "--object-store-memory=100000000", "--block")
LOST_SOON = {"INITIAL_DELAY_MS": "1000", "PERIOD_MS": "500", "TIMEOUT_MS": "1000", "FAILURE_THRESHOLD": "4"}
EXPERIMENT = (sys.executable, "-m", "estexp_jax.cli.main", "experiment", "figure6", "--quick")


class Cluster:
    """Ray nodes, each a tree of processes of its own."""

    def __init__(self, folder: Path) -> None:
        self.nodes: list[subprocess.Popen[bytes]] = []
        self.folder = folder
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"127.0.0.1:{free.getsockname()[1]}"
        ours = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32), "RAY_USAGE_STATS_ENABLED": "0"}
        lost = {f"RAY_health_check_{name.lower()}": value for name, value in LOST_SOON.items()}
        self.environment = {**os.environ, **ours, **lost}

    def begin(self) -> None:
        port = self.address.rpartition(":")[2]
        self._start("--head", f"--port={port}", "--include-dashboard=false", f"--temp-dir={self.folder / 'r'}")
        self._until_printed(0, "Ray runtime started")
        self._start(f"--address={self.address}")
        self._until_printed(1, "Ray runtime started")

    def _start(self, *options: str) -> None:
        command = [str(Path(sys.executable).with_name("ray")), "start", *options, *OWN]
        with (self.folder / f"{len(self.nodes)}.log").open("wb") as log:
            self.nodes.append(subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, env=self.environment))

    def _until_printed(self, node: int, words: str) -> None:
        log, end = self.folder / f"{node}.log", time.monotonic() + 60
        while words not in log.read_text(errors="replace"):
            assert self.nodes[node].poll() is None and time.monotonic() < end, log.read_text(errors="replace")
            time.sleep(0.2)

    def kill(self, node: int) -> None:
        """SIGKILL for a node's raylet, its workers, and all else of it."""
        import psutil

        whole = psutil.Process(self.nodes[node].pid)
        for process in [*whole.children(recursive=True), whole]:
            try:
                process.send_signal(signal.SIGKILL)
            except psutil.NoSuchProcess:
                pass
        self.nodes[node].wait()


@pytest.fixture
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'estexp_jax[cluster]'")
    pytest.importorskip("psutil")
    import tempfile

    with tempfile.TemporaryDirectory(prefix="ray", ignore_cleanup_errors=True) as folder:  # sockets have short paths
        two = Cluster(Path(folder))
        try:
            two.begin()
            yield two
        finally:
            for node, process in enumerate(two.nodes):
                if process.poll() is None:
                    two.kill(node)


def _runs(out: Path) -> dict[str, dict]:
    """All that runs found, without what they cost."""
    found = {path.parent.name: json.loads(path.read_text()) for path in (out / "quick" / "runs").glob("s*/run.json")}
    return {n: {k: v for k, v in run.items() if k not in ("wall_s", "taken_up")} for n, run in found.items()}


def _table(out: Path) -> list[dict[str, Any]]:
    rows = read_rows(out / "quick" / "figure6" / "rows.parquet")
    return [{k: v for k, v in row.items() if k != "wall_s"} for row in rows]


def _on_node(under_way: Path, node: int, cluster: Cluster) -> bool:
    """Whether a run is under way in a worker of a node, and has a checkpoint."""
    import psutil

    workers = {child.pid for child in psutil.Process(cluster.nodes[node].pid).children(recursive=True)}
    for beat in under_way.glob("s*.json"):
        lock = under_way.parent / beat.stem / ".estexp-run.lock"
        holder = lock.read_text().split()[1] if lock.exists() else ""
        if holder.isdecimal() and int(holder) in workers and (lock.parent / "checkpoint.npz").exists():
            return True
    return False


def test_a_node_killed_in_the_middle_changes_nothing(cluster: Cluster, root: Path, tmp_path: Path) -> None:
    command = [*EXPERIMENT, "--ray", cluster.address, "--out", str(tmp_path / "ray")]
    environment = {**cluster.environment, "PYTHONPATH": str(root)}
    with subprocess.Popen(command, cwd=root, env=environment, stdout=subprocess.PIPE, text=True) as process:
        end = time.monotonic() + 300
        while not _on_node(tmp_path / "ray" / "quick" / "runs" / "under_way", 1, cluster):
            assert process.poll() is None and time.monotonic() < end, "no run came to the second node"
            time.sleep(0.1)
        cluster.kill(1)
        printed, _ = process.communicate(timeout=600)
    assert process.returncode == 0, printed
    assert "Ray on 2 machines" in printed
    serial = [*EXPERIMENT, "--out", str(tmp_path / "serial")]
    subprocess.run(serial, cwd=root, env={**os.environ, "PYTHONPATH": str(root)}, check=True, capture_output=True)
    assert len(_runs(tmp_path / "serial")) == 3
    assert _runs(tmp_path / "ray") == _runs(tmp_path / "serial")
    assert _table(tmp_path / "ray") == _table(tmp_path / "serial")
    taken_up = [
        json.loads(path.read_text())["taken_up"] for path in (tmp_path / "ray" / "quick" / "runs").glob("s*/run.json")
    ]
    assert sorted(map(len, taken_up)) == [0, 0, 1] and max(map(max, filter(None, taken_up))) > 0


def test_a_ray_of_its_own_gives_what_a_serial_run_gives(tmp_path: Path, root: Path) -> None:
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'estexp_jax[cluster]'")
    left = {name: value for name, value in os.environ.items() if not name.startswith("RAY_")}  # by Ray in this process
    own = {"PYTHONPATH": str(root), "HOME": str(tmp_path / "home")}
    for name, flags in (("ray", ["--ray", "--workers", "2"]), ("serial", [])):
        command = [*EXPERIMENT, *flags, "--out", str(tmp_path / name)]
        subprocess.run(command, cwd=root, env={**left, **own}, check=True, capture_output=True)
    assert _table(tmp_path / "ray") == _table(tmp_path / "serial")
    assert not (tmp_path / "home" / ".ray").exists()
