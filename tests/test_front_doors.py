"""What the package offers at its top level, that it agrees with the commands, and the notebooks that show it."""

import re
import subprocess
import sys
from dataclasses import MISSING, fields
from importlib import import_module
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import pytest

import estexp_jax as ee
from estexp_jax.cli.commands import COMMANDS
from estexp_jax.errors import InputError

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "experiments" / "notebooks").glob("*.ipynb"))
MIRRORED = ("check", "explain", "propose", "record", "recover")
"""Doors that are commands as well."""
ONLY_COMMANDS = {
    "check": {"files", "out", "init", "force", "resume"},
    "explain": {"files", "out", "pictures", "force", "resume"},
    "propose": {"out", "force", "resume"},
    "record": set(),
    "recover": {"root", "out", "hardware", "healthy", "pictures", "force", "resume"},
}
ONLY_PYTHON = {
    "check": {"model", "recordings"},
    "explain": {"model", "recordings", "progress"},
    "propose": {"progress"},
    "record": set(),
    "recover": {"target"},
}
INNER = {
    "explain": ("estexp_jax.discovery.diagnosis", "ExplainConfig"),
    "propose": ("estexp_jax.experiment_design.propose", "ProposeConfig"),
    "record": ("estexp_jax.replay.synthetic_recordings", "RecordConfig"),
    "bench": ("estexp_jax.benchmark.measure", "BenchConfig"),
    "recover": ("estexp_jax.recovery.config", "Settings"),
}
WRONG = {
    "check": (("nominal.xml",), {"tests": ["a.csv"]}, "known are: test,"),
    "explain": (("nominal.xml",), {"windw": 1.0}, "known are: window,"),
    "propose": (("explained",), {"length": 1.0}, "known are: "),
    "record": (("arm.xml", "out"), {"effects": "x"}, "known are: effect,"),
    "recover": ((None,), {"pases": 2}, "known are: passes,"),
    "rollout": ((None, [], None), {"gains": 3.0}, "known are: gain,"),
    "simulate": (("nominal.xml", {}), {"begin": None}, "known are: "),
    "load_controller": ((), {"file": "a.npz"}, "known are: path"),
    "load_explained": ((), {"path": "out"}, "known are: folder"),
    "randomisation": (("out",), {"n": 3}, "known are: "),
    "actuator_settings": ((), {"path": "out"}, "known are: folder"),
}


def options_of(command: str) -> Any:
    return getattr(import_module(f"estexp_jax.api.options.{command}"), f"{command.capitalize()}Options")


def parts(hint: Any) -> set[Any]:
    """The types and choices of an annotation; a sequence of any kind is a sequence, a path may be text."""
    if get_origin(hint) is None:
        return {str} if isinstance(hint, type) and issubclass(hint, Path) else {hint}
    inner = get_args(hint)[:1] if hasattr(hint, "__metadata__") else get_args(hint)
    return {part for each in inner if each is not Ellipsis for part in parts(each)}


def test_every_door_opens():
    for name in ee.__all__:
        assert callable(getattr(ee, name))


def test_what_does_not_exist_is_told():
    with pytest.raises(AttributeError, match="no attribute 'repair'"):
        ee.repair  # noqa: B018


def test_importing_costs_nothing():
    code = "import sys, estexp_jax; assert not {'jax', 'mujoco', 'matplotlib', 'tyro'} & set(sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_version_is_that_of_the_command(capsys):
    assert import_module("estexp_jax.cli.main").main(["--version"]) == 0
    assert capsys.readouterr().out == f"estexp {ee.__version__}\n"


@pytest.mark.parametrize("name", MIRRORED)
def test_a_door_has_the_options_of_its_command(name):
    """In names, defaults and types; `None` and the empty tuple both say that nothing was chosen."""
    door, options = getattr(ee, name), options_of(name)
    given = {p.name: p for p in signature(door).parameters.values() if p.kind is not Parameter.POSITIONAL_ONLY}
    wanted = {field.name: field for field in fields(options)}
    positional = {p.name for p in signature(door).parameters.values()} - set(given)
    assert set(given) - ONLY_PYTHON[name] == set(wanted) - ONLY_COMMANDS[name] - positional
    hints, others = get_type_hints(door), get_type_hints(options, include_extras=True)
    for option in set(given) - ONLY_PYTHON[name]:
        default = wanted[option].default
        if default is not MISSING:
            assert given[option].default == default, option
        assert parts(others[option]) <= parts(hints[option]) | {type(None)}, option


@pytest.mark.parametrize("name", INNER)
def test_options_agree_with_what_they_configure(name):
    """Where both have a default, it is the same; and so are the choices."""
    options, (module, inner) = options_of(name), INNER[name]
    config = getattr(import_module(module), inner)
    both = {f.name: f for f in fields(options)}.keys() & {f.name for f in fields(config)}
    assert len(both) >= 4
    hints, others = get_type_hints(options, include_extras=True), get_type_hints(config)
    for field in both:
        ours, theirs = getattr(options, field, None), getattr(config, field, None)
        assert ours in (None, ()) or theirs is None or ours == theirs, field
        assert parts(others[field]) <= parts(hints[field]) | {str}, field


def test_engines_are_those_that_exist():
    engines = import_module("estexp_jax.physics.engines.choice").ENGINES
    for name in ("explain", "propose", "recover"):
        assert parts(get_type_hints(options_of(name), include_extras=True)["engine"]) == set(engines)


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_keyword_is_an_input_error_that_lists_what_exists(name):
    arguments, keywords, message = WRONG[name]
    with pytest.raises(InputError, match=rf"{name}\(\): has no keyword") as refused:
        getattr(ee, name)(*arguments, **keywords)
    assert message in str(refused.value)


def test_numbers_of_all_commands_have_ranges():
    for name in COMMANDS:
        hints = get_type_hints(options_of(name), include_extras=True)
        for option, hint in hints.items():
            if {int, float} & parts(hint):
                assert "Range(" in str(hint), f"{name} --{option}"


def test_there_are_notebooks_of_both_jobs_and_of_an_own_effect():
    assert [path.stem for path in NOTEBOOKS] == ["explain", "own_effect", "recover"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_holds_outputs_of_its_own_and_no_place_on_a_machine(path):
    import nbformat

    text = path.read_text(encoding="utf-8")
    assert not re.search(r"/(home|root|work|Users)/| at 0x[0-9a-f]{6,}", text)
    for cell in nbformat.reads(text, as_version=4).cells:
        if cell.cell_type == "code":
            assert cell.execution_count, "run: python docs/run_notebooks.py"
            assert all(output.output_type != "error" for output in cell.outputs)


SMALLER = {
    "most=2": "most=1, effects=('viscous_friction', 'coulomb_friction')",
    r"population=\d+, generations=\d+, steps=\d+": "population=8, generations=2, steps=40, settle_steps=10",
    r"gaits, steps=\d+": "gaits, steps=40",
}
"""What makes a notebook's calls quick."""


@pytest.mark.filterwarnings("ignore")  # of Jupyter's own parts
@pytest.mark.parametrize(
    ("path", "small"),
    [
        *(pytest.param(path, True, id=f"{path.stem}-small") for path in NOTEBOOKS if path.stem != "own_effect"),
        *(pytest.param(path, False, id=path.stem, marks=pytest.mark.slow) for path in NOTEBOOKS),
    ],
)
def test_a_notebook_runs_and_shows_pictures(path, small, tmp_path):
    import nbformat
    from nbclient import NotebookClient

    book = nbformat.read(path, as_version=4)
    for cell in book.cells if small else ():
        for written, smaller in SMALLER.items():
            cell.source = re.sub(written, smaller, cell.source)
    NotebookClient(book, timeout=900, resources={"metadata": {"path": str(tmp_path)}}).execute()
    kinds = [kind for cell in book.cells for output in cell.get("outputs", ()) for kind in output.get("data", {})]
    assert sum(kind.startswith("image/") for kind in kinds) >= 2
    if path.stem == "recover":
        told = [output for cell in book.cells for output in cell.get("outputs", ())]
        filmed = any('alt="the walks"' in output.get("data", {}).get("text/html", "") for output in told)
        assert filmed or any("robots cannot be drawn here" in output.get("text", "") for output in told)
    if path.stem == "own_effect":
        [last] = book.cells[-1]["outputs"]
        assert "a brake at shaft resists most" in last["text"]
