"""What acts during a step does what its equation says, stably: against laws written anew on the C engine."""

from functools import cache

import numpy as np
import pytest

from estexp_jax.physics.effects.base import BodyForce, CommandLaw, Term
from estexp_jax.physics.effects.changes import Change, encode, parse_change, stack
from estexp_jax.physics.effects.registry import named_effects
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, Window, window_of
from tests.physics.effects.twins import TWINS, XML, Twin, simulated

ACTING = tuple(e for e in named_effects() if isinstance(e, Term | CommandLaw | BodyForce))
PERIOD, ROWS = 0.01, 80
ROBOT = Robot.from_string(XML, "twin.xml")
ENGINES = ("lanes", "c")


@cache
def simulator(engine: str) -> OpenLoopSimulator:
    return open_loop_simulator(ROBOT, ACTING, [ROBOT], width=len(TWINS) + 1, block=320, engine=engine)


def commands() -> np.ndarray:
    """Steps for both motors, some large enough to saturate the servo."""
    rng = np.random.default_rng(64)
    return np.repeat(rng.uniform(-0.9, 0.9, (8, 2)), ROWS // 8, axis=0)


def switches() -> np.ndarray:
    """Both motors off for a while."""
    on = np.ones((ROWS, 2))
    on[40:50] = 0.0
    return on


def part(timestep: float) -> Window:
    time, nothing = PERIOD * np.arange(ROWS), np.full((ROWS, 2), np.nan)
    log = Recording("twin.csv", time, commands(), switches(), nothing, nothing, nothing)
    return window_of([log], 0, (0, ROWS - 1), timestep, InitialState(np.zeros(2), np.zeros(2)))


@pytest.fixture(autouse=True, params=ENGINES)
def engine(request: pytest.FixtureRequest) -> str:
    """Every test is run with each engine."""
    return request.param


@cache
def ours(timestep: float, engine: str) -> dict[str, np.ndarray]:
    """Positions (rows, 2) with each planted effect, and nominal ones, in one batch."""
    sets = {"nominal": [], **{text: [parse_change(text, ROBOT)] for text in TWINS}}
    values = stack([encode(ROBOT, ACTING, changes) for changes in sets.values()])
    replay = simulator(engine).replay(values, [part(timestep)], np.zeros(len(sets), int))
    return dict(zip(sets, replay.qpos, strict=True))


def error(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.sqrt(np.mean((a - b) ** 2)))


def test_without_a_law_the_twin_is_the_nominal_robot(engine: str) -> None:
    twin = simulated(Twin, {}, commands(), switches(), PERIOD)
    assert error(ours(0.00025, engine)["nominal"], twin) < 2e-3
    assert np.abs(twin).max() > 0.5


@pytest.mark.parametrize("text", TWINS)
def test_it_does_what_its_equation_says(text: str, engine: str) -> None:
    """Both at steps of a tenth of a millisecond or so, where all ways to integrate a law agree."""
    kind, share = TWINS[text]
    twin = simulated(kind, parse_change(text, ROBOT).values, commands(), switches(), PERIOD)
    fine = ours(0.00025, engine)
    size = error(fine["nominal"], fine[text])
    assert size > 0.01, "the effect is seen"
    assert error(fine[text], twin) < share * size + 1e-3


@pytest.mark.parametrize("text", TWINS)
def test_the_nominal_step_is_short_enough(text: str, engine: str) -> None:
    """At 2.5 ms, what a law changes is as at a tenth of it, but for what the step changes in the nominal robot."""
    fine, coarse = ours(0.00025, engine), ours(0.0025, engine)
    change = [x[text] - x["nominal"] for x in (fine, coarse)]
    share = 0.4 if text.startswith("backlash") else 0.15  # a blow falls between two steps
    assert error(*change) < share * error(change[0], np.zeros(2)) + 2e-3


def corners() -> list[Change]:
    """Every effect at every site with its parameters at their bounds, all together low, high, and in turns."""
    found = []
    for e in ACTING:
        for site in e.sites(ROBOT):
            bounds = e.bounds(ROBOT, site)
            for turn in range(4):
                picks = [bounds[i][(turn >> (i % 2)) & 1] for i in range(len(bounds))]
                found.append(Change(e.name, site, {p.name: v for p, v in zip(e.parameters, picks, strict=True)}))
    return found


def test_extreme_parameters_leave_everything_finite(engine: str) -> None:
    sets = corners()
    values = stack([encode(ROBOT, ACTING, [change]) for change in sets])
    replay = simulator(engine).replay(values, [part(0.0025)], np.zeros(len(sets), int))
    wild = [c.place for c, q, w in zip(sets, replay.qpos, replay.qvel, strict=True) if not (_sound(q) and _sound(w))]
    assert wild == []


def _sound(x: np.ndarray) -> bool:
    return bool(np.isfinite(x).all() and np.abs(x).max() < 1e4)


def test_every_acting_effect_has_a_twin() -> None:
    assert {parse_change(text, ROBOT).effect for text in TWINS} == {e.name for e in ACTING if e.sites(ROBOT)}


@pytest.mark.parametrize("text", ["nominal", *TWINS])
def test_it_does_the_same_whatever_others_have(text: str, engine: str) -> None:
    """What no robot of a chunk has is skipped; here nothing is, in a chunk of all, and all but one law alone."""
    changes = [] if text == "nominal" else [parse_change(text, ROBOT)]
    alone = simulator(engine).replay(stack([encode(ROBOT, ACTING, changes)]), [part(0.0025)], np.zeros(1, int))
    np.testing.assert_allclose(alone.qpos[0], ours(0.0025, engine)[text], atol=1e-5)
