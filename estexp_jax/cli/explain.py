"""`estexp explain`: find the physics that a simulator lacks."""

from __future__ import annotations

from estexp_jax.api.explain import explain_to_folder
from estexp_jax.api.options.explain import ExplainOptions


def explain_command(options: ExplainOptions) -> int:
    """Explain, write, and print what was found.

    Raises:
        InputError: an input or option is wrong, or DIR cannot be used.
    """
    written = explain_to_folder(options)
    if written.no_pictures:
        print(f"No picture of the robots: {written.no_pictures}")
    print(written.result.summary())
    for change in written.result.diagnosis.left_out:
        print(f"MJCF has no place for {change.place}: model_explained.xml is fitted without it; load_explained has it.")
    print(f"Report: {written.report}")
    return 0
