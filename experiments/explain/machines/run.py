"""`estexp experiment machines`: explain published recordings of real robots, and logs with something known withheld.

estexp experiment machines --quick                    pieces of the recordings, one split a device
estexp experiment machines                            everything; long
python experiments/explain/machines/run.py --only xl330-kp800 xl330-late-command
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))

_DONE, _WRONG, _INTERRUPTED = 0, 2, 3


def data_folder() -> Path | None:
    """Where the recordings are: `ESTEXP_DATA`, else `../shared/data`; None where they are not."""
    folder = Path(os.environ.get("ESTEXP_DATA", ROOT.parent / "shared" / "data"))
    return folder if folder.is_dir() else None


def main(arguments: list[str] | None = None) -> int:
    """Write the cases, explain them, write the page; gives the exit code."""
    from experiments.explain.machines import cases
    from experiments.explain.machines.page import write_page
    from experiments.harness.explain_runner import Runner

    options = _parsed(sys.argv[1:] if arguments is None else arguments)
    data = data_folder()
    if data is None:
        print(_ABSENT, file=sys.stderr)
        return _WRONG
    out = options.out or ROOT / "out" / "machines" / ("quick" if options.quick else "full")
    if (out / "cases").is_dir() and not options.resume:
        print(f"real: {out} holds results; --resume goes on with them, --out puts others elsewhere", file=sys.stderr)
        return _WRONG
    plans = cases.plans(data, options.quick)
    chosen = [p for p in plans if not options.only or p.name in options.only]
    for plan in chosen:
        if not (out / "cases" / plan.name / "recordings.toml").is_file():
            cases.write(plan, data, out / "cases" / plan.name, options.quick)
    if options.write:
        return _DONE
    names = [p.name for p in chosen]
    left = Runner(out, options.workers, options.timeout, ray=options.ray, only=names).run()
    print(f"results: {write_page(out, plans)}")
    return _INTERRUPTED if left else _DONE


def _parsed(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="machines", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="pieces of the recordings")
    parser.add_argument("--resume", action="store_true", help="go on with what an earlier run left")
    parser.add_argument("--workers", type=int, default=None, help="cases at a time; default 1")
    parser.add_argument(
        "--ray", nargs="?", const="local", default=None, metavar="ADDRESS", help="explain on a Ray cluster"
    )
    parser.add_argument("--out", type=Path, default=None)
    parser.add_argument("--only", nargs="+", default=[], help="names of cases")
    parser.add_argument("--write", action="store_true", help="write the cases and stop")
    parser.add_argument("--timeout", type=float, default=7200.0, help="most seconds a case")
    return parser.parse_args(arguments)


_ABSENT = """real: there are no real recordings here.
Set ESTEXP_DATA to a folder that holds them, or put them at ../shared/data beside this repository:
  xl330/            github.com/Rhoban/bam
  double_pendulum/  github.com/dfki-ric-underactuated-lab/double_pendulum
  so101/            github.com/isaac-sim2real/sage
each with its CSV files and a nominal.xml."""


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
