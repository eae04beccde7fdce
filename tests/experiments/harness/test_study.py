"""Every study has the same options, a folder of results, and is published beside its README."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from estexp_jax.errors import InputError
from experiments.harness.options import options_of, options_parser
from experiments.harness.study import Study, exit_code


@pytest.fixture
def study(tmp_path: Path) -> Study:
    (tmp_path / "knee").mkdir()
    return Study.of(str(tmp_path / "knee" / "run.py"), "About the knee.")


def test_the_options_of_the_command_reach_every_study(study: Study, tmp_path: Path) -> None:
    given = study.parser().parse_args(["--quick", "--resume", "--workers", "2", "--ray", "--out", str(tmp_path)])
    assert (given.quick, given.resume, given.workers, given.ray, given.publish) == (True, True, 2, "local", False)
    assert study.name == "knee"


def test_results_are_published_beside_the_readme_only_when_wanted(study: Study, tmp_path: Path) -> None:
    out = study.results(tmp_path / "out", "full")
    for name in ("rows.parquet", "figure.png", "traces.cache"):
        (out / name).touch()
    study.publish(out, wanted=False)
    assert not list(study.folder.iterdir())
    study.publish(out, wanted=True)
    assert sorted(p.name for p in study.folder.iterdir()) == ["figure.png", "rows.parquet"]


def test_quick_runs_are_never_published_and_seeds_may_be_given(study: Study, tmp_path: Path) -> None:
    words = ["--quick", "--publish", "--out", str(tmp_path)]
    options = options_of(study, words, seeds=10, quick_seeds=1)
    assert (options.size, options.n, options.publish) == ("quick", 1, False)
    assert options.out == tmp_path / "quick" / "knee" and options.store == tmp_path / "quick" / "runs"
    assert options_of(study, [*words, "--seeds", "3"], seeds=10, quick_seeds=1).n == 3
    parser = options_parser(study, seeds=10, sizes=False)
    with pytest.raises(SystemExit):
        options_of(study, ["--size", "small"], seeds=10, quick_seeds=1, parser=parser)


def _interrupted() -> int:
    raise KeyboardInterrupt


def _wrong() -> int:
    raise InputError("is wrong", right="another")


def test_a_study_ends_as_a_command_does(capsys: pytest.CaptureFixture[str]) -> None:
    assert [exit_code(main) for main in (lambda: 0, lambda: 1, _wrong, _interrupted)] == [0, 1, 2, 3]
    assert "is wrong" in capsys.readouterr().err


def test_a_script_keeps_xlas_log_off_the_terminal(root: Path) -> None:
    clean = {k: v for k, v in os.environ.items() if k != "TF_CPP_MIN_LOG_LEVEL"}
    code = "import os, experiments.harness.options; print(os.environ['TF_CPP_MIN_LOG_LEVEL'])"
    printed = subprocess.run(
        [sys.executable, "-c", code], cwd=root, env=clean, capture_output=True, text=True, check=True
    )
    assert printed.stdout == "3\n", "JAX, loaded first, would have set 1"
