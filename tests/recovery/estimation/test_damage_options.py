"""What the set search chooses from."""

from estexp_jax.physics.effects.changes import encode
from estexp_jax.physics.effects.registry import damages, paper
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.estimation.damage_options import damage_options
from estexp_jax.recovery.estimation.damage_sites import change_of


def test_every_option_can_be_simulated(quadruped: Robot) -> None:
    found, effects = damage_options(quadruped, "full"), damages()
    assert {place.effect for place in found.places} == {e.name for e in damages()}
    for index, option in enumerate(found.options):
        for amount in option.coarse:
            [(place, same)] = found.items(((index, amount),))
            encode(quadruped, effects, [change_of(quadruped, place, same)])


def test_the_papers_catalogue_is_its_six_modifications_with_growing_masses(quadruped: Robot) -> None:
    found = damage_options(quadruped, "paper")
    assert {place.effect for place in found.places} == {e.name for e in paper()}
    masses = [o for p, o in zip(found.places, found.options, strict=True) if p.effect == "body_mass"]
    assert all(option.low == 0.0 for option in masses)
    assert damage_options(quadruped, "full").places[: len(found.places)] == found.places
