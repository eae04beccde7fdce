"""`estexp demo`: both jobs, from nothing but the package."""

from __future__ import annotations

from pathlib import Path

from estexp_jax.api.options.demo import DemoOptions
from estexp_jax.api.options.explain import ExplainOptions
from estexp_jax.api.options.record import RecordOptions
from estexp_jax.api.options.recover import RecoverOptions
from estexp_jax.package_data import model_path

_PLANTED = "command_delay@knee delay=0.03"
_QUOTED = """\
What a fit of the model's own values answers, with mujoco.sysid of MuJoCo 4.0.0 and these recordings
(`pip install 'mujoco[sysid]'`, then this command computes it here):
  damping of knee: 1.28 instead of 0.05
  armature of knee: 0.0525 instead of 0.005
  damping of thigh: 0.0839 instead of 0.05
On a recording that was not fitted, the error is 0.093 % of the sensors' range instead of 2.63 %.
It fits well, and none of these values was wrong."""
_SHOWN = 3
"""Of the fitted values, those that were changed most."""


def demo_command(options: DemoOptions) -> int:
    """Record, fit the usual way, explain, recover.

    Raises:
        InputError: DIR cannot be used.
    """
    print("1. The motor of a leg's knee obeys its commands 30 ms late, and its simulator does not know.\n", flush=True)
    # What computes is imported now: it takes seconds.
    from estexp_jax.cli.explain import explain_command
    from estexp_jax.cli.record import record_command
    from estexp_jax.cli.recover import recover_command

    force, resume, seed = options.force, options.resume, options.seed
    recorded, explained, walking = (options.out / name for name in ("recorded", "explain", "recover"))
    anew = force or resume  # recording takes seconds, so it is not gone on with
    record_command(RecordOptions(model_path("leg"), recorded, effect=(_PLANTED,), duration=4.0, seed=seed, force=anew))
    manifest = recorded / "recordings.toml"
    print(f"\n{_usual_answer(manifest)}\n\nWhat estexp explain answers:\n", flush=True)
    explain_command(ExplainOptions((str(manifest),), explained, force=force, resume=resume))
    print("\n2. A quadruped loses a leg, and walks again.\n", flush=True)
    recover_command(RecoverOptions(out=walking, situation=3, seed=seed, quick=True, force=force, resume=resume))
    print(f"\nThe two reports:\n  {explained / 'report.html'}\n  {walking / 'report.html'}")
    return 0


def _usual_answer(manifest: Path) -> str:
    """What fitting the model's own values gives: computed where that can be, else as it was."""
    from estexp_jax.api.parameter_fit import fit_parameters, sysid_version

    version = sysid_version()
    if version is None:
        return _QUOTED
    fit = fit_parameters(manifest)
    ranked = sorted(fit.values, key=lambda value: abs(value.after / value.before - 1.0), reverse=True)
    lines = [f"  {value.name}: {value.after:.3g} instead of {value.before:.3g}" for value in ranked[:_SHOWN]]
    proof = f"the error is {100.0 * fit.after:.2g} % of the sensors' range instead of {100.0 * fit.before:.3g} %"
    head = f"What a fit of the model's own values answers, with mujoco.sysid of MuJoCo {version}:"
    tail = f"On a recording that was not fitted, {proof}.\nNone of these values was wrong."
    return "\n".join([head, *lines, tail])
