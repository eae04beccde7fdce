"""Match a group of elements with a log's columns: by the names that both bear, or by order."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import final

from estexp_jax.recordings.templates.names import NamedColumn, are_numbers, owner_of

BY_NAME, BY_END = "a guess, by its name", "a guess, by the end of its name: check this"
BY_ORDER, BY_NUMBER = "by its order: check this", "a guess, by its number: check this"


@final
@dataclass(frozen=True)
class Guess:
    """A column that may be one of ours.

    Attributes:
        column: in the log; None where several may be, or their order is in doubt.
        why: for the manifest: what the guess rests on, or why there is none.
        nanoseconds: the column beside it that has a time's nanoseconds.
    """

    column: NamedColumn | None
    why: str
    nanoseconds: str | None = None


@final
@dataclass(frozen=True)
class ColumnGroup:
    """Elements of one kind and the columns among which theirs are; joints by our column name."""

    joints: Mapping[str, str]
    columns: Sequence[NamedColumn]


def matched_by_name(group: ColumnGroup, known: Mapping[tuple[str, ...], str]) -> dict[str, Guess] | None:
    """The columns that bear a joint's name; where several bear it as well, none. None if no column bears any."""
    bearing, behind = _bearing(group, known)
    if not bearing:
        return None
    by_number = are_numbers([spelled for _, _, spelled in bearing])
    if by_number:
        # The first is 0 in one place and 1 in another: numbers are names only where they are the same ones.
        of_log = {c.owner[: len(c.owner) - behind][-1:] for c in group.columns if c.owner}
        if of_log != {spelled for joint in group.joints.values() for spelled in _number_words(joint, known)}:
            return None
    found: dict[str, Guess] = {}
    for ours, joint in group.joints.items():
        fitting = [(len(spelled), -len(c.words), spelled, c) for c, owner, spelled in bearing if owner == joint]
        if not fitting:
            continue
        best = max(entry[:2] for entry in fitting)
        columns = [entry[2:] for entry in fitting if entry[:2] == best]
        if len(columns) > 1:
            found[ours] = Guess(None, f"which of these? {', '.join(column.name for _, column in columns[:8])}")
            continue
        spelled, column = columns[0]
        rest = set(column.owner) - set(spelled) - _shared([column for column, _, _ in bearing])
        found[ours] = Guess(column, BY_NUMBER if by_number else BY_END if rest else BY_NAME)
        if column.label:
            found[ours] = Guess(column, f"a guess, by the list of names in {column.label_from}: check this")
    return found


def _bearing(
    group: ColumnGroup, known: Mapping[tuple[str, ...], str]
) -> tuple[list[tuple[NamedColumn, str, tuple[str, ...]]], int]:
    """The columns that bear an element's name, and how many words, the same for all columns, stand behind it.

    Words that all columns end with are left out where the names there are of one element at most.
    """
    endings = zip(*(reversed(column.owner) for column in group.columns), strict=False)
    behind = len([*takewhile(_are_one, endings)]) if len(group.columns) > 1 else 0
    whole, inner = (
        [(c, *owner) for c in group.columns if (owner := owner_of(c, known, left_out)) is not None]
        for left_out in (0, behind)
    )
    elements = [len({element for _, element, _ in found}) for found in (whole, inner)]
    return (inner, behind) if elements[1] > elements[0] else (whole, 0)


def _are_one(spelled: Sequence[str]) -> bool:
    return len(set(spelled)) == 1


def one_list(columns: Sequence[NamedColumn], count: int) -> Sequence[NamedColumn]:
    """The columns, or those of the only list among them that has this many values."""
    if len(columns) == count:
        return columns
    lists: dict[str, list[NamedColumn]] = {}
    for column in columns:
        name = column.name if column.index is not None else re.sub(r"\[\d+\](?=[^\[]*$)", "[]", column.name)
        lists.setdefault(name, []).append(column)
    fitting = [each for each in lists.values() if len(each) == count > 1]
    return fitting[0] if len(fitting) == 1 else columns


def _number_words(joint: str, known: Mapping[tuple[str, ...], str]) -> list[tuple[str, ...]]:
    """The number by which a joint is known, if it is."""
    return [spelled for spelled, owner in known.items() if owner == joint and are_numbers([spelled])][:1]


def in_order(group: ColumnGroup, known: Mapping[tuple[str, ...], str]) -> list[tuple[str, NamedColumn]]:
    """Our columns with the log's: numbered ones in the order of their numbers, others as they stand."""
    ours, columns = list(group.joints), list(group.columns)
    by_number = {name: number[0][0] for name, joint in group.joints.items() if (number := _number_words(joint, known))}
    if len(by_number) == len(ours) and are_numbers([column.owner[-1:] for column in columns]):
        ours.sort(key=lambda name: int(by_number[name]))
        columns.sort(key=lambda column: int(column.owner[-1]))
    return list(zip(ours, columns, strict=True))


def _shared(columns: Sequence[NamedColumn]) -> set[str]:
    """Words that all columns have, such as their topic."""
    return set.intersection(*(set(column.owner) for column in columns)) if len(columns) > 1 else set()
