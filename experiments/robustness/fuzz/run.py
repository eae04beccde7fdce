"""`estexp experiment fuzz`: bad input of every kind, each to be refused with one message, soon and in little memory.

estexp experiment fuzz --quick
python experiments/robustness/fuzz/run.py --count 1000 --publish
"""

from __future__ import annotations

import json
import multiprocessing
import os
import random
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

_FORK = multiprocessing.get_context("fork")
MEMORY = 2 * 2**30
"""Address space, bytes, that an input may take beyond what the program has when it has just begun."""
_PATIENCE_S = 100.0
"""After which a process that says nothing is ended: what hangs in C does not hear the clock of `trial`."""
_ARM_S = 900.0
"""The same for its first word, since it imports and compiles first."""


@dataclass
class Tally:
    """What came of the inputs of one kind."""

    tried: set[str] = field(default_factory=set)
    refused: set[str] = field(default_factory=set)
    accepted: int = 0
    defects: list[dict[str, Any]] = field(default_factory=list)
    longest_s: float = 0.0
    peak_mb: float = 0.0
    start_mb: float = 0.0

    def row(self) -> dict[str, Any]:
        """As in `summary.json`."""
        return {
            "tried": len(self.tried),
            "refused": len(self.refused),
            "accepted": self.accepted,
            "crashes": len(self.defects),
            "longest_s": round(self.longest_s, 2),
            "memory_mb": round(max(self.peak_mb - self.start_mb, 0.0)),
            "defects": self.defects[:20],
        }


def main(arguments: Sequence[str] | None = None) -> int:
    """All kinds, one after another."""
    from experiments.harness.study import Study, words
    from experiments.robustness.fuzz.trial import KINDS

    study = Study.of(__file__, __doc__)
    parser = study.parser(quick="20 bad inputs a kind")
    parser.add_argument("--count", type=int, default=1000, help="distinct bad inputs a kind that have to be refused")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(words(arguments))
    out = study.results(given.out)
    summary = out / "summary.json"
    rows = json.loads(summary.read_text()) if summary.exists() else {}
    if "run_folder" in given.kinds:
        prepare = _FORK.Process(target=good_results, args=(out / "good",))  # JAX begins there, and not here
        prepare.start()
        prepare.join()
    import estexp_jax.cli.check  # noqa: F401
    import estexp_jax.recordings.inputs  # noqa: F401 (once for all processes)

    for kind in given.kinds:
        rows[kind] = campaign(kind, given.seed, 20 if given.quick else given.count, out).row()
        print(f"{kind}: " + ", ".join(f"{k} {v}" for k, v in rows[kind].items() if k != "defects"), flush=True)
        summary.write_text(json.dumps(rows, indent=1) + "\n")
    study.publish(out, given.publish)
    return int(any(row["crashes"] for row in rows.values()))


def campaign(kind: str, seed: int, count: int, out: Path) -> Tally:
    """Inputs of one kind, until so many distinct ones were refused."""
    tally, index = Tally(), 0
    while len(tally.refused) < count and index < 8 * count:
        for answer in _answers(kind, seed, index, out):
            if "start_mb" in answer:
                tally.start_mb = answer["start_mb"]
                continue
            _note(tally, answer)
            index = answer["index"] + 1
            if len(tally.refused) >= count or index >= 8 * count:
                break
    return tally


def _note(tally: Tally, answer: dict[str, Any]) -> None:
    tally.tried.add(answer["digest"])
    tally.longest_s = max(tally.longest_s, answer["seconds"])
    tally.peak_mb = max(tally.peak_mb, answer["peak_mb"])
    if answer["result"] == "refused":
        tally.refused.add(answer["digest"])
    elif answer["result"] == "accepted":
        tally.accepted += 1
    else:
        tally.defects.append({"index": answer["index"], "message": answer["message"]})
        print(f"  input {answer['index']}: {answer['message'][:400]}", flush=True)


def _answers(kind: str, seed: int, index: int, out: Path) -> Iterator[dict[str, Any]]:
    """What a process of its own says of the inputs from `index` on; of one that ends it, that it did."""
    ours, theirs = _FORK.Pipe(duplex=False)
    process = _FORK.Process(target=child, args=(theirs, kind, seed, index, out), daemon=True)
    process.start()
    theirs.close()
    wait = _ARM_S
    try:
        while True:
            answered = ours.poll(wait)
            try:
                answer = ours.recv() if answered else None
            except EOFError:
                answer = None
            if answer is None and wait == _ARM_S:
                raise RuntimeError("the process that tries inputs does not begin")
            if answer is None:
                process.join(1.0)
                ended = f"the process ended with {process.exitcode}" if answered else "it hangs in C"
                yield {"index": index, "digest": f"{kind}-{index}", "result": "defect", "message": ended} | _UNKNOWN
                return
            yield answer
            wait, index = _PATIENCE_S, answer.get("index", index - 1) + 1
    finally:
        process.kill()
        process.join()


_UNKNOWN = {"seconds": 0.0, "peak_mb": 0.0}


def child(pipe: Any, kind: str, seed: int, index: int, out: Path) -> None:
    """Try inputs from `index` on for ever, and tell of each through the pipe."""
    from experiments.robustness.fuzz.trial import attempt, bound_memory, makers, peak_mb, warm

    sys.stdin = open(os.devnull)
    os.dup2(sys.stdin.fileno(), 0)
    make = makers(out / "good")[kind]
    warm(make)
    bound_memory(MEMORY)
    pipe.send({"start_mb": peak_mb()})
    while True:
        begin = time.perf_counter()
        outcome = attempt(make, random.Random(f"{kind} {seed} {index}"))
        numbers = {"index": index, "seconds": time.perf_counter() - begin, "peak_mb": peak_mb()}
        pipe.send({**numbers, **outcome._asdict()})
        index += 1


def good_results(folder: Path) -> None:
    """What run folders are copied from: small results of `explain` and `recover`, made once."""
    from estexp_jax.cli.main import main as estexp
    from experiments.robustness.fuzz.pendulum import EFFECT, PENDULUM, SMALL, WALK

    recorded = folder / "recorded"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "pendulum.xml").write_text(PENDULUM)
    sizes = ("--duration", "4", "--rate", "100", "--seed", "31", "--force")
    commands = {
        "record": ["record", str(folder / "pendulum.xml"), "--effect", EFFECT, "--out", str(recorded), *sizes],
        "explain": ["explain", str(recorded / "recordings.toml"), *SMALL],
        "recover": ["recover", *WALK],
    }
    for name, argv in commands.items():
        if (folder / f"{name}.json").exists():
            continue
        more = [] if name == "record" else ["--out", str(folder / ("explained" if name == "explain" else "recovered"))]
        if estexp([*argv, *more, *([] if name == "record" else ["--force"])]) != 0:
            raise RuntimeError(f"{name} failed")
        (folder / f"{name}.json").write_text(json.dumps(argv))


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
