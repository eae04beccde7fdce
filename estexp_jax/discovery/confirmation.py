"""What test recordings and clocks take back: a claim they do not bear out is told with even odds at most, and says so.

The test chooses nothing. It may only lower what is told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from estexp_jax.discovery.clock_doubt import MOST_PROBABLE, clocks_doubted
from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.physics.recording import Recording

_CRITERIA = SelectionCriteria()


def doubted(findings: Mapping[str, Any], recordings: Sequence[Recording]) -> dict[str, Any]:
    """Findings with the doubts that test recordings and clocks raise.

    Args:
        findings: with `side`, `what`, `alternatives`, `fit` and `advice`.
        recordings: those that were explained.
    """
    what = findings["what"]
    if findings["side"] != "numerics":
        what = confirmed(what, findings["fit"], findings["alternatives"])
    return clocks_doubted({**findings, "what": what}, recordings)


def confirmed(
    entries: Sequence[Mapping[str, Any]], fit: Mapping[str, Any], alternatives: Sequence[Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Entries of `what`, with the doubts that test recordings raise about each.

    Args:
        entries: of `what`.
        fit: the findings' errors, and the interval of the gain.
        alternatives: other explanations, with their errors on test recordings.
    """
    found = []
    for entry in entries:
        doubt = _doubt(entry, fit, alternatives)
        if doubt is None:
            found.append(dict(entry))
        else:
            sentence = f"{entry['sentence']}; but {doubt}"
            found.append({**entry, "probability": min(entry["probability"], MOST_PROBABLE), "sentence": sentence})
    return found


def _doubt(entry: Mapping[str, Any], fit: Mapping[str, Any], alternatives: Sequence[Mapping[str, Any]]) -> str | None:
    """Why test recordings do not bear an entry out; None where they do."""
    low = fit["gain"]["low"]
    if low is None or not low > 0.0:
        return "the test recordings may be predicted no better with it"
    error, lacked = fit["explained"].get("test"), fit["nominal"].get("train")
    if _as_good(lacked, error) and fit["gain"]["high"] < _CRITERIA.least_of_test:
        return "more is left on the test recordings than the training recordings lacked in all"
    if _as_good(fit["placebo"].get("test"), error):
        return "a wrong effect predicts the test recordings as well"
    own = f"{entry['effect']}@{entry['name'] or ''}"
    for other in alternatives:
        effects = [name if "@" in name else f"{name}@" for name in other["effects"]]
        if own not in effects and _as_good(other["test_error"], error):
            return f"{_listed(other['effects'])} predicts the test recordings as well"
    return None


def _as_good(other: float | None, error: float | None) -> bool:
    """Whether another error is no larger; what is not known is not."""
    return other is not None and error is not None and other <= error


def _listed(effects: Sequence[str]) -> str:
    return " with ".join(effects) if effects else "a refit of the model's own values"
