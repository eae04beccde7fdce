"""Recorded, nominal and explained robot in one scene."""

import io
from dataclasses import replace

import numpy as np
from PIL import Image

from estexp_jax.report.explain.ghosts import angles_of, ghosts_of, postures


def test_ghosts_stand_as_recorded_and_predicted(arm_diagnosis) -> None:
    (prediction,) = arm_diagnosis.predictions
    angles = angles_of(arm_diagnosis.case.robot, prediction)
    assert angles == {0: 1, 1: 2}
    real, nominal, explained = postures(arm_diagnosis, prediction, angles, np.array([30]))[0]
    np.testing.assert_allclose(real, prediction.recorded[30, 1:])
    np.testing.assert_allclose(nominal, 0.2 * real)
    np.testing.assert_allclose(explained, real)


def test_ghosts_are_drawn(arm_diagnosis, renderer: None) -> None:
    drawn = ghosts_of(arm_diagnosis)
    assert drawn is not None
    content, told = drawn
    assert told.startswith("t.csv, line by line at 0.") and told.endswith(" s.")
    picture = np.asarray(Image.open(io.BytesIO(content))).astype(int)
    assert picture.shape[0] % 344 == 0 and picture.shape[1] == 2 * 420
    orange = (picture[..., 0] - picture[..., 2]) > 60
    assert orange.any()
    arm_diagnosis.predictions[0] = replace(arm_diagnosis.predictions[0], channels=("sensor_0", "sensor_0", "sensor_0"))
    assert ghosts_of(arm_diagnosis) is None
