"""Laws of effects as text of Python, for single numbers or arrays alike, for NumPy and JAX.

A law is traced with one number for each input. Its operations become expressions; what is used once stands in the
expression that uses it.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Callable, Sequence
from typing import Any, final

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import ShapedArray
from jax.extend.core import Literal, Primitive

from estexp_jax.physics.effects.base import BodyForce, CommandLaw, JointState, Term
from estexp_jax.physics.engines.c.law_inputs import MOUNT_ROWS, mount_of_rows
from estexp_jax.physics.engines.c.numpy_operations import Operand, UnknownOperation, elementwise
from estexp_jax.physics.engines.c.numpy_programs import NESTED

_NUMBER = jax.ShapeDtypeStruct((), float)
_SEEN = JointState._fields[:7]
"""What a law sees of its joint as where_of; the rest it asks for."""
_ANSWERS = {"motion_of": 2, "asked": 2, "mount": MOUNT_ROWS}
"""Numbers that a question is answered with, where they are several."""
_FUNCTION = re.compile(r"(?<![\w.])(?!float\b|abs\b)([a-z]\w*)\(")
_NUMERAL = re.compile(r"\(?-?\d+\.?\d*(e[+-]?\d+)?\)?")
_SHORT = 48
"""Longest expression, in letters, that stands in another one."""
_asked = Primitive("asked_of_site")
_asked.multiple_results = True
_asked.def_abstract_eval(lambda *_, question: [ShapedArray((), np.dtype(float))] * _ANSWERS.get(question, 1))


def _question(name: str) -> Callable[..., Any]:
    def ask(*x: Any) -> Any:
        found = _asked.bind(*(jnp.asarray(one, float) for one in x), question=name)
        if name == "mount":
            return mount_of_rows(found)
        return tuple(found) if name in _ANSWERS else found[0]

    return ask


def _joint(inputs_of_law: Sequence[Any]) -> JointState:
    asks = {name: _question(name) for name in JointState._fields[len(_SEEN) :]}
    return JointState(**dict(zip(_SEEN, inputs_of_law, strict=True)), **asks)


def term_text(e: Term, name: str) -> str:
    """A function (np, s, p, state) -> (what it does to the joint, hidden variables after the step).

    Raises:
        UnknownOperation: the law does something that has no text.
    """
    names: list[str] = []

    def act(p: Any, inputs_of_law: Any, state: Any) -> list[Any]:
        does, after = e.act(tuple(p), _joint(inputs_of_law), tuple(state))
        names[:] = [part for part, x in does._asdict().items() if not isinstance(x, float)]
        return [*(getattr(does, part) for part in names), *(after if e.n_states else ())]

    inputs = [*_parameters(e), *(f"s.{part}" for part in _SEEN), *_states(e.n_states)]
    counts = len(e.parameters), len(_SEEN), e.n_states
    lines, outputs = _lines(act, counts, inputs)
    does = ", ".join(f'"{part}": {x}' for part, x in zip(names, outputs, strict=False))
    after = "".join(f"{x}, " for x in outputs[len(names) :])
    head = [f"def {name}(np, s, p, state):", *_unpacked(e, e.n_states)]
    return _function(head, lines, f"return {{{does}}}, ({after})")


def command_text(e: CommandLaw, name: str) -> str:
    """A function (np, command, idle, dt, p, state) -> (the command that arrives, hidden variables after the step)."""

    def act(p: Any, given: Any, state: Any) -> list[Any]:
        command, after = e.act(tuple(p), given[0], given[1], given[2], tuple(state))
        return [command, *(after if e.n_states else ())]

    inputs = [*_parameters(e), "command", "idle", "dt", *_states(e.n_states)]
    lines, (command, *after) = _lines(act, (len(e.parameters), 3, e.n_states), inputs)
    head = [f"def {name}(np, command, idle, dt, p, state):", *_unpacked(e, e.n_states)]
    return _function(head, lines, f"return {command}, ({''.join(f'{x}, ' for x in after)})")


def body_text(e: BodyForce, name: str) -> str:
    """A function (np, x, y, z, p) -> force on a body whose centre of mass is there, its components."""

    def act(p: Any, place: Any) -> list[Any]:
        return list(e.force_on_body(tuple(p), tuple(place)))

    inputs = [*_parameters(e), "at_x", "at_y", "at_z"]
    lines, outputs = _lines(act, (len(e.parameters), 3), inputs)
    head = [f"def {name}(np, at_x, at_y, at_z, p):", *_unpacked(e, 0)]
    return _function(head, lines, f"return {', '.join(outputs)}")


def rest_text(e: Term | CommandLaw, name: str) -> str:
    """A function (np, p, q, w) or (np, p, command) -> hidden variables of what has been so for long."""
    given = ["q", "w"] if isinstance(e, Term) else ["command"]

    def rest(p: Any, inputs_of_law: Any) -> list[Any]:
        return list(e.initial(tuple(p), *inputs_of_law))

    inputs = [*_parameters(e), *(f"now_{x}" for x in given)]
    lines, outputs = _lines(rest, (len(e.parameters), len(given)), inputs)
    head = [f"def {name}_at_rest(np, p, {', '.join(inputs[len(e.parameters) :])}):", *_unpacked(e, 0)]
    like = inputs[len(e.parameters)]
    outputs = [f"{x} + 0.0 * {like}" if _NUMERAL.fullmatch(x) else x for x in outputs]
    return _function(head, lines, f"return ({''.join(f'{x}, ' for x in outputs)})")


def _parameters(e: Any) -> list[str]:
    return [f"{p.name}_" if keyword.iskeyword(p.name) else p.name for p in e.parameters]


def _states(n: int) -> list[str]:
    return [f"was{i}" for i in range(n)]


def _unpacked(e: Any, n_states: int) -> list[str]:
    lines = [f"    {''.join(f'{x}, ' for x in _parameters(e)).rstrip(', ')}{',' * (len(e.parameters) == 1)} = p"]
    return lines + ([f"    {''.join(f'{x}, ' for x in _states(n_states))[:-1]} = state"] if n_states else [])


def _function(head: Sequence[str], lines: Sequence[str], end: str) -> str:
    return "\n".join([*head, *(f"    {line}" for line in lines), f"    {end}"]) + "\n"


def _lines(
    function: Callable[..., list[Any]], counts: Sequence[int], inputs: Sequence[str]
) -> tuple[list[str], list[str]]:
    """Lines and results of a function of groups of where_of, so many in each."""
    with jax.enable_x64(True):
        groups = [[_NUMBER] * n for n in counts]
        traced = jax.make_jaxpr(function)(*groups)
    return _Text(traced, inputs).result()


@final
class _Text:
    """Expressions of a traced function."""

    def __init__(self, traced: Any, inputs: Sequence[str]) -> None:
        self._steps: list[tuple[list[str], str, list[str], bool]] = []
        values = {
            var: Operand(name, (), broadcasts=False) for var, name in zip(traced.jaxpr.invars, inputs, strict=True)
        }
        self._outputs = self._read(traced.jaxpr, traced.consts, values)
        self._known: dict[str, str] = {}

    def result(self) -> tuple[list[str], list[str]]:
        """Lines, and the expressions of the outputs."""
        used: dict[str, int] = {}
        for x in self._outputs:
            used[x] = used.get(x, 0) + 1
        kept = []
        for step in reversed(self._steps):
            if any(name in used for name in step[0]):
                kept.append(step)
                for operand in step[2]:
                    used[operand] = used.get(operand, 0) + 1
        lines, inlined = list[str](), dict[str, str]()
        for names, template, operands, asks in reversed(kept):
            text = template.format(*(inlined.get(x, x) for x in operands))
            if len(names) == 1 and used[names[0]] == 1 and len(text) <= _SHORT and names[0] not in self._outputs:
                inlined[names[0]] = text if asks or text.startswith("np.") and text.endswith(")") else f"({text})"
            else:
                lines.append(f"{', '.join(names)} = {text}")
        return lines, [inlined.get(x, x) for x in self._outputs]

    def _read(self, jaxpr: Any, consts: Sequence[Any], values: dict[Any, Operand]) -> list[str]:
        for var, value in zip(jaxpr.constvars, consts, strict=True):
            values[var] = _number(np.asarray(value))
        for equation in jaxpr.eqns:
            self._take(equation, values)
        return [self._operand(var, values).name for var in jaxpr.outvars]

    def _take(self, equation: Any, values: dict[Any, Operand]) -> None:
        name, operands = equation.primitive.name, [self._operand(var, values) for var in equation.invars]
        if name in NESTED:
            inner = next(
                (equation.params[k] for k in ("jaxpr", "call_jaxpr", "fun_jaxpr") if k in equation.params), None
            )
            if inner is None or not hasattr(inner, "jaxpr"):
                raise UnknownOperation(name)
            own = dict(zip(inner.jaxpr.invars, operands, strict=True))
            self._read(inner.jaxpr, inner.consts, own)
            for outer, var in zip(equation.outvars, inner.jaxpr.outvars, strict=True):
                values[outer] = self._operand(var, own)
            return
        if name == _asked.name:
            slots = ", ".join(f"{{{i}}}" for i in range(len(operands)))
            self._write(equation, f"s.{equation.params['question']}({slots})", operands, values, asks=True)
            return
        [result] = equation.outvars
        if result.aval.shape:
            raise UnknownOperation(name)
        kinds = [var.aval.dtype.kind for var in equation.invars]
        if name in ("broadcast_in_dim", "reshape", "squeeze", "copy", "copy_p", "stop_gradient"):
            values[result] = operands[0]
        elif name == "convert_element_type" and result.aval.dtype.kind == "f" and kinds[0] in "fb":
            if kinds[0] == "f":
                values[result] = operands[0]
            else:
                self._write(equation, "1.0 * {0}", operands, values)
        else:
            slots = [Operand(f"{{{i}}}", (), broadcasts=False) for i in range(len(operands))]
            squared = name == "square" or (name == "integer_pow" and equation.params["y"] == 2)
            template = "{0} ** 2" if squared else elementwise(name, equation.params, slots, result.aval.dtype.kind)
            self._write(equation, _FUNCTION.sub(r"np.\1(", template), operands, values)

    def _write(
        self,
        equation: Any,
        template: str,
        operands: Sequence[Operand],
        values: dict[Any, Operand],
        *,
        asks: bool = False,
    ) -> None:
        names = [f"t{len(self._steps)}_{i}" if i else f"t{len(self._steps)}" for i in range(len(equation.outvars))]
        self._steps.append((names, template, [x.name for x in operands], asks))
        for var, name in zip(equation.outvars, names, strict=True):
            values[var] = Operand(name, (), broadcasts=False)

    def _operand(self, var: Any, values: dict[Any, Operand]) -> Operand:
        return _number(np.asarray(var.val)) if isinstance(var, Literal) else values[var]


def _number(value: np.ndarray) -> Operand:
    if value.shape:
        raise UnknownOperation("a table")
    number = value.item()
    text = f"float('{number}')" if isinstance(number, float) and not np.isfinite(number) else repr(number)
    return Operand(f"({text})" if text.startswith("-") else text, (), broadcasts=False)
