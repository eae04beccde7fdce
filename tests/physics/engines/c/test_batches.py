"""Lanes one after the other, as before MuJoCo 4, do what MuJoCo's own batch does."""

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.engines.c import batches
from tests.physics.engines.c.test_open_loop import ZOO

LANES = 3


@pytest.fixture
def pair() -> list:
    if batches.native is None:
        pytest.skip("this MuJoCo has no batch to compare with")
    model = mujoco.MjModel.from_xml_string(ZOO)
    return [batches.new_batch(model, LANES), batches.SerialBatch(model, LANES)]


def _driven(batch) -> dict[str, np.ndarray]:
    """Lanes of unequal mass and step, stepped in turns, one from another start."""
    batch.expand("body_mass")[:, 2] *= [1.0, 2.0, 3.0]
    batch.set_const(np.arange(LANES))
    batch.expand("opt.timestep")[:] = [0.002, 0.002, 0.001]
    names = ("qpos", "qvel", "act", "ctrl", "sensordata", "xipos", "qacc_warmstart", "history")
    state = {name: batch.bind(name) for name in names}
    state["qpos"][1, -1] += 0.2
    state["ctrl"][:] = [0.1, 0.2, 0.3, 0.4]
    batch.step(nstep=5)
    batch.step(np.array([0, 2]))
    batch.forward(np.array([1]), stage=int(mujoco.mjtStage.mjSTAGE_POS))
    batch.step()
    batch.forward()
    assert batch.expanded("jnt_axis") is None
    derived = ("dof_invweight0", "body_subtreemass", "actuator_acc0")
    return {name: np.array(x) for name, x in state.items()} | {name: np.array(batch.expanded(name)) for name in derived}


def test_states_readings_and_derived_constants_are_those_of_the_batch(pair) -> None:
    expected, found = map(_driven, pair)
    for name, x in expected.items():
        np.testing.assert_array_equal(found[name], x, err_msg=name)
    assert np.ptp(found["qpos"][:, -1]) > 0.1


def test_a_lane_that_blows_up_is_told(pair) -> None:
    for batch in pair:
        batch.bind("qvel")[1] = 1e12
        batch.step(nstep=2)
        counts = batch.warning[:, :, 1]
        assert counts[1].any() and not counts[[0, 2]].any()


def test_refused_lanes_are_named(monkeypatch) -> None:
    batch = batches.SerialBatch(mujoco.MjModel.from_xml_string(ZOO), LANES)

    def refuse(model, data, n) -> None:
        if data.qpos[-1] > 1.0:
            raise mujoco.FatalError("no")

    monkeypatch.setattr(mujoco, "mj_step", refuse)
    batch.bind("qpos")[2, -1] = 2.0
    with pytest.raises(batches.LaneError, match="refused 1 lanes") as caught:
        batch.step()
    assert caught.value.ids.tolist() == [2]


def test_old_and_new_mujoco_have_the_fields_that_effects_write() -> None:
    fields = {
        "opt.timestep",
        "opt.gravity",
        "body_mass",
        "dof_damping",
        "dof_armature",
        "actuator_gainprm",
        "jnt_range",
    }
    assert fields <= set(batches._lane_fields()) and fields <= set(batches.lane_fields())
    assert not any(name.startswith(("mesh_", "names")) for name in batches._lane_fields())
