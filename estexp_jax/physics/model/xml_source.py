"""The XML of a model as its author wrote it, to be changed in single places while all else stays letter by letter.

Included files are read where they are included, and changed each in its own text.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import final
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

_HIDDEN = re.compile(rb"<!--.*?-->|<!DOCTYPE[^<>\[\]]*>", re.DOTALL)
_TAG = re.compile(rb"""<[^<>"']*(?:"[^"]*"[^<>"']*|'[^']*'[^<>"']*)*>""")


class NotEditable(Exception):
    """A text cannot be changed in single places."""


@final
class SourceText:
    """One file, and the changes to it that are waiting.

    Args:
        name: as it is included; empty for the model itself.
        data: UTF-8.
    """

    def __init__(self, name: str, data: bytes) -> None:
        self.name, self.data = name, data
        self._changes: list[tuple[int, int, bytes]] = []
        self.tags: dict[int, SourceElement] = {}

    def replace(self, start: int, end: int, text: str) -> None:
        """Put a text in place of what stands between two offsets, once all changes are known."""
        self._changes.append((start, end, text.encode()))

    def changed(self) -> str:
        """The text with all changes, those of start tags included."""
        changes = [*self._changes, *(c for tag in self.tags.values() if (c := tag.change()) is not None)]
        found = self.data
        for start, end, text in sorted(changes, key=lambda c: (c[0], c[1]), reverse=True):
            found = found[:start] + text + found[end:]
        return found.decode()


@final
class SourceElement:
    """An element as it stands in a file.

    Attributes:
        tag: its name.
        attrib: its attributes, of which changes are written back.
        children: in it, with those of included files in their places.
    """

    def __init__(self, text: SourceText, start: int, tag: str, attributes: Mapping[str, str]) -> None:
        found = _TAG.match(text.data, start)
        if found is None:
            raise NotEditable(f"<{tag}> is not closed")
        self.tag, self.attrib, self.children = tag, dict(attributes), list[SourceElement]()
        self._text, self._start, self._end = text, start, found.end()
        self._before, self._old_tag = dict(attributes), tag
        self.is_closed = found.group().endswith(b"/>")
        self.close = self.finish = self._end  #: where its end tag begins, and ends
        text.tags[start] = self

    def __iter__(self) -> Iterator[SourceElement]:
        return iter(self.children)

    def ended(self, at: int) -> None:
        """Its end tag begins at an offset."""
        if not self.is_closed:
            self.close = at
            found = _TAG.match(self._text.data, at)
            self.finish = found.end() if found else at

    def change(self) -> tuple[int, int, bytes] | None:
        """What changes in its start tag: single attributes, or a new name."""
        if self.attrib == self._before and self.tag == self._old_tag:
            return None
        raw = self._text.data[self._start : self._end].decode()
        if self.tag != self._old_tag:
            raw = f"<{self.tag}" + raw[1 + len(self._old_tag) :]
        for name in {**self._before, **self.attrib}:
            if self.attrib.get(name) != self._before.get(name):
                raw = _with_attribute(raw, name, self.attrib.get(name))
        return self._start, self._end, raw.encode()

    def delete(self) -> None:
        """Take it out, with what stands in it and the line that it leaves empty."""
        for at in [k for k in self._text.tags if self._start <= k < self.finish]:
            del self._text.tags[at]
        data = self._text.data
        begin = len(data[: self._start].rstrip(b" \t"))
        alone = data[begin - 1 : begin] == b"\n" and data[self.finish : self.finish + 1] == b"\n"
        self._text.replace(begin if alone else self._start, self.finish + int(alone), "")

    def insert_first(self, texts: list[str]) -> None:
        """Put elements right behind its start tag."""
        self._opened()
        indent = self._indent() + "  "
        self._text.replace(self._end, self._end, "".join(f"\n{indent}{text}" for text in texts))

    def insert_last(self, texts: list[str]) -> None:
        """Put elements right before its end tag."""
        self._opened()
        begin = len(self._text.data[: self.close].rstrip())
        indent = self._indent() + "  "
        self._text.replace(begin, begin, "".join(f"\n{indent}{text}" for text in texts))

    def insert_behind(self, texts: list[str]) -> None:
        """Put elements behind its end tag."""
        indent = self._indent()
        self._text.replace(self.finish, self.finish, "".join(f"\n{indent}{text}" for text in texts))

    def replace_by(self, text: str) -> None:
        """Put an element in its place."""
        del self._text.tags[self._start]
        self._text.replace(self._start, self.finish, text)

    def _opened(self) -> None:
        if self.is_closed:
            raise NotEditable(f"<{self.tag}/> has no room")

    def _indent(self) -> str:
        line = self._text.data[: self._start].rpartition(b"\n")[2]
        return line.decode() if not line.strip() else ""


def _with_attribute(tag: str, name: str, value: str | None) -> str:
    """A start tag with another value of one attribute; None: without it."""
    there = re.compile(rf"""(\s+){re.escape(name)}\s*=\s*(?:"[^"]*"|'[^']*')""")
    new = "" if value is None else f"{name}={quoteattr(value)}"
    if there.search(tag):
        return there.sub(lambda found: found[1] + new if new else "", tag, count=1)
    end = re.search(r"\s*/?>$", tag)
    assert end is not None
    return f"{tag[: end.start()]} {new}{end.group()}"


def read_source(
    data: bytes, included: Callable[[str, str], tuple[str, bytes]], name: str = ""
) -> tuple[SourceElement, list[SourceText]]:
    """The root of a model's XML, and its files, the model's first.

    Args:
        data: of the model.
        included: gives name and content of a file that is included, from how it is written and the includer's name.
        name: of the file.

    Raises:
        NotEditable: it is not well-formed, or no UTF-8.
    """
    texts, opened, roots = [SourceText(name, data)], list[SourceElement](), list[SourceElement]()
    parser = expat.ParserCreate()

    def begin(tag: str, attributes: dict[str, str]) -> None:
        element = SourceElement(texts[0], parser.CurrentByteIndex, tag, attributes)
        if tag == "include":
            inner_name, inner = included(attributes.get("file", ""), name)
            root, more = read_source(inner, included, inner_name)
            texts.extend(more)
            opened[-1].children += root.children
        else:
            (opened[-1].children if opened else roots).append(element)
        opened.append(element)

    def end(_: str) -> None:
        opened.pop().ended(parser.CurrentByteIndex)

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    try:
        data.decode()
        parser.Parse(_HIDDEN.sub(lambda found: b" " * len(found.group()), data), True)
    except (expat.ExpatError, UnicodeDecodeError) as error:
        raise NotEditable(str(error)) from None
    return roots[0], texts
