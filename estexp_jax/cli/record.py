"""`estexp record`: recordings of a simulated robot with a chosen effect."""

from __future__ import annotations

from estexp_jax.api.options.record import RecordOptions
from estexp_jax.api.record import record_to_folder


def record_command(options: RecordOptions) -> int:
    """Simulate, write, and print where the recordings are.

    Raises:
        InputError: the model or an effect is wrong, or DIR cannot be used.
    """
    print(record_to_folder(options, print).summary())
    return 0
