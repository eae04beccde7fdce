"""Workers on a Ray cluster: what is checked before Ray is imported."""

import socket

import pytest

from estexp_jax.errors import InputError
from estexp_jax.runs.cluster import gpus_for
from estexp_jax.runs.workers import worker_pool_of


def test_without_ray_the_command_that_installs_it_is_told(monkeypatch):
    monkeypatch.setattr("estexp_jax.runs.cluster.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"--ray: Ray is not installed; pip install 'estexp_jax\[cluster\]'"):
        worker_pool_of(ray="local")


@pytest.fixture
def installed(monkeypatch):
    """Ray seems to be there; addresses are judged before it is imported."""
    monkeypatch.setattr("estexp_jax.runs.cluster.find_spec", lambda name: name)


@pytest.mark.parametrize("address", ["nowhere", "127.0.0.1:x", "127.0.0.1:99999", "ray://a"])
def test_a_wrong_address_is_told(address, installed):
    with pytest.raises(InputError, match=f"--ray {address}: .*ray start --head"):
        worker_pool_of(ray=address)


def test_an_address_where_nobody_answers_is_told_soon(installed):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with pytest.raises(InputError, match="nobody answers"):
        worker_pool_of(ray=f"127.0.0.1:{port}")


def test_a_gpu_is_asked_for_where_jax_would_use_it():
    assert [gpus_for(platform) for platform in ("cpu", "gpu", "tpu")] == [0, 1, 1]
