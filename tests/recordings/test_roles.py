"""Something to fit and something to test on, whatever the user gave."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.roles import assign_roles, without_healthy


def _recording(name, role="train", rows=11):
    column = np.arange(rows, dtype=float)[:, None]
    return Recording(name, column[:, 0] / 10, column, column, column, column, column, role)


def test_given_roles_stay():
    given = [_recording("a.csv", "test"), _recording("b.csv")]
    assert assign_roles(given) == tuple(given)


def test_without_a_test_the_last_one_is_kept_back():
    roles = [(r.name, r.role) for r in assign_roles([_recording("a.csv"), _recording("b.csv"), _recording("c.csv")])]
    assert roles == [("a.csv", "train"), ("b.csv", "train"), ("c.csv", "test")]


def test_a_lone_recording_is_cut_by_time():
    train, test = assign_roles([_recording("a.log.csv")])
    assert (train.name, train.role, test.name, test.role) == ("a.log.csv", "train", "a.log_last30.csv", "test")
    np.testing.assert_allclose(train.time, np.arange(8) / 10)
    np.testing.assert_allclose(test.time, [0.8, 0.9, 1.0])
    for name in ("ctrl", "enable", "sensor", "qpos", "qvel"):
        np.testing.assert_array_equal(getattr(test, name)[:, 0], [8.0, 9.0, 10.0])
    assert "30%" in train.notes[0]


def test_what_cannot_be_assigned():
    with pytest.raises(InputError, match="no recordings"):
        assign_roles([])
    with pytest.raises(InputError, match=r"every recording is kept for the test: a\.csv, b\.csv"):
        assign_roles([_recording("a.csv", "test"), _recording("b.csv", "test")])
    with pytest.raises(InputError, match=r"a\.csv, a\.npz: two recordings are called 'a'"):
        assign_roles([_recording("a.csv"), _recording("a.npz")])
    with pytest.raises(InputError, match=r"a\.csv: 3 rows are too few"):
        assign_roles([_recording("a.csv", rows=3)])


def test_recordings_of_the_healthy_robot_have_roles_of_their_own():
    given = [
        _recording(f"{name}.csv", role)
        for name, role in zip("abcd", ["healthy", "train", "healthy", "test"], strict=True)
    ]
    now, healthy = without_healthy(given)
    assert [(r.name, r.role) for r in now] == [("b.csv", "train"), ("d.csv", "test")]
    assert [(r.name, r.role) for r in healthy] == [("a.csv", "train"), ("c.csv", "test")]
    assert without_healthy(given[1:2])[1] == ()
    with pytest.raises(InputError, match="every recording is of the healthy robot: a.csv"):
        without_healthy(given[:1])
    with pytest.raises(InputError, match="two recordings are called 'a'"):
        without_healthy([*given, _recording("a.parquet")])
