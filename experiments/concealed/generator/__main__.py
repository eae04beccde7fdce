"""`python -m experiments.concealed.generator OUT SEED N ROBOT...`: write a set, cases and answers apart."""

from __future__ import annotations

import json
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from experiments.concealed.generator.answers import answer
from experiments.concealed.generator.files import write_case
from experiments.concealed.generator.plans import plans, realised


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


def write_set(out: Path, seed: int, n: int, robots: Sequence[str], shorter: float = 1.0) -> dict[str, dict]:
    """Write `out/cases/<id>/` and give the answers; what `out/drawn/` has the answer of is not made again."""
    answers: dict[str, dict] = {}
    for i, plan in enumerate(plans(seed, n, robots)):
        name = f"c{i:03d}"
        kept = out / "drawn" / f"{name}.json"
        if not kept.is_file():
            with patient():
                case = realised(plan, shorter)
            write_case(case, out / "cases" / name)
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_text(json.dumps(answer(case)), encoding="utf-8")
            print(f"{name}: made {i + 1} of {n}", flush=True)
        answers[name] = json.loads(kept.read_text(encoding="utf-8"))
    return answers


if __name__ == "__main__":
    write_set(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:])
