"""Decode messages of robot logs and look up numbers by paths such as `/joint_states.position[2]`."""

from __future__ import annotations

import json
import re
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

Step = str | int | tuple[str]
"""One step of a path: a field's name, an index, or a joint's name in a tuple of one."""

MOST_VALUES = 64
"""Lists longer than this are images or point clouds, and are not listed as columns."""
_DEEPEST = 8

_JOINT_STATE = "sensor_msgs/msg/JointState"
# https://docs.ros2.org/latest/api/sensor_msgs/msg/JointState.html, for files that carry no definition of it.
_JOINT_STATE_TEXT = f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
"""


def decoder_of(encoding: str, schema: Any) -> Callable[[bytes], Any]:
    """The function that decodes the messages of a channel.

    Args:
        encoding: of the messages, as the channel states it: `json` or `cdr`.
        schema: the channel's schema, with `name`, `encoding` and `data`, or None.

    Raises:
        ValueError: the encoding is not supported.
    """
    if encoding == "json":
        return json.loads
    if encoding != "cdr" or schema is None:
        raise ValueError(f"messages in '{encoding}' are not read; JSON and ROS 2 (CDR) are")
    text = schema.data.decode("utf-8", "replace")
    if schema.name == _JOINT_STATE and (schema.encoding != "ros2msg" or not text.strip()):
        text = _JOINT_STATE_TEXT
    elif schema.encoding != "ros2msg":
        raise ValueError(f"their definition is in '{schema.encoding}'; ros2msg is read")
    if re.search(r"\[\s*0+\s*\]", text):
        # Such an array takes no bytes, so a message could claim any number of them.
        raise ValueError("their definition has an array of no length")
    from mcap_ros2._dynamic import generate_dynamic

    return generate_dynamic(schema.name, text)[schema.name]


def path_in(message: Any, rest: str) -> tuple[Step, ...] | None:
    """The steps that lead from a message to a value.

    Args:
        message: a decoded message in which the path is looked up, since field names may contain dots.
        rest: the path after the topic: `.position[2]`, or `.position[elbow]` for the joint of that name in `name`.

    Returns:
        The steps; None if this message has no such field.
    """
    steps: list[Step] = []
    value = message
    while rest:
        fields = _fields(value)
        if fields is not None and rest.startswith("."):
            fitting = [key for key in fields if rest[1:].startswith(key) and rest[1 + len(key) :][:1] in ("", ".", "[")]
            if not fitting:
                return None
            key = max(fitting, key=len)
            steps.append(key)
            value, rest = fields[key], rest[1 + len(key) :]
            continue
        match = re.match(r"\[([^\[\]]+)\]", rest)
        if not match or not _is_list(value):
            return None
        inner, rest = match[1], rest[match.end() :]
        steps.append(int(inner) if inner.isdecimal() and len(inner) < 10 else (inner,))
        value = follow(message, steps)
    return tuple(steps)


def follow(message: Any, steps: Sequence[Step]) -> Any:
    """The value at the end of a path; None if this message has none."""
    value = parent = message
    for step in steps:
        if isinstance(step, str):
            fields = _fields(value)
            if fields is None or step not in fields:
                return None
            parent, value = value, fields[step]
            continue
        index = step if isinstance(step, int) else _index_of(parent, step[0])
        if not _is_list(value) or index is None or index >= len(value):
            return None
        value = value[index]
    return value


def message_number(value: Any) -> float | None:
    """A number, or a stamp of seconds and nanoseconds in s, as a float; None for other values."""
    if isinstance(value, bool | int | float):
        try:
            return float(value)
        except OverflowError:
            return None
    time = nanoseconds(value)
    return None if time is None else 1e-9 * time


def nanoseconds(stamp: Any) -> int | None:
    """A stamp such as ROS's `{sec, nanosec}`, or a number of seconds, in ns; None for other values."""
    if isinstance(stamp, int | float) and not isinstance(stamp, bool):
        return round(1e9 * stamp) if abs(stamp) < 9e9 else None
    fields = _fields(stamp) or {}
    seconds = fields.get("sec", fields.get("secs"))
    rest = next((fields[key] for key in ("nanosec", "nsec", "nsecs") if key in fields), None)
    if not (isinstance(seconds, int) and isinstance(rest, int)) or abs(seconds) >= 9e9 or abs(rest) >= 1e10:
        return None
    return seconds * 1_000_000_000 + rest


def numbers_in(message: Any, depth: int = 0) -> Iterator[str]:
    """Paths, after the topic, to all numbers in a message."""
    fields = _fields(message)
    if depth > _DEEPEST:
        return
    if fields is not None:
        for key, value in fields.items():
            yield from (f".{key}{rest}" for rest in numbers_in(value, depth + 1))
    elif _is_list(message) and len(message) <= MOST_VALUES:
        for index, value in enumerate(message):
            yield from (f"[{index}]{rest}" for rest in numbers_in(value, depth + 1))
    elif isinstance(message, bool | int | float):
        yield ""


def _fields(value: Any) -> Mapping[str, Any] | None:
    if isinstance(value, dict):
        return value
    if isinstance(value, SimpleNamespace):  # a decoded ROS message
        slots = getattr(type(value), "__slots__", ())
        return {name: getattr(value, name) for name in slots if hasattr(value, name)}
    return None


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple | array | bytes)


def _index_of(message: Any, joint: str) -> int | None:
    """Index of a joint in a message's `name` list; ROS does not guarantee a constant order."""
    names = (_fields(message) or {}).get("name")
    return list(names).index(joint) if isinstance(names, list | tuple) and joint in names else None
