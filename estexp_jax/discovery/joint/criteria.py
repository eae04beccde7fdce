"""Every number that decides in the joint sparse fit, with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class SelectionCriteria:
    """What the joint sparse fit decides by.

    Attributes:
        expected_effects: so many effects are expected to be missing, of all that might be: prior odds of each.
            Convention: real machines of the board lack one to two for each joint.
        model_error: standard deviation of a value of the model, as a share of it. Convention: data sheets and CAD.
        torque_floor: torque that no simulator gets right, as a share of a joint's root mean square torque. Measured:
            what regressions of logged torques leave on the machines' board, 2 to 5 %.
        least_share: root mean square of an effect's torque below which it is not reported, as a share of its joint's;
            as `torque_floor`, which it cannot be told from.
        short_window: length of the windows of the torque balance, s. Measured: shorter ones are noise at 50 rows a
            second, longer ones no longer linear where gravity is not held.
        memory: time before a window along which hidden variables of effects are rolled, s. Convention: gears, belts and
            controllers forget sooner; what does not, like heat, is left to other strategies.
        correlation_time: how long a model error lasts, s, so that there is one independent datum of a channel in each
            such time. Measured: two of half-second windows on the machines' board.
        native_odds: prior odds of an effect that MJCF has a value for, which the model leaves at nothing, nats.
            Convention: most models leave friction and rotor inertia out, so it decides between equals.
        most_alike: probability that an effect is missing at a joint where it is at all of the robot's others, at most.
            Convention: so that recordings can still speak against it.
        chance: probability that a held-out gain is less than what has to exceed its price. Convention.
        kept_errors: an effect that all readings call for goes where its held-out gain is at most so many standard
            errors: stretches need not prove it once more, but they may not contradict it. Convention.
        wrong_value: a value of the model that is off by more than so many times `model_error` is a finding. Convention.
        interval: standard deviations to either side of a value that are told with it, which hold 90 % of a normal
            distribution; a value of the model that may be as the model has it is no finding. Convention.
        freedom: degrees of freedom of the error of a window, by Student's t. Convention of robust regression.
        near: root mean square error, as a share of a reading's range, up to which windows may be lengthened: beyond,
            the simulator is no longer linear in what it lacks. Measured: on the machines' board.
        fewest_effects: where something is left, the joint fit is told if so many effects are missing; with fewer the
            stepwise search is asked, which knows more forms of each, and laws. Convention: it adds up to five effects,
            one at a time, and a UR5e takes it 13 minutes.
        least_of_test: share of the excess error of test recordings that an explanation takes off, where what it leaves
            there is more than training recordings lacked in all; with surely less, it is told with even odds at most.
            Convention: most of it.
        clip: residuals count as at most so many standard deviations. Convention of robust regression.
    """

    expected_effects: float = 6.0
    model_error: float = 0.03
    torque_floor: float = 0.03
    least_share: float = 0.03
    short_window: float = 0.05
    memory: float = 0.3
    correlation_time: float = 0.25
    native_odds: float = 3.0
    most_alike: float = 0.95
    chance: float = 0.05
    kept_errors: float = 0.0
    wrong_value: float = 3.0
    interval: float = 1.645
    freedom: float = 4.0
    near: float = 0.05
    fewest_effects: int = 3
    least_of_test: float = 0.5
    clip: float = 3.0
