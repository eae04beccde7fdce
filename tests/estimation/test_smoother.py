"""The smoother on motions that are known: near the truth, as near as it says, whatever the clock."""

import numpy as np
import pytest

from estexp_jax.estimation.smoother import smooth

NOISE = 5e-4


def motion(time):
    """A sway, and a jolting servo."""
    sway = np.stack([0.8 * np.sin(3.0 * time), 2.4 * np.cos(3.0 * time)])
    late = np.maximum(time[:, None] - np.arange(0.5, 8.0, 1.0), 0.0)
    sign = np.where(np.arange(late.shape[1]) % 2, -1.0, 1.0)
    jolts = np.stack(
        [(sign * (1 - np.exp(-12 * late) * (1 + 12 * late))).sum(1), (sign * 144 * late * np.exp(-12 * late)).sum(1)]
    )
    return np.stack([sway[0], jolts[0]], axis=1), np.stack([sway[1], jolts[1]], axis=1)


def read(time, seed, lost=0.0):
    rng = np.random.default_rng(seed)
    value, slope = motion(time)
    samples = value + NOISE * rng.standard_normal(value.shape)
    samples[rng.random(value.shape) < lost] = np.nan
    return value, slope, samples, np.full_like(samples, np.nan)


CLOCKS = {
    "even": np.arange(1600) / 200.0,
    "uneven": np.cumsum(np.random.default_rng(51).uniform(0.002, 0.008, 1600)),
    "slow": np.arange(400) / 50.0,
}


@pytest.mark.parametrize(("clock", "most"), [("even", (0.02, 0.12)), ("uneven", (0.02, 0.12)), ("slow", (0.04, 0.5))])
def test_values_and_slopes_are_near_the_truth_and_as_near_as_it_says(clock, most):
    value, slope, samples, nothing = read(CLOCKS[clock], 52)
    track = smooth(CLOCKS[clock], samples, np.full(2, NOISE), nothing, np.ones(2))
    off = np.stack([track.value - value, track.slope - slope], axis=2)
    assert np.all(np.sqrt(np.mean(off[..., 0] ** 2, axis=0)) < 1.1 * NOISE)
    assert np.all(np.sqrt(np.mean(off[..., 1] ** 2, axis=0)) < most)
    surprise = np.einsum("rni,rnij,rnj->rn", off, np.linalg.inv(track.covariance), off) / 2.0
    assert np.all((np.median(surprise, axis=0) > 0.3) & (np.median(surprise, axis=0) < 1.2))  # 0.69 if exact
    assert np.all(surprise.mean(axis=0) < 2.5)


def test_a_jolt_is_smoothed_over_fewer_rows_than_a_sway():
    value, slope, samples, nothing = read(CLOCKS["even"], 53)
    track = smooth(CLOCKS["even"], samples, np.full(2, NOISE), nothing, np.ones(2))
    doubt = np.sqrt(track.covariance[..., 1, 1]).mean(axis=0)
    assert doubt[1] > 1.5 * doubt[0]


def test_gaps_widen_the_doubt_and_measured_slopes_narrow_it():
    time = CLOCKS["even"]
    value, slope, samples, nothing = read(time, 54, lost=0.1)
    samples[600:640] = np.nan
    alone = smooth(time, samples, np.full(2, NOISE), nothing, np.ones(2))
    doubt = np.sqrt(alone.covariance[..., 0, 0])
    assert np.all(doubt[620] > 3.0 * np.median(doubt, axis=0))
    assert np.all(np.abs(alone.value - value)[600:640] < 6.0 * doubt[600:640] + 1e-3)
    measured = slope + 0.01 * np.random.default_rng(55).standard_normal(slope.shape)
    both = smooth(time, samples, np.full(2, NOISE), measured, np.full(2, 0.01))
    assert np.all(np.median(both.covariance[..., 1, 1], axis=0) < np.median(alone.covariance[..., 1, 1], axis=0))
    assert np.all(np.sqrt(np.mean((both.slope - slope) ** 2, axis=0)) < 0.01)


def test_without_noise_it_passes_through_the_samples():
    value, slope, _, nothing = read(CLOCKS["even"], 56)
    track = smooth(CLOCKS["even"], value, np.zeros(2), nothing, np.ones(2))
    assert np.max(np.abs(track.value - value)) < 1e-5
    assert np.sqrt(np.mean((track.slope - slope) ** 2)) < 0.02
