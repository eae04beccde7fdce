"""Every law has a text, which says what the law says."""

import numpy as np
import pytest

from estexp_jax.physics.effects.base import BodyForce, CommandLaw, Term
from estexp_jax.physics.effects.registry import effect, every
from estexp_jax.physics.engines.standalone.law_text import body_text, command_text, rest_text, term_text


def _function(text: str, name: str):
    space = {}
    exec(compile(text, name, "exec"), space)  # noqa: S102 (text made here)
    return space[name]


def test_every_law_of_the_catalogue_has_a_text():
    for e in every():
        if isinstance(e, Term):
            assert callable(_function(term_text(e, "law"), "law"))
        elif isinstance(e, CommandLaw):
            assert callable(_function(command_text(e, "law"), "law"))
        elif isinstance(e, BodyForce):
            assert callable(_function(body_text(e, "law"), "law"))
        if isinstance(e, Term | CommandLaw) and e.n_states:
            assert callable(_function(rest_text(e, "law"), "law_at_rest"))


@pytest.mark.parametrize("command", [-2.0, 0.3, 0.9])
def test_a_text_gives_what_the_law_gives(command):
    law = effect("command_limit")
    assert isinstance(law, CommandLaw)
    p, state = (1.5, 12.0), (0.2, 0.4)
    expected = law.act(p, command, 0.0, 0.01, state)
    found = _function(command_text(law, "law"), "law")(np, command, 0.0, 0.01, p, state)
    np.testing.assert_allclose(np.ravel([found[0], *found[1]]), np.ravel([expected[0], *expected[1]]), rtol=1e-5)


def test_names_of_parameters_that_python_keeps_for_itself_are_others():
    crosstalk = effect("crosstalk")
    assert isinstance(crosstalk, Term)
    assert "from_, g = p" in term_text(crosstalk, "crosstalk")
