"""Fixtures that lanes share with the tests of physics."""

from tests.physics.conftest import lab

__all__ = ["lab"]
