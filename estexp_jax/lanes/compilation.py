"""Compiling a lanes program with the two XLA options that make it fast; the one place that uses JAX's private parts.

`xla_cpu_use_multi_output_fusion`: without it XLA recomputes shared values in every fusion that reads them, which is
twenty times slower and not even right: recomputed copies of one value differ in rounding, and the solver's steps with
them. `xla_cpu_small_while_loop_byte_threshold`: lets the solver's loop be compiled as one function.

Neither may be set for the whole process: the first makes XLA abort on MJX's programs. `jit(compiler_options=...)`
refuses this kind of option, a map. So it is put into the serialised options of the one compilation under way: fields
of a protobuf message that are appended are merged into it.
"""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import jax

_LOOP_BYTES = 30_000
"""Memory that a loop may touch for each robot in one pass and still be compiled as one function, which saves it XLA's
executor: enough for the solver, too little for the step around it. With the step in it as well, LLVM takes half as long
again over the rollout of the quadruped, in one thread instead of all, and the rollout is no faster."""
_EXACT = {"xla_disable_hlo_passes": "fusion,cpu-instruction-fusion"}
"""A public option under which the program is right and slow: no fusion, no copies of values."""
_BUILD_OPTIONS, _DEBUG_OPTIONS, _BACKEND_EXTRA = 3, 3, 500
"""Field numbers: CompileOptionsProto.executable_build_options, ExecutableBuildOptionsProto.debug_options,
DebugOptions.xla_backend_extra_options. Source: xla/pjrt/proto/compile_options.proto, xla/xla.proto."""

_now = threading.local()


class OptionsIgnored(Exception):
    """The options did not reach XLA."""


def lower(function: Callable[..., Any], *arguments: Any, label: str = "") -> Any:
    """`jax.jit(function).lower(*arguments)`, without Python's garbage collector.

    What tracing makes all stays; looking through it again and again takes the collector a third of the time.

    Args:
        function: what is traced.
        *arguments: for it.
        label: end of the program's name.
    """

    def program(*given: Any) -> Any:
        return function(*given)

    program.__name__ = f"program_{label}" if label else getattr(function, "__name__", "program")
    collects = gc.isenabled()
    gc.disable()
    try:
        return jax.jit(program).lower(*arguments)
    finally:
        if collects:
            gc.enable()


def compile_lowered(program: Any, robots: int) -> tuple[Any, bool]:
    """Compile a lowered lanes program for so many robots.

    Returns:
        The executable, and whether it is the fast one; else it is right, but some twenty times slower.
    """
    if jax.default_backend() != "cpu":
        return program.compile(), True
    try:
        with _extra_options(robots):
            fast = program.compile()
        if not _has_multi_output_fusion(fast.as_text()):
            raise OptionsIgnored
    except (OptionsIgnored, ImportError, AttributeError, TypeError, ValueError):
        return program.compile(compiler_options=_EXACT), False
    return fast, True


def _has_multi_output_fusion(text: str) -> bool:
    return any(" fusion(" in line and "= (" in line for line in text.splitlines())


@contextmanager
def _extra_options(robots: int) -> Iterator[None]:
    """Within the block, compilations of this thread get the options."""
    _install()
    _now.wanted = {
        "xla_cpu_use_multi_output_fusion": "true",
        "xla_cpu_small_while_loop_byte_threshold": str(robots * _LOOP_BYTES),
    }
    try:
        yield
    finally:
        _now.wanted = None


def _install() -> None:
    """Wrap JAX's maker of compile options, once; without `_now.wanted` it does what it did."""
    from jax._src import compiler

    original = compiler.get_compile_options
    if getattr(original, "_estexp_wraps", False):
        return

    def get_compile_options(*args: Any, **kwargs: Any) -> Any:
        options, wanted = original(*args, **kwargs), getattr(_now, "wanted", None)
        return _with_options(options, wanted) if wanted else options

    get_compile_options._estexp_wraps = True  # type: ignore[attr-defined]
    compiler.get_compile_options = get_compile_options


def _with_options(options: Any, wanted: Mapping[str, str]) -> Any:
    from jax._src.lib import xla_client  # pyright: ignore[reportPrivateImportUsage]

    entries = b"".join(
        _message(_BACKEND_EXTRA, _message(1, key.encode()) + _message(2, value.encode()))
        for key, value in wanted.items()
    )
    appended = _message(_BUILD_OPTIONS, _message(_DEBUG_OPTIONS, entries))
    changed = xla_client.CompileOptions.ParseFromString(options.SerializeAsString() + appended)
    if not all(key.encode() in changed.SerializeAsString() for key in wanted):
        raise OptionsIgnored
    return changed


def _message(field: int, payload: bytes) -> bytes:
    """A length-delimited protobuf field."""
    return _varint(field << 3 | 2) + _varint(len(payload)) + payload


def _varint(n: int) -> bytes:
    head = b""
    while n > 127:
        head += bytes([n & 127 | 128])
        n >>= 7
    return head + bytes([n])
