"""JAX functions over instances turned into NumPy: laws are written once, and cost nothing to compile here.

A function is traced once, for a length of the axis of instances that stands for any. Its operations become lines of
NumPy; equal ones are done once, and those that depend on constants alone are done before the first step. A function
with an operation that has no such line is compiled instead.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any, final

import jax
import numpy as np
from jax.extend.core import Literal

from estexp_jax.physics.engines.c.numpy_operations import (
    SHAPING,
    Operand,
    UnknownOperation,
    elementwise,
    shaping,
)

_NAMES = {name: getattr(np, name) for name in dir(np) if not name.startswith("_")}
_WORD = re.compile(r"\b[av]\d+\b")
NESTED = ("jit", "pjit", "closed_call", "core_call", "custom_jvp_call", "custom_vjp_call", "remat")
"""Operations that are functions of their own."""


@final
class NumpyProgram:
    """A function of constants, a pytree, and of further arrays, with any number of instances."""

    def __init__(self, function: Callable[..., Sequence[Any]], constants: Any, *inputs: Any) -> None:
        """Trace a function (constants, *inputs) -> arrays.

        Args:
            function: elementwise along the axis of instances.
            constants: a pytree of shapes, as `instances_shape` gives them for arrays with such an axis.
            *inputs: shapes.
        """
        self._compiled: Callable[..., Sequence[Any]] | None = None
        with jax.enable_x64(True):
            traced = jax.make_jaxpr(lambda c, *i: tuple(function(c, *i)))(constants, *inputs)
        try:
            self._prepare, self._run = _Lines(traced, len(jax.tree.leaves(constants))).functions()
        except UnknownOperation:
            self._compiled = jax.jit(lambda c, *i: tuple(function(c, *i)))

    def bound(self, constants: Any, n: int) -> Callable[..., Sequence[Any]]:
        """The function of its inputs alone, for `n` instances; it gives arrays or numbers that broadcast."""
        if (compiled := self._compiled) is not None:

            def run(*inputs: Any) -> list[Any]:
                with jax.enable_x64(True):
                    return [np.asarray(x) for x in compiled(constants, *inputs)]

            return run
        kept, program = self._prepare(n, *jax.tree.leaves(constants)), self._run
        return lambda *inputs: program(n, kept, *inputs)


def instances_shape(*shape: int, dtype: Any = float) -> Any:
    """The shape of an array of instances; `ANY_LENGTH` stands for their number."""
    return jax.ShapeDtypeStruct(shape, dtype)


class _Lines:
    """Lines of Python of a traced function: those of constants, and the others."""

    def __init__(self, traced: Any, n_constants: int) -> None:
        self._lines: tuple[list[str], list[str]] = ([], [])
        self._named: dict[str, str] = {}
        self._stage: dict[str, int] = {}
        self._values: dict[str, Any] = {}
        self._inputs: list[str] = []
        values: dict[Any, Operand] = {}
        for i, var in enumerate(traced.jaxpr.invars):
            name = f"a{i}"
            self._inputs.append(name)
            self._stage[name] = int(i >= n_constants)
            values[var] = Operand(name, var.aval.shape, broadcasts=False)
        self._n_constants = n_constants
        self._outputs = self._read(traced.jaxpr, traced.consts, values)

    def functions(self) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """(n, *constants) -> what is kept of them; (n, kept, *inputs) -> outputs."""
        used = set(_WORD.findall("\n".join([*self._lines[1], *self._outputs])))
        early = [name for name, stage in self._stage.items() if stage == 0 and name in used - set(self._values)]
        kept, arguments = "".join(f"{name}, " for name in early), self._inputs
        prepare = [
            f"def prepare(n, {', '.join(arguments[: self._n_constants])}):",
            *self._lines[0],
            f" return ({kept})",
        ]
        run = [f"def run(n, kept, {', '.join(arguments[self._n_constants :])}):"]
        run += [f" {kept} = kept"] if early else []
        run += [*self._lines[1], f" return ({''.join(f'{name}, ' for name in self._outputs)})"]
        space = {**_NAMES, **self._values}
        exec(compile("\n".join([*prepare, *run]), "<law>", "exec"), space)  # noqa: S102 (text made here alone)
        return space["prepare"], space["run"]

    def _read(self, jaxpr: Any, consts: Sequence[Any], values: dict[Any, Operand]) -> list[str]:
        """Take the lines of a function in; the names of its outputs."""
        for var, value in zip(jaxpr.constvars, consts, strict=True):
            values[var] = self._value(np.asarray(value))
        for equation in jaxpr.eqns:
            self._take(equation, values)
        return [self._operand(var, values).name for var in jaxpr.outvars]

    def _take(self, equation: Any, values: dict[Any, Operand]) -> None:
        name, operands = equation.primitive.name, [self._operand(var, values) for var in equation.invars]
        if name in NESTED:
            self._call(equation, operands, values)
            return
        if name == "split":
            self._split(equation, operands[0], values)
            return
        if name == "unstack":
            self._unstack(equation, operands[0], values)
            return
        if len(equation.outvars) != 1:
            raise UnknownOperation(name)
        [result] = equation.outvars
        shape = result.aval.shape
        if name in SHAPING:
            text, broadcasts = shaping(name, equation.params, operands)
        else:
            text = elementwise(name, equation.params, operands, result.aval.dtype.kind)
            broadcasts = bool(shape) and all(x.broadcasts or x.shape != shape for x in operands)
        values[result] = Operand(self._line(text, operands), shape, broadcasts)

    def _call(self, equation: Any, operands: Sequence[Operand], values: dict[Any, Operand]) -> None:
        inner = next((equation.params[k] for k in ("jaxpr", "call_jaxpr", "fun_jaxpr") if k in equation.params), None)
        if inner is None or not hasattr(inner, "jaxpr"):
            raise UnknownOperation(equation.primitive.name)
        own = dict(zip(inner.jaxpr.invars, operands, strict=True))
        self._read(inner.jaxpr, inner.consts, own)
        for outer, var in zip(equation.outvars, inner.jaxpr.outvars, strict=True):
            values[outer] = self._operand(var, own)

    def _split(self, equation: Any, x: Operand, values: dict[Any, Operand]) -> None:
        axis, start = equation.params["axis"], 0
        for result, size in zip(equation.outvars, equation.params["sizes"], strict=True):
            index = ", ".join([":"] * axis + [f"{start}:{start + size}"])
            values[result] = Operand(self._line(f"({x.whole})[{index}]", [x]), result.aval.shape, broadcasts=False)
            start += size

    def _unstack(self, equation: Any, x: Operand, values: dict[Any, Operand]) -> None:
        """An operation of JAX 0.11 and newer."""
        for k, result in enumerate(equation.outvars):
            index = ", ".join([":"] * equation.params["axis"] + [str(k)])
            values[result] = Operand(self._line(f"({x.whole})[{index}]", [x]), result.aval.shape, broadcasts=False)

    def _operand(self, var: Any, values: dict[Any, Operand]) -> Operand:
        return self._value(np.asarray(var.val)) if isinstance(var, Literal) else values[var]

    def _value(self, value: np.ndarray) -> Operand:
        """A constant of the function itself."""
        if not value.shape:
            number = value.item()
            text = f"float('{number}')" if isinstance(number, float) and not np.isfinite(number) else repr(number)
            return Operand(f"({text})", (), broadcasts=False)
        name = f"c{len(self._values)}"
        self._values[name], self._stage[name] = value, 0
        return Operand(name, value.shape, broadcasts=False)

    def _line(self, text: str, operands: Sequence[Operand]) -> str:
        """The name of an expression; equal ones have one line."""
        if text not in self._named:
            stage = max((self._stage.get(x.name, 0) for x in operands), default=0)
            name = self._named[text] = f"v{len(self._named)}"
            self._stage[name] = stage
            self._lines[stage].append(f" {name} = {text}")
        return self._named[text]
