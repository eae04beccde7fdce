"""Predictions of competing models for proposed motions."""

import json
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from estexp_jax.discovery.competing_models import CompetingModel, CompetingModels
from estexp_jax.experiment_design import propose as module
from estexp_jax.experiment_design.predictive_simulation import predictive_simulation_of
from estexp_jax.experiment_design.separation import (
    limits_of,
)
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.propose.text import rival_status
from estexp_jax.runs.files import json_plain
from tests.discovery.planted import nominal, problem_of, shared_replayer
from tests.experiment_design.competing import (
    DRY,
    PAYLOAD,
    WEAK,
    competing,
    simulation,
)


def test_what_only_more_numbers_make_improbable_is_worth_a_motion_and_no_refuted_rival():
    among = competing(PAYLOAD, WEAK, probabilities=(1.0, 0.0))
    as_good = replace(among, models=(among.models[0], replace(among.models[1], tied=True)))
    assert simulation(among).probabilities.tolist() == [1.0, 0.0]
    assert simulation(as_good).probabilities.tolist() == [1.0, 0.1]
    assert [rival_status(c.models[1]) for c in (among, as_good)] == ["refuted already", "fits as well, by more numbers"]
    assert CompetingModel.from_json(as_good.models[1].to_json()).tied


def test_no_motion_may_bring_parts_together_that_the_simulation_lets_through_each_other():
    among, spec = competing(PAYLOAD, WEAK), nominal("one").spec.copy()
    spec.worldbody.add_geom(name="wall", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.02, 0.5, 0.5], pos=[-0.2, 0, 0])
    walled = predictive_simulation_of(shared_replayer("one"), among, Robot.from_spec(spec), [(0, 1)])
    limits, time = limits_of(nominal("one"), 0.9, among.commands, np.array([np.inf])), np.arange(150) / 100.0
    away, at = (np.full((150, 1), angle) for angle in (-1.0, 1.0))
    assert [predicted.excess > 1.0 for predicted in walled.predict(time, [away, at], limits)] == [False, True]
    assert all(predicted.excess <= 0.0 for predicted in simulation(among).predict(time, [away, at], limits))


def test_a_simulation_that_blows_up_is_never_proposed():
    wild = competing(DRY, Change("armature", "shaft", {"I": -0.02}))  # more than the arm's own inertia
    time = np.arange(301) / 100.0
    limits = limits_of(nominal("one"), 0.9, wild.commands, np.array([np.inf]))
    [predicted] = simulation(wild).predict(time, [np.sin(time)[:, None]], limits)
    assert np.isnan(predicted.separation).all()
    assert module._cost(predicted, simulation(wild)) == np.inf


def test_rivals_of_an_explanation_come_back_and_simulate_as_explained(diagnosed):
    diagnosis = diagnosed("coulomb_friction@shaft")
    found = CompetingModels.from_json(
        json.loads(json.dumps(json_plain(diagnosis.competing_models.to_json(), "contest")))
    )
    assert [r.changes for r in found.models] == [r.changes for r in diagnosis.competing_models.models]
    assert found.models[0].label == "coulomb_friction@shaft" and len(found.models) >= 3
    assert len({r.label for r in found.models}) == len(found.models)
    problem = problem_of(diagnosis.case)
    index = diagnosis.case.indices("test")[0]
    windows, step = problem.windows_of([index]), nominal("one").model.opt.timestep / diagnosis.rivals_finer
    fine = [s.stepped(step) for s in problem.segments]
    values = encode(nominal("one"), problem.replayer.catalogue, found.models[0].changes)
    replay = problem.replayer.replay(stack([values] * len(windows)), fine, windows)
    simulated = np.concatenate([replay.sensors[k, : fine[w].rows, 0] for k, w in enumerate(windows)])
    np.testing.assert_allclose(simulated, diagnosis.predictions[index].explained[:, 0], atol=1e-5)
    assert 0.0 < found.deviations[0] < 0.01 and found.rate == pytest.approx(100.0)
