"""Laws that neither the catalogue of the package nor its library of terms holds: for the experiment `unnamed` only."""

from __future__ import annotations

from math import exp, sinh

from experiments.benchmark.generator.effect import Effect, Moment
from experiments.benchmark.generator.kind import Kind, sign
from experiments.benchmark.generator.scales import Scales


class Cable(Effect):
    """A cable that tightens past an angle: -k (q - q0)^1.5 there."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] -= self.k * max(m.q[self.at] - self.q0, 0.0) ** 1.5


class Magnet(Effect):
    """A magnet whose pull fades slowly: -A x / (1 + x^2)^2, x = (q - q0) / s."""

    def joint(self, m: Moment) -> None:
        x = (m.q[self.at] - self.q0) / self.s
        m.force[self.at] -= self.A * x / (1.0 + x * x) ** 2


class WarmingDamper(Effect):
    """Oil that thins as it warms: -c exp(-H) w, dH/dt = ((w / w_s)^2 - H) / tau."""

    def begin(self) -> None:
        self.heat = 0.0

    def joint(self, m: Moment) -> None:
        w = m.w[self.at]
        self.heat += m.dt * ((w / self.w_s) ** 2 - self.heat) / self.tau
        m.force[self.at] -= self.c * exp(-self.heat) * w


class OneWayDamper(Effect):
    """A damper with a valve: -c w one way, -ratio c w the other."""

    def joint(self, m: Moment) -> None:
        w = m.w[self.at]
        m.force[self.at] -= self.c * (w if w * self.way > 0.0 else self.share * w)


class RubberBuffer(Effect):
    """Rubber: -k s sinh(q / s)."""

    def joint(self, m: Moment) -> None:
        m.force[self.at] -= self.k * self.s * sinh(m.q[self.at] / self.s)


OWN = (
    Kind(
        "unknown_law",
        "joint",
        Cable,
        lambda s, j, z, r: _cable(s, j, z, r.uniform(0.4, 0.7)),
        accepted=("joint_limit",),
        law="tightening_cable",
    ),
    Kind(
        "unknown_law",
        "joint",
        Magnet,
        lambda s, j, z, r: {
            "A": 5.0 * s * z.torque[j],
            "q0": z.low[j] + r.uniform(0.35, 0.65) * (z.high[j] - z.low[j]),
            "s": 0.3 * z.amplitude[j],
        },
        law="fading_magnet",
    ),
    Kind(
        "unknown_law",
        "joint",
        WarmingDamper,
        lambda s, j, z, r: {"c": 2.0 * s * z.torque[j] / z.speed[j], "w_s": z.speed[j], "tau": r.uniform(0.7, 2.0)},
        accepted=("viscous_friction",),
        law="warming_damper",
    ),
    Kind(
        "unknown_law",
        "joint",
        OneWayDamper,
        lambda s, j, z, r: {"c": 1.5 * s * z.torque[j] / z.speed[j], "way": sign(r), "share": r.uniform(0.0, 0.3)},
        accepted=("viscous_friction",),
        law="one_way_damper",
    ),
    Kind(
        "unknown_law",
        "joint",
        RubberBuffer,
        lambda s, j, z, r: {"k": 0.3 * s * z.torque[j] / z.amplitude[j], "s": 0.6 * z.amplitude[j]},
        accepted=("joint_stiffness",),
        law="rubber_buffer",
    ),
)


def _cable(s: float, j: int, z: Scales, share: float) -> dict[str, float]:
    q0 = z.low[j] + share * (z.high[j] - z.low[j])
    return {"k": 3.0 * s * z.torque[j] / (z.high[j] - q0) ** 1.5, "q0": q0}
