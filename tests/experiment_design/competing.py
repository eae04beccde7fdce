"""Competing models of the one-joint robot, and their predictions."""

from unittest.mock import patch

import numpy as np

from estexp_jax.discovery.competing_models import CompetingModel, CompetingModels
from estexp_jax.experiment_design import propose as module
from estexp_jax.experiment_design.predictive_simulation import PredictiveSimulation, predictive_simulation_of
from estexp_jax.experiment_design.propose import ProposeConfig, ProposedExperiment, search_experiment
from estexp_jax.experiment_design.separation import limits_of
from estexp_jax.physics.effects.changes import Change
from tests.discovery.planted import finished, nominal, shared_replayer

SMALL = ProposeConfig(duration=3.0, population=24, generations=8)
PAYLOAD = Change("body_mass", "arm", {"dm": 0.15})
WEAK = Change("motor_weakness", "servo", {"loss": 0.15 / 0.65})
"""A weak motor that holds the arm just as a strong one holds the arm with a payload."""
DRY = Change("coulomb_friction", "shaft", {"T": 0.1})
VISCOUS = Change("viscous_friction", "shaft", {"c": 0.08})
BACK_EMF = Change("back_emf", "servo", {"k": 0.08})


def competing(*changes: Change, probabilities: tuple[float, ...] | None = None, speed: float = 0.0) -> CompetingModels:
    shares = probabilities or (1.0 / len(changes),) * len(changes)
    models = tuple(CompetingModel((c,), (c,), p, 1.0) for c, p in zip(changes, shares, strict=True))
    files = (("a.csv", "train"), ("b.csv", "test"))
    noise, commands = np.array([5e-4]), np.array([[-1.6, 1.6]])
    return CompetingModels(models, ("angle",), noise, 100.0, commands, np.array([speed]), files)


def proposed(among: CompetingModels, config: ProposeConfig = SMALL) -> ProposedExperiment:
    with patch.object(module, "open_loop_simulator", lambda *_, **__: shared_replayer("one")):
        return finished(search_experiment(nominal("one"), among, 4, config))


def simulation(among: CompetingModels) -> PredictiveSimulation:
    return predictive_simulation_of(shared_replayer("one"), among).finer(4)


def separation_of(among: CompetingModels, time: np.ndarray, commands: np.ndarray) -> float:
    limits = limits_of(nominal("one"), 0.9, among.commands, np.array([np.inf]))
    [predicted] = simulation(among).predict(time, [commands], limits)
    return float(predicted.separation[0, 1])
