"""Effects in motors and on the way of commands to them."""

from __future__ import annotations

from math import exp, tanh

from experiments.benchmark.generator.effect import Effect, Moment, Queue


class Weak(Effect):
    """Torque times 1 - loss."""

    def motor(self, m: Moment) -> None:
        m.torque[self.at] *= 1.0 - self.loss


class Saturated(Effect):
    """Torque within the limit."""

    def motor(self, m: Moment) -> None:
        m.torque[self.at] = min(max(m.torque[self.at], -self.limit), self.limit)


class BackEmf(Effect):
    """-k w while the motor is on (the plant switches the whole torque off with it)."""

    def motor(self, m: Moment) -> None:
        m.torque[self.at] -= self.k * m.w[self.layout.drives[self.at]]


class Fade(Effect):
    """The winding heats and weakens: tau h' = (T / T_ref)^2 - h, torque times 1 - loss min(h, 1)."""

    def begin(self) -> None:
        self.heat = 0.0

    def motor(self, m: Moment) -> None:
        share = m.torque[self.at] / self.reference
        if m.t >= 0.0:  # cold where the log begins
            self.heat += m.dt / self.tau * (share * share - self.heat)
        m.torque[self.at] *= 1.0 - self.loss * min(self.heat, 1.0)


class Delay(Effect):
    """Commands wait in a queue."""

    def begin(self) -> None:
        self.queues = {a: Queue(self.delay) for a in self.sites()}

    def command(self, m: Moment) -> None:
        for a, queue in self.queues.items():
            m.command[a] = queue.push(m.command[a], m.dt)


class Lag(Effect):
    """A first-order filter: tau x' = u - x."""

    def begin(self) -> None:
        self.state: dict[int, float] = {}

    def command(self, m: Moment) -> None:
        for a in self.sites():
            x = self.state.get(a, m.command[a])
            self.state[a] = m.command[a] + (x - m.command[a]) * exp(-m.dt / self.tau)
            m.command[a] = 0.5 * (x + self.state[a])  # held over the step


class SecondLag(Effect):
    """Two equal first-order filters, one behind the other."""

    def begin(self) -> None:
        self.states: list[float] | None = None

    def command(self, m: Moment) -> None:
        u = m.command[self.at]
        states = self.states or [u, u]
        keep = exp(-m.dt / self.tau)
        first = u + (states[0] - u) * keep
        self.states = [first, first + (states[1] - first) * keep]
        m.command[self.at] = 0.5 * (states[1] + self.states[1])


class DeadBand(Effect):
    """What the motor acts on is felt only beyond a half width (servos: the error; motors: the command)."""

    def act(self, m: Moment) -> None:
        e, h = m.error[self.at], self.half_width
        m.error[self.at] = e - h if e > h else e + h if e < -h else 0.0


class CrookedBand(DeadBand):
    """A dead band that is wider on one side."""

    def act(self, m: Moment) -> None:
        e, h, g = m.error[self.at], self.half_width, self.half_width * self.ratio
        m.error[self.at] = e - h if e > h else e + g if e < -g else 0.0


class Tied(Effect):
    """Repeats another motor's command."""

    def command(self, m: Moment) -> None:
        m.command[self.at] = m.command[int(self.source)]


class SoftLimit(Effect):
    """A torque that saturates gently: L tanh(T / L)."""

    def motor(self, m: Moment) -> None:
        m.torque[self.at] = self.limit * tanh(m.torque[self.at] / self.limit)


class Ripple(Effect):
    """A supply that sags under its own load: torque times 1 / (1 + |T| / L)."""

    def motor(self, m: Moment) -> None:
        m.torque[self.at] /= 1.0 + abs(m.torque[self.at]) / self.limit
