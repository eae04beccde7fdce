"""The usual fit of a model's own values, where `mujoco.sysid` is installed."""

import pytest

from estexp_jax.benchmark.parameter_fit import fit_parameters, sysid_version
from estexp_jax.cli.main import main
from estexp_jax.package_data import model_path


@pytest.fixture(scope="module")
def late(tmp_path_factory):
    out = tmp_path_factory.mktemp("late") / "out"
    effect = "command_delay@knee delay=0.03"
    assert main(["record", str(model_path("leg")), "--effect", effect, "--duration", "1.5", "--out", str(out)]) == 0
    return out / "recordings.toml"


@pytest.mark.filterwarnings("ignore")  # of the other program
def test_a_delay_is_taken_for_damping_and_inertia(late):
    if sysid_version() is None:
        pytest.skip("no mujoco.sysid; pip install 'mujoco[sysid]'")
    fit = fit_parameters(late)
    found = {value.name: value for value in fit.values}
    assert len(found) == 9 and found["damping of knee"].before == pytest.approx(0.05)
    assert found["damping of knee"].after > 4.0 * 0.05
    assert fit.after < 0.2 * fit.before < 0.02
