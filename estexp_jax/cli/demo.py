"""`estexp demo`: both jobs, from nothing but the package."""

from __future__ import annotations

from estexp_jax.api.options.demo import DemoOptions
from estexp_jax.api.options.explain import ExplainOptions
from estexp_jax.api.options.record import RecordOptions
from estexp_jax.api.options.recover import RecoverOptions
from estexp_jax.cli.explain import explain_command
from estexp_jax.cli.record import record_command
from estexp_jax.cli.recover import recover_command
from estexp_jax.package_data import model_path

_PLANTED = "coulomb_friction@knee T=0.6"


def demo_command(options: DemoOptions) -> int:
    """Recover, record, explain.

    Raises:
        InputError: DIR cannot be used.
    """
    force, resume, seed = options.force, options.resume, options.seed
    print("1. A quadruped loses a leg, and walks again.\n")
    walking = options.out / "recover"
    recover_command(RecoverOptions(out=walking, situation=3, seed=seed, quick=True, force=force, resume=resume))
    print("\n2. A leg rubs in its knee, and its simulator does not know.\n")
    recorded, explained = options.out / "recorded", options.out / "explain"
    anew = force or resume  # recording takes seconds, so it is not gone on with
    record_command(RecordOptions(model_path("leg"), recorded, effect=(_PLANTED,), duration=6.0, seed=seed, force=anew))
    explain_command(ExplainOptions((str(recorded / "recordings.toml"),), explained, force=force, resume=resume))
    print(f"\nThe two reports:\n  {walking / 'report.html'}\n  {explained / 'report.html'}")
    return 0
