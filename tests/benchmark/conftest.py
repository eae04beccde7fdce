"""A robot that travels, and a place for progress."""

import io

import pytest


@pytest.fixture(scope="session")
def race(tmp_path_factory):
    """A small task with a cart-pole."""
    from estexp_jax.benchmark.subject import BenchmarkTask
    from tests.physics.robots import CARTPOLE

    path = tmp_path_factory.mktemp("model") / "cartpole.xml"
    path.write_text(CARTPOLE)
    return BenchmarkTask(str(path), population=5, steps=6, substeps=2)


@pytest.fixture
def progress():
    """Progress that nobody sees."""
    from estexp_jax.runs import ProgressDisplay

    with ProgressDisplay(out=io.StringIO(), err=io.StringIO()) as progress:
        yield progress
