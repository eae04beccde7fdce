# Written by typings/generate.py from mujoco 4.0.0; not to be edited.
from __future__ import annotations
import numpy
import numpy.typing
import typing
class Rollout:
    def __init__(self, *, nthread: typing.SupportsIndex) -> None: ...
    def rollout(self, model: list, data: list, nstep: typing.SupportsIndex, control_spec: typing.SupportsIndex, state0: numpy.typing.ArrayLike, warmstart0: numpy.typing.ArrayLike | None = None, control: numpy.typing.ArrayLike | None = None, state: numpy.typing.ArrayLike | None = None, sensordata: numpy.typing.ArrayLike | None = None, chunk_size: typing.SupportsIndex | None = None) -> None: ...
