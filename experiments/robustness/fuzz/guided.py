"""Bad input bred by coverage: atheris mutates the bytes that the draws of one kind come from.

python experiments/robustness/fuzz/guided.py mjcf -max_total_time=60 -rss_limit_mb=4096

Needs the extra `fuzz`. What follows the kind goes to libFuzzer. Ends with a traceback where an input is neither taken
nor refused with one message.
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))


def main() -> None:
    """Fuzz one kind until time is up or something breaks."""
    import atheris  # pyright: ignore[reportMissingModuleSource] (an extra for development)

    from experiments.robustness.fuzz.run import good_results

    kind, *options = sys.argv[1:]
    good = ROOT / "out" / "experiments" / "fuzz" / "good"
    if kind == "run_folder":
        good_results(good)
    with atheris.instrument_imports(  # pyright: ignore[reportAttributeAccessIssue] (not in its stub)
        include=["estexp_jax.recordings", "estexp_jax.api", "estexp_jax.physics.model.xml_text"]
    ):
        import estexp_jax.recordings  # noqa: F401
        import estexp_jax.recordings.inputs  # noqa: F401
    from experiments.robustness.fuzz.draw import Bytes
    from experiments.robustness.fuzz.trial import attempt, makers, warm

    make = makers(good)[kind]
    warm(make)
    tried: dict[str, set[str]] = {"refused": set(), "accepted": set()}

    def one(data: bytes) -> None:
        outcome = attempt(make, Bytes(data))
        if outcome.result == "defect":
            raise RuntimeError(outcome.message)
        tried[outcome.result].add(outcome.digest)
        if sum(map(len, tried.values())) % 500 == 0:
            print({name: len(some) for name, some in tried.items()}, file=sys.__stderr__, flush=True)

    atheris.Setup([sys.argv[0], *options], one)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
