"""`python -m experiments.benchmark.generator OUT SEED N ROBOT...`: write a set, cases and answers apart."""

from __future__ import annotations

import json
import multiprocessing
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from pathlib import Path

from experiments.benchmark.generator.answers import answer
from experiments.benchmark.generator.case import Plan
from experiments.benchmark.generator.files import write_case
from experiments.benchmark.generator.plans import plans, realised


@contextmanager
def patient() -> Iterator[None]:
    """Let Ctrl-C wait until the end: within a step of scipy's compiled integrator it would end in a fatal error."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: asked.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if asked:
        raise KeyboardInterrupt


def write_set(out: Path, planned: Sequence[Plan], shorter: float = 1.0, workers: int = 1) -> dict[str, dict]:
    """Write `out/cases/<id>/` and give the answers; what `out/drawn/` has the answer of is not made again.

    Args:
        out: folder of the set.
        planned: its cases; they decide everything, how many processes there are decides nothing.
        shorter: share of the recordings' usual length.
        workers: processes that make cases.
    """
    todo = [(out, f"c{i:03d}", plan, shorter) for i, plan in enumerate(planned)]
    left = [t for t in todo if not _kept(out, t[1]).is_file()]
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) if workers > 1 else nullcontext() as pool:
        for i, name in enumerate(pool.map(_write, left) if pool else map(_write, left)):
            print(f"{name}: made {len(todo) - len(left) + i + 1} of {len(todo)}", flush=True)
    return {name: json.loads(_kept(out, name).read_text(encoding="utf-8")) for _, name, _, _ in todo}


def _kept(out: Path, name: str) -> Path:
    return out / "drawn" / f"{name}.json"


def write_one(out: Path, name: str, plan: Plan, shorter: float = 1.0) -> dict:
    """Write `out/cases/<name>/` and give the answer, which is written last; where either is gone, both are made."""
    kept = _kept(out, name)
    if not (kept.is_file() and (out / "cases" / name / "recordings.toml").is_file()):
        with patient():
            case = realised(plan, shorter)
        write_case(case, out / "cases" / name)
        kept.parent.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(".part")
        part.write_text(json.dumps(answer(case)), encoding="utf-8")
        part.replace(kept)
    return json.loads(kept.read_text(encoding="utf-8"))


def _write(asked: tuple[Path, str, Plan, float]) -> str:
    out, name, plan, shorter = asked
    write_one(out, name, plan, shorter)
    return name


if __name__ == "__main__":
    write_set(Path(sys.argv[1]), plans(int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:]))
