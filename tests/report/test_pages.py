"""Texts of pages, and the policy that allows one script only."""

import base64
import hashlib

import pytest
from matplotlib.figure import Figure

from estexp_jax.report.pages import capital, finite, format_number, image, metres, percent, policy, probability


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (format_number(0.123456), "0.123"),
        (format_number("a text"), "a text"),
        (format_number(None), "–"),
        (format_number(float("nan")), "–"),
        (percent(0.12345), "12.3 %"),
        (percent(0.12345, 0), "12 %"),
        (percent(None), "–"),
        (metres(1.234), "1.23 m"),
        (metres(float("nan")), "an unknown distance"),
        (probability(0.995), "> 99 %"),
        (probability(0.005), "< 1 %"),
        (probability(0.5), "50 %"),
        (capital("the joint"), "The joint"),
        (capital(""), ""),
    ],
)
def test_values_as_texts(text, expected):
    assert text == expected


def test_only_numbers_are_finite():
    assert finite(1) and not finite(None) and not finite(float("inf"))


def test_the_policy_names_the_script_by_its_hash():
    digest = base64.b64encode(hashlib.sha256(b"let x = 1").digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy("let x = 1") and "default-src 'none'" in policy("")


def test_equal_figures_are_equal_images():
    first, second = (image(Figure(figsize=(1, 1))) for _ in range(2))
    assert first == second and first.startswith("data:image/svg+xml;base64,")
