"""Edits of lanes' models: MuJoCo's own fields, in double precision, and the constants that follow from them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, final

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import NEVER, Edit
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.engines.c.batches import needs_constants
from estexp_jax.physics.engines.c.instances import at_work
from estexp_jax.physics.engines.c.lane_models import ARMED, LaneModels, c_field_of
from estexp_jax.physics.model.robot import Robot

_PROGRAMS = 512
"""Programs of edits that are kept."""
_ONE_AT_A_TIME = threading.Lock()
"""Chunks would else compile the same edit side by side."""
_QUICKLY = {"xla_backend_optimization_level": 0}
"""Edits are done once a chunk: compiling them takes longer than they do."""
_LANES = 64
"""Lanes in a call, so that programs of one width serve all."""


def edited_models(
    robot: Robot,
    catalogue: Catalogue,
    recorded: dict[str, np.ndarray],
    recording: Sequence[int],
    values: Values,
    *,
    finer: bool = False,
) -> LaneModels:
    """Models of lanes with their recordings' settings and their edits.

    Args:
        robot: the nominal robot.
        catalogue: effects.
        recorded: `recorded_fields` of the robot.
        recording: index of each lane's recording.
        values: (lanes, n_sites, n_parameters) for each effect.
        finer: whether steps may be shorter than the robot's own.
    """
    models = LaneModels(robot, recorded, recording, finer=finer)
    if not _edit_all(robot, catalogue, models, values):
        models = LaneModels(robot, recorded, recording, simple=False, finer=finer)
        _edit_all(robot, catalogue, models, values)
    return models


def _edit_all(robot: Robot, catalogue: Catalogue, models: LaneModels, values: Values) -> bool:
    """Edit the models of lanes; whether MuJoCo takes them all."""
    edits = [e for e in catalogue if isinstance(e, Edit)]
    acting = {e: np.flatnonzero(at_work(e, np.asarray(values[e.name])).any(axis=1)) for e in edits}
    stale = np.zeros(models.lanes, bool)
    for e, lanes in acting.items():
        if lanes.size and e.arms:
            models.arm(set(e.arms), lanes)
    for e, lanes in acting.items():
        if lanes.size:
            with _ONE_AT_A_TIME:
                written = _edit(robot, e, models, np.asarray(values[e.name], float)[lanes], lanes)
            stale[lanes] |= needs_constants(written)
    return models.derive(np.flatnonzero(stale)) if stale.any() else True


def _edit(robot: Robot, e: Edit, models: LaneModels, values: np.ndarray, lanes: np.ndarray) -> set[str]:
    """Edit some lanes; the names of the fields that were written."""
    reads, program = _program(robot, e)
    written = set[str]()
    for first in range(0, len(lanes), _LANES):
        index = np.minimum(np.arange(first, first + _LANES), len(lanes) - 1)
        fields = {name: models.read(name)[lanes[index]].astype(float) for name in reads}
        with jax.enable_x64(True):
            found = {name: np.asarray(x) for name, x in program(fields, values[index]).items()}
        for name, x in found.items():
            models.own(name)[lanes[index]] = x
        written |= set(found)
    return written


def fields_after_edit(
    robot: Robot, e: Edit, values: np.ndarray, field: Callable[[str], np.ndarray]
) -> dict[str, np.ndarray]:
    """The fields that an edit writes into one model; limits that it asks for only where they have an effect.

    Args:
        robot: the nominal robot.
        e: the edit.
        values: (n_sites, n_parameters).
        field: gives a field of the model.
    """
    armed = dict[str, np.ndarray]()
    if e.arms:
        models = LaneModels(robot, {}, [0])
        models.arm(set(e.arms), np.array([0]))
        names = (name for pair in ARMED for name in pair if models.batch.expanded(name) is not None)
        armed = {name: np.array(models.read(name)[0]) for name in names}
    reads, program = _program(robot, e)
    given = {name: np.asarray(armed.get(name, field(name)), float)[None] for name in reads}
    with _ONE_AT_A_TIME, jax.enable_x64(True):
        found = armed | {name: np.array(x)[0] for name, x in program(given, values[None]).items()}
    for switch, limits in ARMED:
        if limits in armed:
            without = (found[limits] == (-NEVER, NEVER)).all(axis=1)
            found[switch][without], found[limits][without] = field(switch)[without], field(limits)[without]
    return found


@lru_cache(maxsize=_PROGRAMS)
def _program(robot: Robot, e: Edit) -> tuple[tuple[str, ...], Callable[..., dict[str, jax.Array]]]:
    """Fields that an edit reads, and the edit itself for many lanes: (fields, values) -> the fields it writes."""
    reads: dict[str, None] = {}

    def nominal(name: str) -> Any:
        value = np.asarray(c_field_of(robot.model, name))
        if value.dtype.kind == "f":
            reads[name] = None
        return jnp.asarray(value) if value.dtype.kind == "f" else value

    def edited(find: Callable[[str], Any], values: Any) -> dict[str, Any]:
        view: Any = ModelView(find)
        return e.edit(robot, view, values).changed_fields()

    def one(fields: Mapping[str, Any], values: Any) -> dict[str, Any]:
        return edited(lambda name: fields[name] if name in fields else nominal(name), values)

    with jax.enable_x64(True):
        shape = jax.ShapeDtypeStruct((len(e.sites(robot)), len(e.parameters)), float)
        jax.eval_shape(lambda values: edited(nominal, values), shape)
    return tuple(reads), jax.jit(jax.vmap(one), compiler_options=_QUICKLY)


@final
class ModelView:
    """As much of an MJX model as edits use: fields by name, and `replace`."""

    def __init__(self, find: Callable[[str], Any], changed: Mapping[str, Any] | None = None) -> None:
        """With `find` to look fields up, and those that were replaced."""
        self._find, self._changed = find, dict(changed or {})

    def __getattr__(self, name: str) -> Any:
        if name in self._changed:
            return self._changed[name]
        if name == "opt":
            return ModelView(lambda field: self._find(f"opt.{field}"))
        return self._find(name)

    def replace(self, **fields: Any) -> ModelView:
        """The same with other fields."""
        return ModelView(self._find, self._changed | fields)

    def changed_fields(self) -> dict[str, Any]:
        """Fields that were replaced, those of the options with `opt.` before their names."""
        found = {name: x for name, x in self._changed.items() if name != "opt"}
        options = self._changed.get("opt")
        return found | ({f"opt.{name}": x for name, x in options.changed_fields().items()} if options else {})
