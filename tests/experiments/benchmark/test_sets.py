"""Sets are committed to, tampering shows, and runs go on after a kill."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from experiments.benchmark import run as front
from experiments.benchmark import sets
from experiments.benchmark.generator.__main__ import patient, write_one
from experiments.benchmark.generator.plans import plans
from experiments.harness.explain_runner import Runner, ending_of

EXPLAIN = """
import json, pathlib, sys
out = pathlib.Path(sys.argv[sys.argv.index("--out") + 1])
out.mkdir(parents=True, exist_ok=True)
(out / "seen.json").write_text(json.dumps(sys.argv))
{end}
(out / "findings.json").write_text("{{}}")
"""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A set of two short cases."""
    out = tmp_path_factory.mktemp("set") / "dev"
    sets.draw(out, 5, 2, ["planar"], shorter=0.14)
    return out


@pytest.fixture
def copy(drawn, tmp_path):
    """One that may be spoilt."""
    return shutil.copytree(drawn, tmp_path / "dev")


@pytest.mark.slow
def test_how_many_processes_draw_decides_nothing(drawn, tmp_path):
    sets.draw(tmp_path / "two", 5, 2, ["planar"], shorter=0.14, workers=2)
    assert sets.recordings_hash(tmp_path / "two" / "cases") == sets.recordings_hash(drawn / "cases")
    assert sets.open_answers(tmp_path / "two") == sets.open_answers(drawn)


def test_answers_stand_in_a_file_of_their_own_and_open_when_nothing_was_touched(drawn):
    assert sorted(p.name for p in drawn.iterdir()) == ["answers.json", "cases", "commitment.json"]
    assert not list((drawn / "cases").rglob("*.json"))
    assert sorted(sets.open_answers(drawn)) == ["c000", "c001"]


def test_another_answer_is_noticed(copy):
    kept = json.loads((copy / "answers.json").read_text())
    kept["answers"]["c000"]["visibility"]["shown"] += 0.1
    (copy / "answers.json").write_text(json.dumps(kept))
    with pytest.raises(sets.Tampered, match="answers"):
        sets.open_answers(copy)


@pytest.mark.parametrize("spoil", ["edit", "remove", "rename"])
def test_another_recording_is_noticed(copy, spoil):
    path = copy / "cases" / "c001" / "train_0.csv"
    if spoil == "edit":
        path.write_text(path.read_text().replace("1", "2", 1))
    elif spoil == "remove":
        path.unlink()
    else:
        path.rename(path.with_name("train_9.csv"))
    with pytest.raises(sets.Tampered, match="recordings"):
        sets.open_answers(copy)


def test_a_drawn_set_is_not_drawn_again(copy):
    before = (copy / "answers.json").read_bytes()
    sets.draw(copy, 6, 2, ["planar"])
    assert (copy / "answers.json").read_bytes() == before


def test_a_case_whose_recordings_are_gone_is_drawn_again(copy):
    plan, written = plans(5, 2, ["planar"])[0], sets.recordings_hash(copy / "cases")
    answer = write_one(copy, "c000", plan, shorter=0.14)
    shutil.rmtree(copy / "cases" / "c000")
    assert write_one(copy, "c000", plan, shorter=0.14) == answer
    assert sets.recordings_hash(copy / "cases") == written


def test_ctrl_c_waits_for_the_end_of_a_case():
    done = False
    with pytest.raises(KeyboardInterrupt), patient():
        os.kill(os.getpid(), signal.SIGINT)
        done = True
    assert done


def test_the_seed_of_a_sealed_set_comes_from_a_clean_commit(tmp_path):
    assert sets.seed_of("abc") == sets.seed_of("abc") != sets.seed_of("abd")
    git = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b"]
    subprocess.run([*git[:3], "init", "-q"], check=True)
    (tmp_path / "x").write_text("1")
    with pytest.raises(RuntimeError, match="commit everything"):
        sets.frozen_commit(tmp_path)
    subprocess.run([*git, "add", "x"], check=True)
    subprocess.run([*git, "commit", "-qm", "x"], check=True)
    assert len(sets.frozen_commit(tmp_path)) == 40


def test_cases_are_explained_once_and_what_failed_is_reported(copy):
    assert _runner(copy, "sys.exit(0 if 'c001' not in str(out) else 1)").run() == 0
    assert [ending_of(copy, f"c00{i}")["code"] for i in range(2)] == [0, 1]  # pyright: ignore[reportOptionalSubscript]
    seen = json.loads((copy / "explained" / "c000" / "seen.json").read_text())
    assert seen[1].endswith("cases/c000/recordings.toml") and "--resume" not in seen
    assert _runner(copy, "raise SystemExit(9)").run() == 0, "nothing is left to do"
    assert ending_of(copy, "c000")["code"] == 0  # pyright: ignore[reportOptionalSubscript]


def test_only_named_cases_are_explained(copy):
    command = (sys.executable, "-c", EXPLAIN.format(end=""))
    assert Runner(copy, 2, 30.0, command, only=["c001"]).run() == 0
    assert [ending_of(copy, f"c00{i}") is None for i in range(2)] == [True, False]


def test_a_case_under_way_at_a_kill_is_resumed(copy):
    (copy / "explained" / "c001").mkdir(parents=True)
    assert _runner(copy, "").run() == 0
    assert "--resume" in json.loads((copy / "explained" / "c001" / "seen.json").read_text())


def test_a_case_that_someone_terminated_stays_open(copy):
    end = "import os, signal; os.kill(os.getpid(), signal.SIGTERM if 'c001' in str(out) else signal.SIGKILL)"
    assert _runner(copy, end).run() == 1
    assert ending_of(copy, "c001") is None
    assert ending_of(copy, "c000")["code"] == -signal.SIGKILL  # pyright: ignore[reportOptionalSubscript]


def test_what_takes_too_long_counts_as_failed(copy):
    assert _runner(copy, "import time; time.sleep(60)", timeout=0.5).run() == 0
    assert ending_of(copy, "c000")["code"] is None  # pyright: ignore[reportOptionalSubscript]


def test_a_case_dies_with_its_worker_on_a_cluster(copy, root):
    # What is left of a case would keep the next worker out of its folder.
    if sys.platform != "linux":
        pytest.skip("only Linux ends a process with its parent")
    worker = (
        "import sys; from pathlib import Path; from experiments.harness.explain_runner import explain_case as e; e({})"
    )
    case = f"import os; open({str(copy / 'pid')!r}, 'w').write(str(os.getpid())); import time; time.sleep(60)"
    call = f"Path({str(copy)!r}), 'c000', 60.0, (sys.executable, '-c', {case!r})"
    with subprocess.Popen([sys.executable, "-c", worker.format(call)], cwd=root) as process:
        while not (copy / "pid").exists() or not (copy / "pid").read_text():
            assert process.poll() is None
            time.sleep(0.02)
        process.kill()
    pid, end = int((copy / "pid").read_text()), time.monotonic() + 10
    while _lives(pid) and time.monotonic() < end:
        time.sleep(0.02)
    assert not _lives(pid) and ending_of(copy, "c000") is None


def _lives(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.slow
def test_a_cluster_explains_the_same_cases(copy):
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'estexp_jax[cluster]'")
    command = (sys.executable, "-c", EXPLAIN.format(end="sys.exit(0 if 'c001' not in str(out) else 1)"))
    assert Runner(copy, 1, 30.0, command, ray="local").run() == 0
    assert [ending_of(copy, f"c00{i}")["code"] for i in range(2)] == [0, 1]  # pyright: ignore[reportOptionalSubscript]


def _runner(out, end, timeout=30.0):
    return Runner(out, 2, timeout, (sys.executable, "-c", EXPLAIN.format(end=end)))


def test_results_are_not_overwritten_and_the_sealed_robot_is_not_for_development(tmp_path, capsys):
    (tmp_path / "x").mkdir()
    assert front.main(["--quick", "--out", str(tmp_path / "x")]) == 2
    assert "--resume" in capsys.readouterr().err
    assert front.main(["draw", "--robots", "scara", "--out", str(tmp_path / "y")]) == 2
    assert "no development on scara" in capsys.readouterr().err
