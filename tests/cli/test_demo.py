"""The demo: what is concealed is not what the usual fit answers; the answer that it quotes is one of its recordings."""

import pytest

from estexp_jax.api import parameter_fit
from estexp_jax.api.options.demo import DemoOptions
from estexp_jax.api.parameter_fit import FittedValue, ParameterFit
from estexp_jax.cli import demo


@pytest.fixture
def quick(monkeypatch):
    """The commands, each only named."""
    ran = []
    for name in ("explain", "record", "recover"):
        monkeypatch.setattr(
            f"estexp_jax.cli.{name}.{name}_command", lambda options, name=name: ran.append((name, options))
        )
    return ran


def test_it_records_explains_and_recovers(quick, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(parameter_fit, "sysid_version", lambda: None)
    assert demo.demo_command(DemoOptions(out=tmp_path, force=True)) == 0
    assert [name for name, _ in quick] == ["record", "explain", "recover"] and all(
        options.force for _, options in quick
    )
    shown = capsys.readouterr().out
    assert "1.28 instead of 0.05" in shown and "pip install 'mujoco[sysid]'" in shown
    assert shown.index("30 ms late") < shown.index("damping of knee") < shown.index("What estexp explain answers")


def test_where_it_can_be_computed_it_is(quick, tmp_path, monkeypatch, capsys):
    values = [FittedValue(f"damping of {n}", 1.0, 1.0 + n) for n in range(5)]
    monkeypatch.setattr(parameter_fit, "sysid_version", lambda: "9.1")
    monkeypatch.setattr(parameter_fit, "fit_parameters", lambda _: ParameterFit(tuple(values), 0.0263, 0.00093))
    assert demo.demo_command(DemoOptions(out=tmp_path)) == 0
    shown = capsys.readouterr().out
    assert "MuJoCo 9.1" in shown and "damping of 4: 5 instead of 1" in shown and "damping of 1:" not in shown
    assert "0.093 % of the sensors' range instead of 2.63 %" in shown
