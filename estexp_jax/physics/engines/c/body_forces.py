"""A body force where it is at work in a chunk's lanes."""

from __future__ import annotations

from typing import final

import numpy as np

from estexp_jax.physics.effects.base import BodyForce
from estexp_jax.physics.engines.c.instances import Instances
from estexp_jax.physics.engines.c.laws import body_program
from estexp_jax.physics.model.robot import Robot


@final
class ActingBodyForce:
    """A body force where it is at work.

    Attributes:
        lane: (n,) of its instances.
    """

    def __init__(self, e: BodyForce, robot: Robot, there: Instances) -> None:
        """With its instances."""
        self.lane = there.lane
        self._body = np.array([robot.index("body", site) for site in e.sites(robot)])[there.site]
        self._law = body_program(e).bound(there.p, len(there.lane))

    def act(self, place: np.ndarray, pull: np.ndarray) -> None:
        """Add its forces.

        Args:
            place: (lanes, bodies, 3) centres of mass, m.
            pull: (lanes, bodies, 6) external forces and torques, changed in place.
        """
        for axis, force in enumerate(self._law(place[self.lane, self._body].T)):
            pull[self.lane, self._body, axis] += force
