"""Time stamps and durations as seconds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np


def is_stamp(values: np.ndarray) -> bool:
    """Whether an array holds time stamps or durations."""
    return values.dtype.kind in "mM"


def seconds(values: np.ndarray) -> np.ndarray:
    """Time stamps or durations (...) as float64 s; stamps from the first one on. NaN where there is none.

    Seconds since 1970 would leave digits for 0.2 us only.
    """
    absent = np.isnat(values)
    if values.dtype.kind == "M":
        present = values[~absent]
        values = values - (present.ravel()[0] if len(present) else values.dtype.type(0, "s"))
    unit, per = np.datetime_data(values.dtype)
    whole = values.astype(np.int64).astype(np.float64) * (per / _PER_S[unit] if unit in _PER_S else np.nan)
    return np.where(absent, np.nan, whole)


_PER_S = {"W": 1 / 604_800, "D": 1 / 86_400, "h": 1 / 3600, "m": 1 / 60, "s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_PER_S |= {"ps": 1e12, "fs": 1e15, "as": 1e18}
_LONG = {"sec": "s", "min": "m", "hr": "h"}
_DURATION = re.compile(
    r"(?:(\d{1,6}):)?(\d{1,2}):(\d{1,2}(?:\.\d{1,12})?)|(-?\d{1,12}(?:\.\d{1,15})?) ?(sec|min|hr|ms|us|ns|s)"
)


def parsed_stamps(texts: Sequence[str]) -> np.ndarray | None:
    """Texts as time stamps or durations in ns, empty ones as NaT; None if one is neither, or they are of both kinds.

    Time stamps are such as `2026-02-03T10:20:30.125+01:00`, durations `10:20:30.125` (also a time of the day) and
    `0.125 sec`, as MATLAB writes them.
    """
    first = next((text for text in texts if text), "")
    kind, parse = ("timedelta64[ns]", _duration) if _DURATION.fullmatch(first) else ("datetime64[ns]", _stamp)
    found = np.full(len(texts), "NaT", kind)
    for row, text in enumerate(texts):
        if not text:
            continue
        try:
            found[row] = parse(text)
        except (ValueError, OverflowError):
            return None
    return found


def _duration(text: str) -> np.timedelta64:
    match = _DURATION.fullmatch(text)
    if match is None:
        raise ValueError("no duration")
    hours, minutes, seconds, number, unit = match.groups()
    if number is not None:
        return np.timedelta64(round(float(number) * 1e9 / _PER_S[_LONG.get(unit, unit)]), "ns")
    return np.timedelta64((int(hours or 0) * 60 + int(minutes)) * 60_000_000_000 + round(float(seconds) * 1e9), "ns")


def _stamp(text: str) -> np.datetime64:
    if not (len(text) >= 16 and text[4] == text[7] == "-"):
        raise ValueError("no date with a time")
    whole, dot, rest = text.replace(",", ".").partition(".")
    digits = rest[: len(rest) - len(rest.lstrip("0123456789"))] if dot else ""
    instant = datetime.fromisoformat(whole + rest[len(digits) :])
    if instant.tzinfo is not None:
        instant = instant.astimezone(UTC).replace(tzinfo=None)
    return np.datetime64(instant, "ns") + np.timedelta64(int(digits[:9].ljust(9, "0") or 0), "ns")
