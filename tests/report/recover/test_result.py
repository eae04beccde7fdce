"""A run in Python: its table, and its state before it begins."""

from estexp_jax.package_data import model_path
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.cycle import job_of
from estexp_jax.report.recover.result import RecoverRun, RecoverTable


def test_table_prints_itself() -> None:
    row = {"number": 1, "diagnosis": ["a <b>"], "probability": "", "simulated": "1.00", "hardware": "0.90"}
    table = RecoverTable("title", [row])
    assert "a <b>" in str(table) and "a &lt;b&gt;" in table._repr_html_()


def test_a_run_can_be_looked_at_before_it_has_begun() -> None:
    settings = Settings(situation=5, seed=2, passes=1, population=8, generations=1, steps=30, settle_steps=10)
    run = RecoverRun(job_of(Robot.from_xml(model_path("quadruped")), settings))
    assert "not been damaged" in run._repr_html_()
