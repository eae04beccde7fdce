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
    r"(?:(?P<days>-?\d{1,6}) days?,? \+?)?"
    r"(?:(?P<hours>\d{1,6}):)?(?P<minutes>\d{1,2}):(?P<seconds>\d{1,2}(?:\.\d{1,12})?)"
    r"|(?P<number>-?\d{1,12}(?:\.\d{1,15})?) ?(?P<unit>sec|min|hr|ms|us|ns|s)"
    r"|P(?:(?P<d>\d{1,6})D)?T(?=\d)(?:(?P<h>\d{1,6})H)?(?:(?P<m>\d{1,6})M)?(?:(?P<s>\d{1,12}(?:\.\d{1,12})?)S)?"
)


def parsed_stamps(texts: Sequence[str]) -> np.ndarray | None:
    """Texts as time stamps or durations in ns, empty ones as NaT; None if one is neither, or they are of both kinds.

    Time stamps are such as `2026-02-03T10:20:30.125+01:00`, durations `10:20:30.125` (also a time of the day),
    `0 days 10:20:30.125` of pandas, `0.125 sec` of MATLAB and `PT0.125S` of ISO 8601.
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
    part = match.groupdict(default="0")
    if match["number"] is not None:
        unit = part["unit"]
        return np.timedelta64(round(float(part["number"]) * 1e9 / _PER_S[_LONG.get(unit, unit)]), "ns")
    names = ("days", "hours", "minutes", "seconds") if match["minutes"] is not None else ("d", "h", "m", "s")
    days, hours, minutes = (int(part[name]) for name in names[:3])
    whole = ((days * 24 + hours) * 60 + minutes) * 60_000_000_000
    return np.timedelta64(whole + round(float(part[names[3]]) * 1e9), "ns")


def _stamp(text: str) -> np.datetime64:
    if not (len(text) >= 16 and text[4] == text[7] == "-"):
        raise ValueError("no date with a time")
    whole, dot, rest = text.replace(",", ".").partition(".")
    digits = rest[: len(rest) - len(rest.lstrip("0123456789"))] if dot else ""
    instant = datetime.fromisoformat(whole + rest[len(digits) :])
    if instant.tzinfo is not None:
        instant = instant.astimezone(UTC).replace(tzinfo=None)
    return np.datetime64(instant, "ns") + np.timedelta64(int(digits[:9].ljust(9, "0") or 0), "ns")
