"""What genomes and merged edits mean."""

import numpy as np
import pytest

from estexp_jax.physics.effects.catalogue.gravity_tilt import STEEPEST
from estexp_jax.physics.effects.changes import encode
from estexp_jax.physics.effects.registry import paper
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.estimation.genome import LENGTH, GenomeDecoder, hypothesis_key

ASLEEP = [-1.0, 0.0, 0.0, 0.0]


def genome(*genes: list[float]) -> np.ndarray:
    return np.array([*genes, *[ASLEEP] * (4 - len(genes))], float).ravel()


@pytest.mark.parametrize(
    ("gene", "place", "parameters"),
    [
        ([1.0, -1.0, -1.0, 0.3], "part_lost@upper_f", {"lost": 1.0}),
        ([1.0, -0.6, -1.0, 0.0], "body_mass@torso", {"dm": 0.75}),
        ([1.0, -0.2, 1.0, 0.0], "motor_weakness@knee_r", {"loss": 0.5}),
        ([1.0, 0.2, 1.0, 0.5], "sensor_gain@angle_r", {"gain": 0.25}),
        ([1.0, 0.6, -1.0, 1.0], "joint_jam@hip_f", {"f": 1.0}),
        ([1.0, 1.0, 0.9, -0.5], "gravity_tilt", {"angle": -STEEPEST / 2}),
    ],
)
def test_each_gene_is_one_modification(quadruped: Robot, gene: list[float], place: str, parameters: dict) -> None:
    (change,) = GenomeDecoder(quadruped).changes(genome(gene))
    assert change.place == place
    assert dict(change.parameters) == pytest.approx(parameters)


def test_dormant_genes_do_nothing(quadruped: Robot) -> None:
    assert GenomeDecoder(quadruped).changes(genome()) == ()


def test_rounding_gives_the_first_and_last_kind_half_the_chance(quadruped: Robot) -> None:
    codec, kinds = GenomeDecoder(quadruped), []
    for value in np.arange(-100, 101) / 100:
        items = codec.items(genome([1.0, value, 0.0, 0.1]))
        kinds.append(items[0][0].effect)
    counts = np.array([kinds.count(name) for name in (e.name for e in paper())])
    assert counts.sum() == 201
    assert counts[[0, 5]] == pytest.approx(counts[1:5].mean() / 2, abs=1.5)


def test_every_genome_can_be_simulated(quadruped: Robot) -> None:
    codec, random, effects = GenomeDecoder(quadruped), np.random.default_rng(0), paper()
    for _ in range(200):
        values = encode(quadruped, effects, codec.changes(random.integers(-100, 101, LENGTH) / 100))
        assert np.all(values["motor_weakness"] <= 1.0)
        assert np.all(values["sensor_gain"] >= 0.0)
        assert np.all(np.abs(values["gravity_tilt"]) <= STEEPEST + 1e-6)


def test_genomes_that_say_the_same_share_a_key(quadruped: Robot) -> None:
    codec, a, b = GenomeDecoder(quadruped), [1.0, -0.2, 1.0, 0.0], [1.0, 0.2, 1.0, 0.5]
    assert hypothesis_key(codec.items(genome(a, b))) == hypothesis_key(codec.items(genome(b, ASLEEP, a)))
