"""The comparison itself: residuals are errors, gaps count nothing, explosions count a bounded much."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import parameters_only
from estexp_jax.discovery.recorded import deviations
from estexp_jax.discovery.uncertain_starts import directions, other_commands, other_starts, whitened
from estexp_jax.estimation.windows import windows_of
from tests.discovery.planted import CASES, CONFIG, Plant, case_of, problem_of


@pytest.fixture(scope="module")
def setting():
    robot, plant, seed = CASES["coulomb_friction@shaft"]
    case = case_of(robot, plant, seed)
    case.recordings[0].sensor[20:30] = np.nan
    problem = problem_of(case)
    hypothesis = parameters_only(case.robot, problem.replayer.catalogue)
    return case, problem, (hypothesis, hypothesis.start())


def at(problem, segments):
    cut = problem.replays.cut._replace(whole=tuple(segments))
    return replace(problem, replays=replace(problem.replays, cut=cut))


def test_residuals_are_differences_in_deviations_of_noise(setting):
    case, problem, member = setting
    windows = problem.windows_of(case.indices("train"))
    assert len(windows) == 6
    difference = problem.simulated([member], windows)[0] - problem.recorded.readings(windows)
    difference[[problem.segments[w].first == 0 for w in windows], 0] = np.nan
    owner = [problem.segments[w].recording for w in windows]
    found = problem.residuals([member], windows)[0].reshape(difference.shape)
    expected = difference / problem.noise[owner][:, None] / np.sqrt(np.isfinite(difference).sum())
    np.testing.assert_allclose(found, np.nan_to_num(expected), rtol=1e-3, atol=1e-6)


def test_a_small_motion_does_not_outweigh_all_large_ones(setting):
    """No noise, and one recording of four moves a hundredth as far: it counts as if it moved as far as is usual."""
    case, problem, _ = setting
    wave = np.sin(np.arange(251) / 40.0)[:, None]
    sizes, roles = (1.0, 0.01, 1.5, 2.0, 0.01), ("train", "train", "train", "train", "test")
    recordings = [replace(case.recordings[0], sensor=s * wave, role=r) for s, r in zip(sizes, roles, strict=True)]
    found = deviations(problem.channels, recordings)[:, 0] / np.ptp(wave)
    np.testing.assert_allclose(found / 5e-4, [1.25, 1.25, 1.5, 2.0, 1.25], rtol=0.01)
    unseen = [replace(r, sensor=np.full_like(r.sensor, np.nan)) if r.role == "train" else r for r in recordings]
    assert np.isnan(deviations(problem.channels, unseen)[:-1]).all(), "a channel that only the test recording has"
    assert deviations(problem.channels, unseen)[-1, 0] > 0.0


def test_the_error_is_the_root_of_mean_squared_shares(setting):
    case, problem, member = setting
    windows = problem.windows_of([0])
    assert problem.error(member, windows) == pytest.approx(
        np.sqrt(np.nanmean(problem.recorded.shares_of(problem.simulated([member], windows)[0], windows)))
    )


def test_a_gap_counts_nothing_and_is_no_longer_compared(setting):
    case, problem, member = setting
    first = problem.residuals([member], problem.windows_of([0]))[0, 0]
    assert np.all(first[:1] == 0.0) and np.all(first[20:30] == 0.0) and np.all(first[31:60] != 0.0)


def test_a_simulation_that_blew_up_is_worse_than_any_but_finite(setting):
    case, problem, (hypothesis, start) = setting
    windows = problem.windows_of(case.indices("train"))
    bad = np.where([f.effect == "body_mass" for f in hypothesis.free], np.nan, start)
    residuals = problem.residuals([(hypothesis, start), (hypothesis, bad)], windows).astype(float)
    assert np.isfinite(residuals).all()
    good, blown = np.sqrt(np.sum(residuals**2, axis=(1, 2)))
    assert np.isfinite(blown) and blown > 20.0 * good


def test_the_correction_makes_a_coarse_step_as_good_as_a_fine_one(setting):
    case, problem, member = setting
    windows = problem.windows_of([0, 1])
    finest = at(problem, windows_of(case.robots, problem.recordings, 1.25, 40)).simulated([member], windows)
    off = [np.nanmax(np.abs(p.simulated([member], windows) - finest)) for p in (problem, problem.about(member))]
    assert off[0] > 1e-3
    assert off[1] < 0.15 * off[0]


def test_steps_are_counted(setting):
    case, problem, member = setting
    counted = replace(problem, replays=replace(problem.replays, counted=[0]))
    counted.simulated([member, member], counted.windows_of([0]))
    assert counted.counted == [2 * sum(counted.segments[w].steps.n_steps for w in counted.windows_of([0]))]


def test_what_another_start_would_explain_counts_little(setting):
    case, problem, member = setting
    windows = problem.windows_of(case.indices("train"))
    about = problem.about(member)
    shifted = other_starts(problem.replayer.robot.model, problem.segments)
    assert len(shifted) == 2  # position and speed of one joint, mixed
    for segments in shifted:
        sizes = []
        for p in (replace(about, doubt=None), about):
            change = at(p, segments).residuals([member], windows) - p.residuals([member], windows)
            sizes.append(np.sqrt(np.square(change[0]).sum(axis=1) * p.recorded.samples(windows).sum()))
        size, left = sizes
        np.testing.assert_array_less(left, 1.2)
        assert np.all(left < size)


@pytest.mark.slow
def test_a_block_at_rest_whose_first_speed_is_uncertain_is_no_mismatch():
    """It leaves its place by more than a simulation that blew up is bounded to: ten times the range of its readings."""
    case = case_of("idle", Plant(), 732, trains=4, tests=0, bits=14, length=5.0)
    problem = problem_of(case, replace(CONFIG, window=2.5, effects=("viscous_friction",)))
    hypothesis = parameters_only(case.robot, problem.replayer.catalogue)
    member, windows = (hypothesis, hypothesis.start()), problem.fitted
    off = np.abs(problem.simulated([member], windows)[0] - problem.recorded.compared(windows))[..., 1]
    assert np.any(np.nanmax(off, axis=1) > 10.0 * problem.recorded.span(windows)[:, 1])
    left = problem.about(member).residuals([member], windows).reshape(*off.shape, 2)[..., 1]
    assert np.sum(left**2) < 1.2


def test_what_another_command_in_a_lost_row_would_explain_counts_little(setting):
    case, _, (hypothesis, start) = setting
    first = case.recordings[0]
    columns = ("time", "ctrl", "enable", "sensor", "qpos", "qvel")
    thin = {name: np.delete(getattr(first, name), [40, 190], axis=0) for name in columns}
    problem = problem_of(replace(case, recordings=(replace(first, **thin), *case.recordings[1:])))
    about, member = problem.about((hypothesis, start)), (hypothesis, start)
    [copies] = other_commands(problem.recordings, problem.segments)
    assert [s is not None for s in copies] == [s.recording == 0 for s in problem.segments]
    lost = np.array([i for i, s in enumerate(copies) if s is not None])
    there = [c or s for c, s in zip(copies, problem.segments, strict=True)]
    size, left = (
        np.square(at(p, there).residuals([member], lost) - p.residuals([member], lost))[0].sum(axis=1)
        for p in (replace(about, doubt=None), about)
    )
    size, left = (x * problem.recorded.samples(lost).sum() for x in (size, left))
    assert np.all(size > 4.0) and np.all(left < 1.5)


def test_whitening_makes_noise_with_uncertain_starts_white():
    rng = np.random.default_rng(75)
    effect = 5.0 * rng.standard_normal((1, 30, 2))
    draws = rng.standard_normal((4000, 1, 30)) + np.einsum("wsn,mwn->mws", effect, rng.standard_normal((4000, 1, 2)))
    basis, kept = directions(effect)
    white = whitened(draws.astype(np.float32), basis, kept)[:, 0]
    assert np.cov(white.T) == pytest.approx(np.eye(30), abs=0.12)


def test_windows_that_are_not_fitted_may_have_more_rows(setting):
    case, _, (hypothesis, start) = setting
    first = case.recordings[0]
    thin = {name: getattr(first, name)[::2] for name in ("time", "ctrl", "enable", "sensor", "qpos", "qvel")}
    problem = problem_of(replace(case, recordings=(replace(first, **thin), *case.recordings[1:])))
    few = replace(problem, most=1)
    assert few.fitted.tolist() == [0] and few.segments[0].rows < max(s.rows for s in few.segments)
    about = few.about((hypothesis, start)).heard((hypothesis, start)).corrected([(hypothesis, start)])
    plain, found = (p.residuals([(hypothesis, start)], problem.trained)[0] for p in (problem, about))
    assert np.isfinite(found).all() and found.shape == plain.shape


def test_of_many_windows_so_many_are_fitted_evenly_spread(setting):
    _, problem, _ = setting
    for most in (1, 2, 4, 5, 6, 48):
        found = replace(problem, most=most).fitted
        assert len(found) == min(most, len(problem.trained)) and len(set(found.tolist())) == len(found)
    assert replace(problem, most=4).fitted.tolist() == [problem.trained[i] for i in (0, 2, 3, 5)]
