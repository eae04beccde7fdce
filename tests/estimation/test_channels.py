"""Which readings are compared, and what they are scaled by."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.estimation.channels import channel_ranges, channels_of
from estexp_jax.physics.engines.open_loop import OpenLoopRollout

TIME = np.arange(40) / 10.0


def test_held_sensors_come_first_then_encoders_without_a_sensor(mixed, blank):
    a = blank(TIME, sensor={1: TIME, 3: TIME}, qpos={0: TIME, 1: TIME})
    b = blank(TIME, sensor={4: 2.0 * TIME})
    channels = channels_of(mixed, [a, b])
    assert channels.names == ("acc.1", "angle", "speed", "qpos.slide")
    assert channels.recorded(a)[3] == pytest.approx([0.3, 0.3, np.nan, 0.3], nan_ok=True)


def test_an_encoder_column_counts_where_its_sensor_holds_nothing(mixed, blank):
    assert channels_of(mixed, [blank(TIME, qpos={0: TIME})]).names == ("qpos.hinge",)


def test_simulated_channels_are_those_recorded(mixed, blank):
    channels = channels_of(mixed, [blank(TIME, sensor={4: TIME}, qpos={0: TIME})])
    sensors = np.arange(2 * 3 * 5.0).reshape(2, 3, 5)
    qpos = -np.arange(2 * 3 * 9.0).reshape(2, 3, 9)
    simulated = channels.simulated(OpenLoopRollout(sensors, qpos, np.zeros((2, 3, 8))))
    assert simulated[1, 2].tolist() == [sensors[1, 2, 4], qpos[1, 2, 0]]


def test_no_reading_at_all_is_the_users_mistake(mixed, blank):
    with pytest.raises(InputError, match="no reading"):
        channels_of(mixed, [blank(TIME, qvel={0: TIME})])


def test_spans_are_ranges_and_still_channels_have_their_size(mixed, blank):
    moving = np.where(np.arange(40) == 5, np.nan, 3.0 * TIME - 1.0)
    recording = blank(TIME, sensor={0: moving, 1: np.full(40, -4.0), 2: np.zeros(40)})
    other = blank(TIME, sensor={3: TIME})
    channels = channels_of(mixed, [recording, other])
    assert channel_ranges(channels, recording) == pytest.approx([11.7, 4.0, 1.0, np.nan], nan_ok=True)
