"""Many simulations of one model: MuJoCo's own batch where it has one (since 4), else the same one lane after the other.

Engines on C are written for the part of `mujoco.batch` that is here. What differs is speed alone: before MuJoCo 4 each
lane's state and fields go through one model and one `MjData`, from Python.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, final

import mujoco
import numpy as np

try:
    import mujoco.batch as native
except ImportError:  # before MuJoCo 4
    native = None

_STATE = {
    "qpos": mujoco.mjtState.mjSTATE_QPOS,
    "qvel": mujoco.mjtState.mjSTATE_QVEL,
    "act": mujoco.mjtState.mjSTATE_ACT,
    "history": mujoco.mjtState.mjSTATE_HISTORY,
    "qacc_warmstart": mujoco.mjtState.mjSTATE_WARMSTART,
    "ctrl": mujoco.mjtState.mjSTATE_CTRL,
    "qfrc_applied": mujoco.mjtState.mjSTATE_QFRC_APPLIED,
    "xfrc_applied": mujoco.mjtState.mjSTATE_XFRC_APPLIED,
}
_ALL = mujoco.mjtState.mjSTATE_INTEGRATION
_OF_ASSETS = ("mesh_", "tex_", "hfield_", "skin_", "name", "path", "text_", "tuple_", "oct_", "bvh_", "mat_", "cam_")
"""Beginnings of fields that no lane has for itself."""


class LaneError(RuntimeError):
    """MuJoCo refused some lanes of a call.

    Attributes:
        ids: (n,) which.
    """

    def __init__(self, ids: np.ndarray, message: str) -> None:
        """With MuJoCo's message about the first of them."""
        super().__init__(f"MuJoCo refused {len(ids)} lanes, the first with: {message}")
        self.ids = ids


def refusals() -> Any:
    """The class of errors, with the attribute `ids`, that a batch raises where MuJoCo refuses lanes."""
    return LaneError if native is None else native.SimulationError


def lane_fields() -> Sequence[str]:
    """Fields of a model, options with `opt.` before them, that lanes may have for themselves."""
    return _lane_fields() if native is None else sorted(native.MODEL_FIELDS)


def needs_constants(written: set[str]) -> bool:
    """Whether constants are to be derived anew after these fields have been written; always before MuJoCo 4."""
    return native is None or not written.isdisjoint(mujoco.MjModel._setconst_inputs)


def new_batch(model: mujoco.MjModel, lanes: int, *, nthread: int = 1, persistent: bool = False) -> Any:
    """A `mujoco.batch.Batch`, or a `SerialBatch` before MuJoCo 4.

    Args:
        model: all lanes' model.
        lanes: how many.
        nthread: threads; before MuJoCo 4 there is one.
        persistent: whether each lane keeps an `MjData` of its own, which sleeping bodies need.
    """
    if native is None:
        return SerialBatch(model, lanes, persistent=persistent)
    return native.Batch(model, lanes, nthread=nthread, persistent=persistent)


@final
class SerialBatch:
    """The part of `mujoco.batch.Batch` that engines use, one lane after the other.

    Attributes:
        model: all lanes' model as it was given.
        warning: (lanes, kinds, 2) MuJoCo's last info and number of warnings of each lane.
    """

    def __init__(self, model: mujoco.MjModel, lanes: int, *, persistent: bool = False) -> None:
        """As `new_batch`."""
        self.model, self._lanes = model, lanes
        self._own = model.__copy__()
        self._data = [mujoco.MjData(model) for _ in range(lanes if persistent else 1)]
        data, size = self._data[0], mujoco.mj_stateSize(model, _ALL)
        first = np.zeros(size)
        mujoco.mj_getState(model, data, first, _ALL)
        self._state = np.tile(first, (lanes, 1))
        self.warning = np.zeros((lanes, len(data.warning.number), 2), np.int32)
        self._bound: dict[str, np.ndarray] = {}
        self._fields: dict[str, np.ndarray] = {}

    def bind(self, name: str) -> np.ndarray:
        """A live array (lanes, ...) of a field of `MjData`: what is written into a state counts from the next call."""
        if name in _STATE:
            component = int(_STATE[name])
            first = sum(self._size(1 << bit) for bit in range(component.bit_length() - 1) if int(_ALL) >> bit & 1)
            view = self._state[:, first : first + self._size(component)]
            shape = np.shape(getattr(self._data[0], name, view[0]))
            return view.reshape(self._lanes, *shape)
        if name not in self._bound:
            field = np.asarray(getattr(self._data[0], name))
            self._bound[name] = np.zeros((self._lanes, *field.shape), field.dtype)
        return self._bound[name]

    def expand(self, name: str) -> np.ndarray:
        """A live array (lanes, ...) of a field of `lane_fields`, that counts from the next call."""
        if name not in self._fields:
            nominal = np.asarray(_field(self.model, name))
            self._fields[name] = np.repeat(nominal[None], self._lanes, axis=0)
        return self._fields[name]

    def expanded(self, name: str) -> np.ndarray | None:
        """A field's values (lanes, ...) where lanes may differ, else None."""
        return self._fields.get(name)

    def set_const(self, ids: np.ndarray) -> None:
        """Derive lanes' constants anew from their fields.

        Raises:
            LaneError: MuJoCo refuses some.
        """
        self._each(ids, self._set_const)

    def step(self, ids: np.ndarray | None = None, nstep: int = 1) -> None:
        """Step lanes, all for None.

        Raises:
            LaneError: MuJoCo refuses some; they stay as they were.
        """
        self._each(ids, lambda _, data: mujoco.mj_step(self._own, data, nstep), keeps=True)

    def forward(self, ids: np.ndarray | None = None, stage: int = int(mujoco.mjtStage.mjSTAGE_ACC)) -> None:
        """Compute what depends on lanes' states, up to a stage.

        Raises:
            LaneError: MuJoCo refuses some.
        """
        if int(stage) == int(mujoco.mjtStage.mjSTAGE_POS):
            self._each(ids, lambda _, data: _positions(self._own, data), keeps=True)
        else:
            self._each(ids, lambda _, data: mujoco.mj_forward(self._own, data), keeps=True)

    def _each(self, ids: np.ndarray | None, what: Callable[[int, Any], None], *, keeps: bool = False) -> None:
        failed, message = list[int](), ""
        for lane in range(self._lanes) if ids is None else np.asarray(ids).tolist():
            data = self._data[lane % len(self._data)]
            for name, values in self._fields.items():
                _write(self._own, name, values[lane])
            try:
                if keeps:
                    self._load(lane, data)
                what(lane, data)
            except mujoco.FatalError as error:
                failed, message = [*failed, lane], message or str(error)
                continue
            if keeps:
                self._save(lane, data)
        if failed:
            raise LaneError(np.array(failed), message)

    def _load(self, lane: int, data: mujoco.MjData) -> None:
        for kind, (info, number) in enumerate(self.warning[lane].tolist()):
            data.warning[kind].lastinfo, data.warning[kind].number = info, number
        mujoco.mj_setState(self._own, data, self._state[lane], _ALL)

    def _save(self, lane: int, data: mujoco.MjData) -> None:
        mujoco.mj_getState(self._own, data, self._state[lane], _ALL)
        self.warning[lane, :, 0], self.warning[lane, :, 1] = data.warning.lastinfo, data.warning.number
        for name, values in self._bound.items():
            values[lane] = getattr(data, name)

    def _set_const(self, lane: int, data: mujoco.MjData) -> None:
        before = {name: np.array(_field(self._own, name)) for name in _lane_fields()}
        mujoco.mj_setConst(self._own, data)
        for name, old in before.items():
            new = np.asarray(_field(self._own, name))
            if name in self._fields or not np.array_equal(new, old, equal_nan=old.dtype.kind == "f"):
                self.expand(name)[lane] = new

    def _size(self, component: int) -> int:
        return mujoco.mj_stateSize(self.model, component)


def _positions(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_sensorPos(model, data)


def _field(model: mujoco.MjModel, name: str) -> Any:
    return getattr(model.opt, name.removeprefix("opt.")) if name.startswith("opt.") else getattr(model, name)


def _write(model: mujoco.MjModel, name: str, value: np.ndarray) -> None:
    """Give a field of a model, or with `opt.` before it of its options, a value."""
    if not name.startswith("opt."):
        getattr(model, name)[...] = value
    elif np.ndim(value):
        getattr(model.opt, name.removeprefix("opt."))[...] = value
    else:
        setattr(model.opt, name.removeprefix("opt."), value.item())


def _lane_fields() -> list[str]:
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    arrays = [n for n in dir(model) if not n.startswith("_") and isinstance(getattr(model, n), np.ndarray)]
    own = [name for name in arrays if not name.startswith(_OF_ASSETS)]
    options = [n for n in dir(model.opt) if not n.startswith("_") and not callable(getattr(model.opt, n))]
    return sorted([*own, *(f"opt.{name}" for name in options)])
