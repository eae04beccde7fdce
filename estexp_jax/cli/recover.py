"""`estexp recover`: walk, get damaged, diagnose from the sensors, walk again."""

from __future__ import annotations

from estexp_jax.api.options.recover import RecoverOptions
from estexp_jax.api.recover import recover_to_folder


def recover_command(options: RecoverOptions) -> int:
    """Run to the end, or from where an earlier run was interrupted.

    Raises:
        InputError: the robot, the damage, the settings or DIR cannot be used.
    """
    recover_to_folder(options)
    return 0
