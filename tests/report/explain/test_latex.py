"""Equations in LaTeX."""

import re

import pytest

from estexp_jax.physics.effects.laws.library import law_terms
from estexp_jax.physics.effects.registry import named_effects
from estexp_jax.report.explain.latex import latex


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("tau = - 0.12 |w| w + 0.3 sin(7 q + 1.2)", r"\tau = - 0.12 |\omega| \omega + 0.3 \sin(7 q + 1.2)"),
        ("tau = - 1.2e-05 w[el_bow]^2", r"\tau = - 1.2 \times 10^{-5} \omega_{\mathrm{el\_bow}}^{2}"),
        ("tau = - (1 - 1/sqrt(1 + 3 m^2)) m", r"\tau = - (1 - 1/\sqrt{1 + 3 m^{2}}) m"),
        ("tau = -F, dF/dt = k w - F / T", r"\tau = -F,\quad \mathrm{d}F/\mathrm{d}t = k \omega - F / T"),
        ("tau = m, m the motor's torque", r"\tau = m,\quad m\text{ the motor's torque}"),
        ("tau = max(q - q0, 0) w'", r"\tau = \max(q - q_{0}, 0) \omega'"),
    ],
)
def test_equations_as_they_are_written(text: str, expected: str) -> None:
    assert latex(text) == expected


@pytest.mark.parametrize("effect", [*named_effects(), *law_terms()], ids=lambda e: e.name)
def test_every_equation_can_be_written(effect) -> None:
    text = latex(effect.equation)
    assert text.count("{") == text.count("}") and "`" not in text
    outside = re.sub(r"\\(?:text|mathrm|operatorname)\{[^{}]*\}|\\[a-z]+", "", text)
    assert not re.search(r"[A-Za-z]{3,}", outside), "words stand as words"
