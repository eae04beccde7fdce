"""Draws of bad input from one stream of chance: a seeded generator, hypothesis' or a fuzzer's bytes."""

from __future__ import annotations

import json
import random
from typing import Any

NUMBERS = (
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-1e308",
    "5e-324",
    "-1",
    "0",
    "1",
    "1e30",
    "9" * 400,
    "0x1",
    "1,5",
    "",
    "1e9",
)
"""What may stand where a number should."""
PATHS = (
    "../../../../../../etc/passwd", "/etc/passwd", "/dev/zero", "/dev/stdin", "/proc/self/environ", "..", ".", "~", "",
    "a\x00.csv", "n" * 5000, "log.csv/x", "C:\\x", "loop", "out", "link", "file:///etc/passwd", "http://127.0.0.1:9/x",
)  # fmt: skip
"""What may stand where a path should; `loop`, `out` and `link` are links that `trial.links` makes."""
TEXTS = ("<script>alert(1)</script>", "\x1b[2J", "$\\frac{", "%s{0}", "a" * 300, "\u202eabc", "名", "'\"`", "\n", "")
"""What may stand where a name should."""


class Bytes(random.Random):
    """Chance that a fuzzer's bytes decide; zeros where they end."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0
        super().__init__()

    def seed(self, *_: Any, **__: Any) -> None:
        """Bytes need no seed."""

    def random(self) -> float:
        return self.getrandbits(32) / 2.0**32

    def getrandbits(self, k: int, /) -> int:
        size = (k + 7) // 8
        taken = self._data[self._at : self._at + size]
        self._at += size
        return int.from_bytes(taken.ljust(size, b"\0"), "little") >> (8 * size - k)


def chance(source: random.Random, share: float) -> bool:
    """True in about so many cases."""
    return source.random() < share


def mutated(source: random.Random, content: bytes, most: int = 6) -> bytes:
    """Bytes with some overwritten, put in, cut out, cut off behind, or copied from elsewhere in them."""
    data = bytearray(content)
    for _ in range(source.randint(1, most)):
        at, new = source.randint(0, len(data)), source.randbytes(source.randint(1, 8))
        match source.randrange(5):
            case 0:
                data[at : at + len(new)] = new
            case 1:
                data[at:at] = new * 3
            case 2:
                del data[at : at + len(new) + 1]
            case 3:
                del data[at:]
            case _:
                other = source.randint(0, len(data))
                data[at:at] = data[other : other + 40]
    return bytes(data)


def replaced(source: random.Random, text: str, words: tuple[str, ...], most: int = 3) -> str:
    """A text with some of its words replaced by others, or by what nobody expects there."""
    for _ in range(source.randint(1, most)):
        there = [word for word in words if word in text]
        if not there:
            break
        new = source.choice((*words, *NUMBERS, *PATHS, *TEXTS))
        text = text.replace(source.choice(there), new, 1)
    return text


def number(source: random.Random) -> float:
    """A number, of any size and kind."""
    odd = (1e300, -1e300, 5e-324, float("nan"), float("inf"), -float("inf"), 1e30, 0.0, -0.0)
    return source.choice(odd) if chance(source, 0.4) else source.gauss(0.0, 1.0)


def value(source: random.Random, depth: int = 3) -> Any:
    """A JSON value."""
    simple = (None, True, False, -1, 0, 2**70, number(source), source.choice(TEXTS), source.choice(PATHS))
    if depth == 0 or chance(source, 0.6):
        return source.choice(simple)
    size = source.randint(0, 3)
    if chance(source, 0.5):
        return [value(source, depth - 1) for _ in range(size)]
    keys = ("position", "name", "header", "stamp", "sec", "effect", "parameters", "x")
    return {source.choice(keys): value(source, depth - 1) for _ in range(size)}


def changed(source: random.Random, document: Any, most: int = 3) -> Any:
    """A JSON document with some of its parts replaced, removed, doubled or wrapped."""
    document = json.loads(json.dumps(document))
    for _ in range(source.randint(1, most)):
        places = list(_places(document))
        if not places:
            return value(source)
        owner, key = source.choice(places)
        match source.randrange(5):
            case 0:
                del owner[key]
            case 1:
                owner[key] = [owner[key]]
            case 2 if isinstance(owner, list):
                owner.append(owner[key])
            case _:
                owner[key] = value(source)
    return document


def _places(document: Any) -> Any:
    """Every part of a document, as its owner and the key there."""
    items = list(document.items()) if isinstance(document, dict) else []
    items = list(enumerate(document)) if isinstance(document, list) else items
    for key, inner in items:
        yield document, key
        yield from _places(inner)
