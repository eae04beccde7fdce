"""Effects at joints, each as a hidden state or force of its own."""

from __future__ import annotations

from math import atan, cos, exp, inf, pi, sin, sqrt

import mujoco

from experiments.benchmark.generator.effect import Effect, Moment, bristle
from experiments.benchmark.generator.robots import mass_diagonal

_PRESLIDING = 1.5e-3
"""Motion in which a bristle reaches its full force, rad or m (of a joint of ordinary size)."""


class Viscous(Effect):
    """-c w."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] -= self.c * m.w[self.at]


class Bristles(Effect):
    """LuGre friction; the level of steady sliding is what its kinds differ in."""

    def begin(self) -> None:
        self.force = 0.0

    def level(self, m: Moment) -> float:
        return self.T

    def joint(self, m: Moment) -> None:
        level = self.level(m)
        self.force = bristle(self.force, m.w[self.at], level, level / _PRESLIDING, m.dt)
        m.force[self.at] -= self.force


class Stribeck(Bristles):
    """g = T + S exp(-(w / w_s)^2)."""

    def level(self, m: Moment) -> float:
        return self.T + self.S * exp(-((m.w[self.at] / self.w_s) ** 2))


class LoadFriction(Bristles):
    """g = mu |motor torque|."""

    def level(self, m: Moment) -> float:
        return self.mu * abs(self.drive_torque(m, self.at))


class Dahl(Bristles):
    """A bristle so soft that its stretch shows: stiffness sigma."""

    def joint(self, m: Moment) -> None:
        self.force = bristle(self.force, m.w[self.at], self.T, self.sigma, m.dt)
        m.force[self.at] -= self.force


class Drag(Effect):
    """-c |w| w."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] -= self.c * abs(m.w[self.at]) * m.w[self.at]


class Spring(Effect):
    """-k (q - q0)."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] -= self.k * (m.q[self.at] - self.q0)


class Cogging(Effect):
    """A sin(n q + phase)."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] += self.A * sin(self.n * m.q[self.at] + self.phase)


class Offset(Effect):
    """A constant torque."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] += self.T


class Wall(Effect):
    """Stops of rubber: a stiff spring with a damper beyond low and high."""

    def joint(self, m: Moment) -> None:
        q, w = m.q[self.at], m.w[self.at]
        deep = q - self.high if q > self.high else q - self.low if q < self.low else 0.0
        if deep:
            push = 1500.0 * deep + 3.0 * w
            m.force[self.at] -= push if push * deep > 0.0 else 0.0


class Crosstalk(Effect):
    """g times the torque of another joint's motors."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] += self.g * self.drive_torque(m, int(self.source))


class Inertia(Effect):
    """More rotor inertia."""

    def edit(self, model: mujoco.MjModel) -> None:
        model.dof_armature[self.layout.v[self.at]] += self.I


class Jam(Effect):
    """Damping grown geometrically from its nominal value to where full torque moves 1 degree a second."""

    def edit(self, model: mujoco.MjModel) -> None:
        v = self.layout.v[self.at]
        a = self.layout.drives.index(self.at)
        torque = min(self.motors.high[a], self.motors.most[a] if not self.motors.stiffness[a] else inf)
        model.dof_damping[v] = model.dof_damping[v] ** (1.0 - self.f) * (torque * 180.0 / pi) ** self.f


class Rotor(Effect):
    """A second mass between motor and joint: I theta'' = tau - T, T = k (theta - q) + d (theta' - w)."""

    def begin(self) -> None:
        self.angle: float | None = None
        self.speed = 0.0

    def inertia(self) -> float:
        return self.I

    def passed(self, slip: float, rate: float) -> float:
        """Torque that reaches the joint from a rotor that is so far ahead of it, and so much faster."""
        return self.k * slip + self.d * rate

    def transmit(self, m: Moment) -> None:
        q, w = m.q[self.at], m.w[self.at]
        if self.angle is None:
            self.angle, self.speed = q, w
        driving = self.drive_torque(m, self.at)
        passed = self.passed(self.angle - q, self.speed - w)
        if m.dt > 0.0:
            self.speed += m.dt * (driving - passed) / self.inertia()
            self.angle += m.dt * self.speed
        m.force[self.at] += passed - driving


class Gap(Rotor):
    """Two bodies with play: the rotor touches the joint only at either end of a gap, by a stiff contact.

    The rotor's inertia is taken from the joint's armature.
    """

    def edit(self, model: mujoco.MjModel) -> None:
        v = self.layout.v[self.at]
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        own = float(model.dof_armature[v])
        self.rotor = 0.8 * own if own > 0.0 else 0.04 * float(mass_diagonal(model, data)[v])
        model.dof_armature[v] = max(own - self.rotor, 0.0)

    def inertia(self) -> float:
        return self.rotor

    def passed(self, slip: float, rate: float) -> float:
        deep = slip - self.half_gap if slip > self.half_gap else slip + self.half_gap if slip < -self.half_gap else 0.0
        if deep == 0.0:
            return 0.0
        stiffness = self.rotor * (2.0 * pi * 80.0) ** 2
        push = stiffness * deep + 0.6 * sqrt(stiffness * self.rotor) * rate
        return push if push * deep > 0.0 else 0.0


class Asymmetric(Bristles):
    """Friction that depends on the direction: g = T (1 + a sign w)."""

    def level(self, m: Moment) -> float:
        return self.T * (1.0 + self.a if m.w[self.at] >= 0.0 else 1.0 - self.a)


class Smooth(Effect):
    """T (2 / pi) atan(w / w_s): the friction law of another simulator."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] -= self.T * 2.0 / pi * atan(m.w[self.at] / self.w_s)


class Placed(Bristles):
    """Friction that grows and falls along the path: g = T (1 + a sin(n q))."""

    def level(self, m: Moment) -> float:
        return self.T * (1.0 + self.a * sin(self.n * m.q[self.at]))


class Detent(Effect):
    """A magnet: A x exp(-x^2), x = (q - q0) / s, which pulls towards q0."""

    def joint(self, m: Moment) -> None:
        x = (m.q[self.at] - self.q0) / self.s
        m.force[self.at] -= self.A * x * exp(-x * x)


class Cubic(Effect):
    """A spring that hardens: -k q^3."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] -= self.k * m.q[self.at] ** 3


class Eddy(Effect):
    """An eddy-current brake past its peak: -2 T x / (1 + x^2), x = w / w_s."""

    def joint(self, m: Moment) -> None:
        x = m.w[self.at] / self.w_s
        m.force[self.at] -= 2.0 * self.T * x / (1.0 + x * x)


class Swirl(Effect):
    """A joint that is held the more the faster another one turns: -c w_this |w_other|."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] -= self.c * m.w[self.at] * abs(m.w[int(self.source)])


class Pulse(Effect):
    """A force that comes and goes with time: T sin(2 pi f t)."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] += self.T * cos(2.0 * pi * self.f * m.t)
