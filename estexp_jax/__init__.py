"""Finds what broke on a robot, or what its simulator lacks, by searching simulations until they match its sensors.

The front doors are loaded when first used, so that importing the package costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from estexp_jax.api.controller import load_controller
    from estexp_jax.api.effects import effects, register
    from estexp_jax.api.explain import explain
    from estexp_jax.api.propose import propose
    from estexp_jax.api.recover import recover, rollout
    from estexp_jax.api.simulator import load_explained
    from estexp_jax.physics.model.robot import Robot

__all__ = [
    "Robot",
    "effects",
    "explain",
    "load_controller",
    "load_explained",
    "propose",
    "recover",
    "register",
    "rollout",
]

_DOORS = {
    "Robot": "estexp_jax.physics.model.robot",
    "effects": "estexp_jax.effects",
    "explain": "estexp_jax.api.explain",
    "load_controller": "estexp_jax.api.controller",
    "load_explained": "estexp_jax.api.simulator",
    "propose": "estexp_jax.api.propose",
    "recover": "estexp_jax.api.recover",
    "register": "estexp_jax.api.effects",
    "rollout": "estexp_jax.api.recover",
}


def __getattr__(name: str) -> Any:
    if name not in _DOORS:
        raise AttributeError(f"module 'estexp_jax' has no attribute '{name}'")
    from importlib import import_module

    from estexp_jax.runs.cache import quiet_xla

    quiet_xla()  # the doors load JAX; afterwards it would be too late
    module = import_module(_DOORS[name])
    return module if module.__name__ == f"{__name__}.{name}" else getattr(module, name)  # `effects` is a module


def __dir__() -> list[str]:
    return sorted([*globals(), *_DOORS])
