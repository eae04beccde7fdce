"""The report of a proposed motion as one HTML file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from estexp_jax.discovery.competing_models import CompetingModel
from estexp_jax.experiment_design.propose import ProposedExperiment
from estexp_jax.physics.effects.registry import effect
from estexp_jax.report.pages import capital, format_number, image, render_page
from estexp_jax.report.propose.figures import figure_commands, figure_predictions
from estexp_jax.report.propose.text import (
    caution,
    command_ranges,
    deviation_sentence,
    distinguishing_readings,
    motion_sentence,
    next_command,
    open_summary,
    propose_rows,
    propose_verdict,
    rival_status,
)


def propose_page(proposed: ProposedExperiment) -> str:
    """HTML of a proposal."""
    return render_page(
        "propose/page.html",
        model=Path(proposed.robot.source).name,
        headline=propose_headline(proposed),
        verdict=propose_verdict(proposed),
        summary=open_summary(proposed),
        explanations=[_explanation(n, rival) for n, rival in enumerate(proposed.competing_models.models, start=1)],
        motion=motion_sentence(proposed),
        caution=caution(proposed),
        ranges=command_ranges(proposed),
        deviation=deviation_sentence(),
        pairs=[_pair(pair) for pair in propose_rows(proposed)],
        readings=distinguishing_readings(proposed),
        command=next_command(proposed),
        commands=image(figure_commands(proposed)),
        predictions=image(figure_predictions(proposed)),
        cost=f"{proposed.robot_steps / 1e6:.3g} million robot steps; seed {proposed.config.seed}; "
        f"engine {proposed.engine[0]}.",
    )


def propose_headline(proposed: ProposedExperiment) -> str:
    """Whether the motion distinguishes the explanations, in a sentence."""
    pairs = propose_rows(proposed)
    plain = sum(pair["told_apart"] for pair in pairs)
    if plain == len(pairs):
        return "Record this motion: it tells the explanations apart."
    if plain:
        return f"Record this motion: it tells {plain} of {len(pairs)} pairs of explanations apart."
    return "No motion found within the limits tells the explanations plainly apart."


def _explanation(place: int, rival: CompetingModel) -> dict[str, Any]:
    return {
        "number": place,
        "label": rival.label,
        "sentence": capital(rival.sentence),
        "status": capital(rival_status(rival)),
        "refuted": not rival.open,
        "equations": list(dict.fromkeys(effect(claim.effect).equation for claim in rival.claims)),
    }


def _pair(pair: dict[str, Any]) -> dict[str, Any]:
    return {
        "pair": f"{pair['rival']}, {pair['other']}",
        "separation": format_number(pair["separation"]),
        "random": format_number(pair["random"]),
        "where": f"{pair['sensor']} at {pair['time']:.2f} s: {abs(pair['difference']):.2g} {pair['unit']}".rstrip(),
        "distinguished": pair["told_apart"],
    }
