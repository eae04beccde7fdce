"""A proposed motion in words, for terminals, notebooks, `advice.md` and the report."""

from __future__ import annotations

from html import escape
from typing import Any

import mujoco
import numpy as np

from estexp_jax.discovery.contest import CompetingModel
from estexp_jax.discovery.findings import TOLD
from estexp_jax.experiment_design.propose import CLEAR_SEPARATION, LIMIT_TOLERANCE, ProposedExperiment
from estexp_jax.physics.effects.units import unit_at
from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.pages import probability

_UNITS = {
    mujoco.mjtSensor.mjSENS_JOINTVEL: "rad/s",
    mujoco.mjtSensor.mjSENS_ACTUATORVEL: "rad/s",
    mujoco.mjtSensor.mjSENS_GYRO: "rad/s",
    mujoco.mjtSensor.mjSENS_VELOCIMETER: "m/s",
    mujoco.mjtSensor.mjSENS_ACCELEROMETER: "m/s^2",
    mujoco.mjtSensor.mjSENS_FORCE: "N",
    mujoco.mjtSensor.mjSENS_TOUCH: "N",
    mujoco.mjtSensor.mjSENS_TORQUE: "N m",
    mujoco.mjtSensor.mjSENS_FRAMEPOS: "m",
    mujoco.mjtSensor.mjSENS_RANGEFINDER: "m",
}
_ELSE = "Wider limits (--speed, --margin), a motor switched off, a known load or another sensor may."
_STILL = "Still record it: what is faint at each moment adds up over a recording. "


def column_of(robot: Robot, channel: str) -> str:
    """The name that a recording's column has for a channel."""
    return f"sensor.{channel}" if channel in robot.sensor_columns() else channel


def unit_of(robot: Robot, channel: str) -> str:
    """The unit of a channel; empty where it has none, or none that is known."""
    model, columns = robot.model, robot.sensor_columns()
    if channel not in columns:
        return _on_joint(robot, robot.index("joint", channel.removeprefix("qpos.")), "rad")
    sensor = int(np.searchsorted(model.sensor_adr, columns.index(channel), side="right")) - 1
    kind, target = mujoco.mjtSensor(int(model.sensor_type[sensor])), int(model.sensor_objid[sensor])
    match kind:
        case mujoco.mjtSensor.mjSENS_JOINTPOS | mujoco.mjtSensor.mjSENS_JOINTVEL:
            return _on_joint(robot, target, _UNITS.get(kind, "rad"))
        case mujoco.mjtSensor.mjSENS_JOINTACTFRC:
            return _on_joint(robot, target, "N m")
        case mujoco.mjtSensor.mjSENS_ACTUATORFRC:
            joint = robot.joint_of_actuator(target)
            return "" if joint is None else _on_joint(robot, joint, "N m")
        case _:
            return _UNITS.get(kind, "")


def _on_joint(robot: Robot, joint: int, unit: str) -> str:
    return unit_at(robot, "joint", robot.names("joint")[joint], unit)


def propose_rows(proposed: ProposedExperiment) -> list[dict[str, Any]]:
    """One row for each pair of rivals: how far apart, and the moment and sensor at which they differ most."""
    contest, shown, found = proposed.competing_models, proposed.predicted, []
    for i, j in zip(*np.triu_indices(len(contest.models), 1), strict=True):
        difference = shown.readings[j] - shown.readings[i]
        share = np.abs(_in_deviations(proposed, difference))
        row, c = np.unravel_index(int(np.argmax(share)), share.shape)
        found.append(
            {
                "rival": int(i) + 1,
                "other": int(j) + 1,
                "separation": float(shown.separation[i, j]),
                "random": float(proposed.random_separation[i, j]),
                "told_apart": bool(shown.separation[i, j] >= CLEAR_SEPARATION),
                "sensor": contest.channels[c],
                "time": float(proposed.time[row]),
                "difference": float(difference[row, c]),
                "unit": unit_of(proposed.robot, contest.channels[c]),
                "deviations": float(share[row, c]),
            }
        )
    return found


def _in_deviations(proposed: ProposedExperiment, readings: np.ndarray) -> np.ndarray:
    deviations = proposed.competing_models.deviations
    return readings / np.where(deviations > 0.0, deviations, np.inf)


def propose_summary(proposed: ProposedExperiment) -> str:
    """The rivals, and how far apart the motion brings each pair; several lines."""
    rivals = enumerate(proposed.competing_models.models, start=1)
    lines = [opening(proposed), *(f"  {n}. {rival.label} ({standing(rival)})" for n, rival in rivals)]
    lines += [propose_verdict(proposed)]
    for pair in propose_rows(proposed):
        told = f"{pair['separation']:.3g} deviations apart, by random motions {pair['random']:.3g}"
        lines.append(f"  {pair['rival']} and {pair['other']}: {told}; most at {time_of(pair)}")
    return "\n".join(lines)


def opening(proposed: ProposedExperiment) -> str:
    """How much is open."""
    left = sum(rival.open for rival in proposed.competing_models.models[1:])
    if left:
        return f"Beside the chosen explanation (1), {left} {'is' if left == 1 else 'are'} left:"
    return (
        "The recordings have settled it for the chosen explanation (1); no other has a probability of 1 %. The nearest:"
    )


def standing(rival: CompetingModel) -> str:
    """How probable it is."""
    if rival.probability >= TOLD:
        return f"probability {probability(rival.probability)}"
    return "fits as well, by more numbers" if rival.tied else "refuted already"


def propose_verdict(proposed: ProposedExperiment) -> str:
    """Whether the motion tells the rivals apart."""
    pairs = propose_rows(proposed)
    faint = [pair for pair in pairs if not pair["told_apart"]]
    if not faint:
        least = min(pair["separation"] for pair in pairs)
        return f"The proposed motion tells them apart: any two differ by {least:.3g} deviations or more."
    still = _STILL if max(pair["separation"] for pair in faint) >= 1.0 else ""
    if len(faint) == len(pairs):
        told = f"none brings two of them {CLEAR_SEPARATION:g} deviations apart"
        return f"No motion found within the limits tells them plainly apart: {told}. {still}{_ELSE}"
    same = ", ".join(f"{pair['rival']} and {pair['other']}" for pair in faint)
    told = f"tells {len(pairs) - len(faint)} of {len(pairs)} pairs apart"
    return f"The proposed motion {told}; no motion found does so plainly for {same}. {still}{_ELSE}"


def time_of(pair: dict[str, Any]) -> str:
    """When and where two rivals differ most."""
    size = f"{abs(pair['difference']):.3g} {pair['unit']}".rstrip()
    return f"{pair['time']:.2f} s, where `{pair['sensor']}` differs by {size} ({pair['deviations']:.3g} deviations)"


def propose_table(proposed: ProposedExperiment) -> str:
    """The rivals as a list, the pairs as a table."""
    found = propose_rows(proposed)
    head = "".join(f"<th>{escape(name)}</th>" for name in found[0])
    body = "".join("<tr>" + "".join(f"<td>{_cell(v)}</td>" for v in row.values()) + "</tr>" for row in found)
    rivals = "".join(f"<li>{escape(r.label)} ({standing(r)})</li>" for r in proposed.competing_models.models)
    return f"<p><b>{escape(propose_verdict(proposed))}</b></p><ol>{rivals}</ol><table><tr>{head}</tr>{body}</table>"


def _cell(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else escape(str(value))


def motion_sentence(proposed: ProposedExperiment) -> str:
    """What `commands.csv` holds, and within which limits."""
    config = proposed.config
    rate = 1.0 / (proposed.time[1] - proposed.time[0])
    return (
        f"holds {proposed.time[-1]:.3g} s of commands at {rate:.4g} Hz. Start at home, at rest. They use"
        f" at most {config.margin:.0%} of each range of command and joint, or what the recordings used already; joints"
        f" move at most {config.speed:g} times as fast as in the recordings."
    )


def caution(proposed: ProposedExperiment) -> str:
    """What is beyond a limit; empty where nothing is."""
    if proposed.predicted.excess <= LIMIT_TOLERANCE:
        return ""
    beyond = f"goes {proposed.predicted.excess:.0%} beyond a limit of joint or speed, or brings parts together,"
    told = f"{beyond} under at least one explanation"
    return f"no motion found stays within the limits; this one {told}."


def reaches(proposed: ProposedExperiment) -> list[tuple[str, str, str]]:
    """Each actuator with its lowest and highest command."""
    pairs = zip(proposed.robot.names("actuator"), proposed.commands.T, strict=True)
    return [(name, f"{column.min():.3g}", f"{column.max():.3g}") for name, column in pairs]


def signs(proposed: ProposedExperiment) -> list[dict[str, str]]:
    """What each rival alone predicts: where it is farthest from the nearest other one."""
    shown, contest = proposed.predicted.readings, proposed.competing_models
    scaled = _in_deviations(proposed, shown)
    found = []
    for n in range(len(contest.models)):
        others = np.delete(np.arange(len(contest.models)), n)
        nearest = np.abs(scaled[others] - scaled[n]).min(axis=0)
        row, c = np.unravel_index(int(np.argmax(nearest)), nearest.shape)
        unit, values = unit_of(proposed.robot, contest.channels[c]), shown[others, row, c]
        low, high = f"{values.min():.3g}", f"{values.max():.3g}"
        elsewhere = low if low == high else f"{low} to {high}"
        told = {"number": f"{n + 1}", "time": f"{proposed.time[row]:.2f}", "sensor": contest.channels[c]}
        both = {"own": f"{shown[n, row, c]:.3g} {unit}".rstrip(), "others": f"{elsewhere} {unit}".rstrip()}
        found.append({**told, **both, "label": contest.models[n].label})
    return found


def again(proposed: ProposedExperiment) -> str:
    """The command that takes the new recording in."""
    train, test = (
        " ".join(n for n, r in proposed.competing_models.recordings if r == role) for role in ("train", "test")
    )
    return f"estexp explain MODEL.xml {train} proposed.csv --test {test} --out out/again"
