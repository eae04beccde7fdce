"""The XML of a model, looked over before MuJoCo sees it: whether it is well-formed, and whether it claims too much.

MuJoCo's own reader is lenient, opens files while it reads, and builds whatever number of things it is told to.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple, final
from xml.parsers import expat

from estexp_jax.errors import InputError, abbreviated

MOST_ELEMENTS = 20_000
"""Elements of a model, replicated ones counted each: from there on MuJoCo takes many seconds to compile it."""
MOST_NUMBERS = 1_000_000
"""Of one element's own data."""
_MOST_CELLS, _MOST_SIZE = 2**26, 10_000
_MOST_ROOM = {"nstack": 2**26, "njmax": 100_000, "nconmax": 100_000}
"""Of memory that older models ask for: eight bytes each of `nstack`, constraints and contacts at once."""
_CELLS = {"hfield": ("nrow", "ncol"), "texture": ("width", "height")}
_COUNTED = ("replicate", "composite", "flexcomp")
# Comments may hold `--` in MuJoCo and not in XML, so they are cut out first. What is left of a document type would be
# entities, which no model has.
_TOKENS = re.compile(
    r"""(<!--.*?-->|<!DOCTYPE[^<>\[\]]*>)|<!\[CDATA\[.*?\]\]>|<\?.*?\?>|<(?![!?])[^<>"']*(?:"[^"]*"[^<>"']*|'[^']*'[^<>"']*)*>|[^<]+""",
    re.DOTALL,
)


class Element(NamedTuple):
    """One element of a model's XML."""

    tag: str
    attributes: Mapping[str, str]


def xml_elements(text: str, where: str) -> list[Element]:
    """All elements of a model's XML, in its order, the root first.

    Args:
        text: MJCF or URDF.
        where: the file, for messages.

    Raises:
        InputError: it is not well-formed, declares entities, or holds or claims more than any robot has.
    """
    reader = _Reader(where)
    try:
        reader.parser.Parse(_without_comments(text, where), True)
    except expat.ExpatError as error:
        said = f"is not well-formed XML: {expat.ErrorString(error.code)}, column {error.offset + 1}"
        raise InputError(said, where=f"{where}, line {error.lineno}") from None
    return reader.found


def _without_comments(text: str, where: str) -> str:
    """The text with line breaks alone where comments were."""
    pieces, end = [], 0
    while end < len(text):
        token = _TOKENS.match(text, end)
        if token is None:
            line = text.count("\n", 0, end) + 1
            raise InputError("is not well-formed XML", where=f"{where}, line {line}", right="close every < with a >")
        pieces.append("\n" * token[1].count("\n") if token[1] else token[0])
        end = token.end()
    return "".join(pieces)


@final
class _Reader:
    """Collects elements, and adds up what they will become.

    Args:
        where: the file, for messages.
    """

    def __init__(self, where: str) -> None:
        self.found: list[Element] = []
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler, self.parser.EndElementHandler = self._start, self._end
        self._where, self._claimed, self._times = where, 0, [1]

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        place = f"{self._where}, line {self.parser.CurrentLineNumber}, <{tag}>"
        times = _product(attributes, ("count",)) if tag in _COUNTED else 1
        self._times.append(self._times[-1] * times)
        self._claimed += self._times[-1]
        if self._claimed > MOST_ELEMENTS:
            what = f"the model has or claims more than {MOST_ELEMENTS:,} elements"
            raise InputError(what, where=place, right="a robot, without the crowd")
        if tag in _CELLS and _product(attributes, _CELLS[tag]) > _MOST_CELLS:
            raise InputError(f"claims more than {_MOST_CELLS:,} cells", where=place, right="fewer of them")
        if tag == "numeric" and _product(attributes, ("size",)) > MOST_NUMBERS:
            raise InputError(f"claims more than {MOST_NUMBERS:,} numbers", where=place, right="fewer of them")
        if tag == "size":
            for name, value in attributes.items():
                most = _MOST_ROOM.get(name, _MOST_SIZE)
                if name.startswith("n") and _product(attributes, (name,)) > most:
                    raise InputError(f"{name} is {abbreviated(value)}", where=place, right=f"at most {most:,}")
        self.found.append(Element(tag, attributes))

    def _end(self, _: str) -> None:
        self._times.pop()


def _product(attributes: Mapping[str, str], names: tuple[str, ...]) -> int:
    """All whole numbers in some attributes, multiplied; what is no number is MuJoCo's to tell."""
    product = 1
    for name in names:
        for digits in re.findall(r"\d+", attributes.get(name, "1")):
            product *= max(1, int(digits)) if len(digits) < 19 else 2**63
    return product
