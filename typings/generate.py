"""Write stubs of mujoco's compiled modules beside this file, where pyright looks for them.

`make typings` installs pybind11-stubgen for it and runs it; do so after every change of mujoco's version. Only compiled
modules need stubs: pyright reads the source of the others. pybind11-stubgen finds all names and most of the types. This
program shortens its stubs (no docstrings, one base of all enumerations) and mends the types that mujoco's signatures
leave out or give in C++.
"""

from __future__ import annotations

import importlib
import keyword
import logging
import re
from dataclasses import replace
from pathlib import Path

import mujoco
from pybind11_stubgen import CLIArgs, arg_parser, stub_parser_from_args
from pybind11_stubgen.printer import Printer
from pybind11_stubgen.structs import (
    Argument,
    Attribute,
    Class,
    Function,
    Import,
    InvalidExpression,
    Method,
    Module,
    Property,
    QualifiedName,
    ResolvedType,
    Value,
)

MODULES = "batch callbacks constants enums errors functions render rollout specs structs".split()

# What mujoco's signatures leave out: the C function returns NULL, or the binding a plain `object`.
RETURNS = {
    "mj_id2name": "str | None",
    "mj_actuatorInputName": "str | None",
    "compile": "_structs.MjModel",
    "recompile": "tuple[_structs.MjModel, _structs.MjData]",
}
# What MjSpec and its bodies hold comes as plain lists; the other lists have their class's name and an s.
SINGULAR = {"bodies": "Body", "meshes": "Mesh", "equalities": "Equality", "flexes": "Flex", "hfields": "HField"}
# The name of a C++ class, in full, and what it is called in the stubs.
FROM_CPP = (
    (r"mjs(\w+)_", r"_specs.Mjs\1"),
    (r"mujoco::python::(Mj\w+Views)", r"_\1"),
    (r"mujoco::python::(Mj\w+)", r"_specs.\1"),
    (r"mujoco::python::_impl::MjWrapper<mj(\w+)_>", r"Mj\1"),
)


class StubPrinter(Printer):
    """Prints a module's stub with one line for each function."""

    def __init__(self) -> None:
        super().__init__(invalid_expr_as_ellipses=False)
        self._classes: set[str] = set()
        self._is_argument = False

    def print_module(self, module: Module) -> list[str]:
        """Without `__all__`, which these modules do not have."""
        self._classes = {str(each.name) for each in module.classes}
        attributes = [each for each in module.attributes if each.name != "__all__"]
        lines = super().print_module(replace(module, attributes=attributes))
        return [re.sub(r"\bmujoco\.(_\w+)", r"\1", line) for line in lines]

    def print_import(self, import_: Import) -> list[str]:
        """Siblings by relative imports; an exception says that it is `mujoco`'s own, and is defined here instead."""
        *parents, name = import_.origin
        if parents != ["mujoco"]:
            return super().print_import(import_)
        if name.startswith("_"):
            return [f"from . import {name}"]
        return [f"class {name}({getattr(mujoco, name).__base__.__name__}): ..."]

    def print_attribute(self, attr: Attribute) -> list[str]:
        """Its type, without the value; one that only `getattr` can name, as MjVisual's `global`, is left out."""
        if keyword.iskeyword(attr.name):
            return []
        return super().print_attribute(attr if attr.annotation is None else replace(attr, value=None))

    def print_class(self, class_: Class) -> list[str]:
        """What `mujoco/__init__.py` adds to a class takes an instance first, and is no static method."""

        def mended(method: Method) -> Method:
            first = method.function.args[:1]
            return replace(method, modifier=None) if first and str(first[0].annotation) == class_.name else method

        return super().print_class(replace(class_, doc=None, methods=[mended(each) for each in class_.methods]))

    def print_property(self, prop: Property) -> list[str]:
        """A plain list with the class of what it holds."""
        element = f"Mjs{SINGULAR.get(prop.name, prop.name[:-1].capitalize())}"
        if prop.getter is not None and str(prop.getter.returns) == "list" and element in self._classes:
            prop = replace(prop, getter=replace(prop.getter, returns=Value(f"list[{element}]", True)))
        return super().print_property(prop)

    def print_function(self, func: Function) -> list[str]:
        """Whatever follows a default has one too: mujoco lets one leave out the first and name the second."""
        args, seen = [], False
        for arg in func.args:
            seen = seen or arg.default is not None
            is_printable = isinstance(arg.default, Value) and arg.default.is_print_safe
            args.append(replace(arg, default=Value("...", True)) if seen and not is_printable else arg)
        returns = Value(RETURNS[func.name], True) if func.name in RETURNS else func.returns
        *decorators, head, body = super().print_function(replace(func, args=args, returns=returns, doc=None))
        return [*decorators, f"{head} {body.strip()}"]

    def print_argument(self, arg: Argument) -> str:
        """With the None that is its default among its types."""
        self._is_argument = True
        text = super().print_argument(arg)
        self._is_argument = False
        return text if "| None" in text else re.sub(" = None$", " | None = None", text)

    def print_type(self, type_: ResolvedType) -> str:
        """Arrays without their shapes, and whatever is like an array where it is only read."""
        parameters = type_.parameters or []
        if str(type_.name) == "typing.Annotated":
            array = self.print_annotation(parameters[0])
            is_written = any("writeable" in str(each) for each in parameters)
            return "numpy.typing.ArrayLike" if self._is_argument and "NDArray" in array and not is_written else array
        # A float has __int__, but pybind11 refuses it where an integer is asked for.
        parameters = [each for each in parameters if str(each) != "typing.SupportsInt"]
        return super().print_type(replace(type_, parameters=parameters))

    def print_invalid_exp(self, invalid_expr: InvalidExpression) -> str:
        """The stubs' name for a C++ class."""
        for cpp, python in FROM_CPP:
            if re.fullmatch(cpp, invalid_expr.text):
                return re.sub(cpp, python, invalid_expr.text)
        return "typing.Any"


class EnumPrinter(StubPrinter):
    """Prints what all enumerations have in common once, in a base class which only the stubs have."""

    BASE = "_Enumeration"

    def print_module(self, module: Module) -> list[str]:
        """The base, and the enumerations' members.

        Raises:
            ValueError: if one of them has other methods than the rest.
        """
        common = {"\n".join(self._common(each)) for each in module.classes}
        if len(common) > 1:
            raise ValueError("the enumerations have different methods: there is no common base")
        bases = [QualifiedName.from_str(self.BASE)]
        members = [replace(each, bases=bases, methods=[], properties=[]) for each in module.classes]
        imports = super().print_module(replace(module, classes=[]))
        return [*imports, *common, *super().print_module(replace(module, imports=set(), classes=members))]

    def _common(self, class_: Class) -> list[str]:
        base = self.print_class(replace(class_, name=self.BASE, fields=[]))
        return [re.sub(rf"\b{class_.name}\b", "typing.Self", line) for line in base]


def stub(name: str) -> str:
    """The text of the stub of one of mujoco's compiled modules."""
    arguments = arg_parser().parse_args(["--ignore-all-errors", name], namespace=CLIArgs())
    parser = stub_parser_from_args(arguments)
    module = parser.handle_module(QualifiedName.from_str(name), importlib.import_module(name))
    parser.finalize()
    printer = EnumPrinter() if name.endswith("._enums") else StubPrinter()
    header = f"# Written by typings/generate.py from mujoco {mujoco.__version__}; not to be edited."
    return "\n".join([header, *printer.print_module(module), ""])


def main() -> None:
    """Write all of them, as the partial stub package of PEP 561: the rest of `mujoco` is read from its source."""
    logging.getLogger("pybind11_stubgen").setLevel(logging.CRITICAL)  # C++ names, which FROM_CPP translates
    folder = Path(__file__).parent / "mujoco-stubs"
    folder.mkdir(exist_ok=True)
    (folder / "py.typed").write_text("partial\n")
    for module in MODULES:
        (folder / f"_{module}.pyi").write_text(stub(f"mujoco._{module}"))


if __name__ == "__main__":
    main()
