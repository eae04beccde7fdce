"""A run in Python: its table, and its state before it begins."""

from estexp_jax.package_data import model_path
from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.recover.run import RecoverTable, recover_run


def test_table_prints_itself() -> None:
    row = {"number": 1, "diagnosis": ["a <b>"], "probability": "", "simulated": "1.00", "hardware": "0.90"}
    table = RecoverTable("title", [row])
    assert "a <b>" in str(table) and "a &lt;b&gt;" in table._repr_html_()


def test_a_run_can_be_looked_at_before_it_has_begun() -> None:
    run = recover_run(Robot.from_xml(model_path("quadruped")), quick=True, situation=5, seed=2, passes=2)
    assert run.job.settings.population == 64 and run.job.settings.passes == 2
    assert "not been damaged" in run._repr_html_()
