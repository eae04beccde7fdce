"""Equations of findings in LaTeX."""

from __future__ import annotations

import re
from itertools import groupby
from typing import NamedTuple

_TOKEN = re.compile(
    r"(?P<number>\d+\.?\d*(?:e[+-]?\d+)?)"
    r"|(?P<name>[A-Za-z]+\d*(?:_[A-Za-z0-9]+)*(?:'s|')?)"
    r"|\[(?P<joint>[^\]]*)\]"
    r"|\^(?P<power>[\d.]+|\w)"
    r"|`(?P<quoted>[^`]*)`"
    r"|(?P<sign><=|.)"
)
_SYMBOLS = {
    "tau": r"\tau", "sigma": r"\sigma", "mu": r"\mu", "pi": r"\pi", "phase": r"\varphi", "w": r"\omega",
    "sin": r"\sin", "cos": r"\cos", "exp": r"\exp", "tanh": r"\tanh", "min": r"\min", "max": r"\max",
    "sign": r"\operatorname{sign}", "clip": r"\operatorname{clip}", "sqrt": r"\sqrt",
}  # fmt: skip
_LETTERS = 2
"""Names longer than this without an index are words."""


class _Part(NamedTuple):
    is_word: bool
    text: str


def latex(equation: str) -> str:
    r"""An equation in LaTeX, without dollars: `tau = - 0.3 |w| w` becomes `\tau = - 0.3 |\omega| \omega`.

    Explanations in words remain text.
    """
    parts = [_part(match) for match in _TOKEN.finditer(_rooted(equation))]
    blank = [p.text == " " for p in parts]
    for i in range(1, len(parts) - 1):  # blanks beside words belong to the words
        if blank[i] and (parts[i - 1].is_word or parts[i + 1].is_word):
            parts[i] = _Part(is_word=True, text=" ")
    runs = ((word, "".join(p.text for p in run)) for word, run in groupby(parts, lambda p: p.is_word))
    return "".join(rf"\text{{{text}}}" if word else text for word, text in runs)


def _rooted(equation: str) -> str:
    """Replace brackets of roots by braces, and commas between equations by semicolons."""
    letters, depth = list(equation), list[str]()
    for i, letter in enumerate(equation):
        if letter == "(":
            depth.append("{}" if equation[:i].endswith("sqrt") else "()")
            letters[i] = depth[-1][0]
        elif letter == ")" and depth:
            letters[i] = depth.pop()[1]
        elif letter == "," and not depth:
            letters[i] = ";"
    return "".join(letters)


def _part(match: re.Match[str]) -> _Part:
    kind, text = match.lastgroup, match.group()
    if kind == "number" and "e" in text:
        digits, exponent = text.split("e")
        return _Part(is_word=False, text=rf"{digits} \times 10^{{{int(exponent)}}}")
    if kind == "name":
        return _name(text)
    if kind == "joint":
        return _Part(is_word=False, text=_index(match.group("joint")))
    if kind == "power":
        return _Part(is_word=False, text=f"^{{{match.group('power')}}}")
    if kind == "quoted":
        return _Part(is_word=True, text=_escaped(match.group("quoted")))
    return _Part(is_word=False, text={"<=": r"\leq", ";": r",\quad"}.get(text, text))


def _name(text: str) -> _Part:
    if text.endswith("'s"):
        return _Part(is_word=True, text=text)
    bare, prime = text.rstrip("'"), "'" * text.endswith("'")
    head = re.match(r"[A-Za-z]+", bare)
    letters = head.group() if head else bare
    index = bare[len(letters) :].lstrip("_")
    symbol = _SYMBOLS.get(letters, letters)
    if letters in _SYMBOLS or len(letters) == 1 or (index and len(letters) <= _LETTERS):
        return _Part(is_word=False, text=symbol + prime + (_index(index) if index else ""))
    if letters[0] == "d" and len(bare) == _LETTERS:  # of a derivative
        return _Part(is_word=False, text=rf"\mathrm{{d}}{_SYMBOLS.get(bare[1], bare[1])}")
    return _Part(is_word=True, text=_escaped(text))


def _index(text: str) -> str:
    return f"_{{{text}}}" if text.isdigit() else rf"_{{\mathrm{{{_escaped(text)}}}}}"


def _escaped(text: str) -> str:
    return re.sub(r"([_$%#&{}])", r"\\\1", text)
