"""JAX's elementwise operations and those on shapes, as NumPy expressions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

ANY_LENGTH = 977
"""Length of traced arrays' axis of instances, that stands for any: a prime that no other axis has."""


class UnknownOperation(Exception):
    """An operation has no expression here."""


class Operand(NamedTuple):
    """A value: its name, its traced shape, and whether the name's own shape only broadcasts to that."""

    name: str
    shape: tuple[int, ...]
    broadcasts: bool

    @property
    def whole(self) -> str:
        """An expression of its whole shape."""
        return f"broadcast_to({self.name}, {shape_text(self.shape)})" if self.broadcasts else self.name


ELEMENTWISE: Mapping[str, str] = {
    "add": "{0} + {1}",
    "add_any": "{0} + {1}",
    "sub": "{0} - {1}",
    "mul": "{0} * {1}",
    "neg": "-{0}",
    "max": "maximum({0}, {1})",
    "min": "minimum({0}, {1})",
    "clamp": "minimum(maximum({1}, {0}), {2})",
    "abs": "abs({0})",
    "square": "{0} * {0}",
    "rsqrt": "1.0 / sqrt({0})",
    "pow": "power({0}, {1})",
    "atan2": "arctan2({0}, {1})",
    "rem": "fmod({0}, {1})",
    "logistic": "1.0 / (1.0 + exp(-{0}))",
    "lt": "{0} < {1}",
    "le": "{0} <= {1}",
    "gt": "{0} > {1}",
    "ge": "{0} >= {1}",
    "eq": "{0} == {1}",
    "ne": "{0} != {1}",
    "and": "{0} & {1}",
    "or": "{0} | {1}",
    "xor": "{0} ^ {1}",
    "not": "logical_not({0})",
    "is_finite": "isfinite({0})",
    "copy": "{0}",
    "copy_p": "{0}",
    "stop_gradient": "{0}",
    "select_n": "where({0}, {2}, {1})",
    **{name: f"{name}({{0}})" for name in ("exp", "expm1", "log", "log1p", "sqrt", "sin", "cos", "tan", "sign")},
    **{name: f"{name}({{0}})" for name in ("sinh", "cosh", "tanh", "floor", "ceil", "cbrt", "exp2")},
    **{name: f"arc{name[1:]}({{0}})" for name in ("asin", "acos", "atan", "asinh", "acosh", "atanh")},
}
"""Expression of each elementwise operation in its operands."""


def shape_text(shape: Sequence[int]) -> str:
    """A shape as text, with `n` for any length."""
    return "(" + "".join("n, " if x == ANY_LENGTH else f"{x}, " for x in shape) + ")"


def elementwise(name: str, params: Mapping[str, Any], operands: Sequence[Operand], kind: str) -> str:
    """The expression of an elementwise operation whose result is of a NumPy kind.

    Raises:
        UnknownOperation: there is none.
    """
    names = [x.name for x in operands]
    if name == "integer_pow":
        power = int(params["y"])
        return " * ".join([names[0]] * power) if 0 < power < 4 else f"power({names[0]}, {float(power)})"
    if name == "convert_element_type":
        return f"asarray({names[0]}, '{np.dtype(params['new_dtype'])}')"
    if name == "div":
        if kind != "f":
            raise UnknownOperation(name)
        return f"{names[0]} / {names[1]}"
    if name == "round":
        return f"rint({names[0]})"
    if name not in ELEMENTWISE or (name == "select_n" and len(names) != 3):
        raise UnknownOperation(name)
    return ELEMENTWISE[name].format(*names)


def _broadcast(params: Mapping[str, Any], x: Operand) -> tuple[str, bool]:
    shape, kept = params["shape"], params["broadcast_dimensions"]
    if not x.shape:
        return x.name, bool(shape)
    index = ", ".join(":" if axis in kept else "None" for axis in range(len(shape)))
    smaller = tuple(x.shape[kept.index(axis)] if axis in kept else 1 for axis in range(len(shape)))
    plain = len(kept) == len(shape)
    return (x.whole if plain else f"({x.whole})[{index}]"), smaller != tuple(shape)


def _squeeze(params: Mapping[str, Any], x: Operand) -> str:
    axes = [axis % len(x.shape) for axis in params["dimensions"]]
    return f"({x.whole})[{', '.join('0' if axis in axes else ':' for axis in range(len(x.shape)))}]"


def _slice(params: Mapping[str, Any], x: Operand) -> str:
    strides = params["strides"] or (1,) * len(x.shape)
    parts = []
    for start, stop, step, size in zip(params["start_indices"], params["limit_indices"], strides, x.shape, strict=True):
        whole = (start, stop, step) == (0, size, 1)
        if size == ANY_LENGTH and not whole:
            raise UnknownOperation("slice")
        parts.append(":" if whole else f"{start}:{stop}:{step}")
    return f"({x.whole})[{', '.join(parts)}]"


def _reshape(params: Mapping[str, Any], x: Operand) -> str:
    sizes = params["new_sizes"]
    if (ANY_LENGTH in sizes) != (ANY_LENGTH in x.shape):
        raise UnknownOperation("reshape")
    return f"({x.whole}).reshape({shape_text(sizes)})"


def _reduced(function: str) -> Callable[[Mapping[str, Any], Operand], str]:
    def reduced(params: Mapping[str, Any], x: Operand) -> str:
        axes = tuple(params["axes"])
        if any(x.shape[axis] == ANY_LENGTH for axis in axes):
            raise UnknownOperation(function)  # laws do not sum over instances
        return f"{function}({x.whole}, axis={axes})"

    return reduced


ONE_OPERAND: Mapping[str, Callable[[Mapping[str, Any], Operand], str]] = {
    "squeeze": _squeeze,
    "slice": _slice,
    "reshape": _reshape,
    "transpose": lambda params, x: f"({x.whole}).transpose({tuple(params['permutation'])})",
    "reduce_sum": _reduced("add.reduce"),
    "reduce_max": _reduced("maximum.reduce"),
    "reduce_min": _reduced("minimum.reduce"),
    "reduce_or": _reduced("logical_or.reduce"),
    "reduce_and": _reduced("logical_and.reduce"),
}


def shaping(name: str, params: Mapping[str, Any], operands: Sequence[Operand]) -> tuple[str, bool]:
    """The expression of an operation on shapes, and whether its value only broadcasts to its shape.

    Raises:
        UnknownOperation: there is none.
    """
    if name == "broadcast_in_dim":
        return _broadcast(params, operands[0])
    if name in ONE_OPERAND:
        return ONE_OPERAND[name](params, operands[0]), False
    if name == "concatenate":
        return f"concatenate(({', '.join(x.whole for x in operands)}, ), axis={params['dimension']})", False
    if name == "stack":  # since JAX 0.11
        return f"stack(({', '.join(x.whole for x in operands)}, ), axis={params['axis']})", False
    if name == "dot_general" and tuple(map(tuple, params["dimension_numbers"][0])) == ((1,), (0,)):
        if not any(params["dimension_numbers"][1]):
            return f"dot({operands[0].whole}, {operands[1].whole})", False
    raise UnknownOperation(name)


SHAPING = frozenset((*ONE_OPERAND, "broadcast_in_dim", "concatenate", "stack", "dot_general"))
