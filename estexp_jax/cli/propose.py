"""`estexp propose`: the motion on which the explanations that are left disagree most."""

from __future__ import annotations

from estexp_jax.api.options.propose import ProposeOptions
from estexp_jax.api.propose import propose_to_folder


def propose_command(options: ProposeOptions) -> int:
    """Search, write, and print what was found.

    Raises:
        InputError: the folder holds no explanation with alternatives, an option is wrong, or DIR cannot be used.
    """
    written = propose_to_folder(options)
    print(written.proposal.summary())
    print(f"Commands: {written.commands}\nAdvice: {written.advice}\nReport: {written.report}")
    return 0
