"""Finds what broke on a robot, or what its simulator lacks, by searching simulations until they match its sensors.

The front doors are loaded when first used, so that importing the package costs nothing.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as checkers understand it: importing `typing` would take longer than all else here

if TYPE_CHECKING:
    from typing import Any

    from estexp_jax.api.check import check
    from estexp_jax.api.controller import load_controller
    from estexp_jax.api.effects import effects, register
    from estexp_jax.api.explain import explain
    from estexp_jax.api.propose import propose
    from estexp_jax.api.randomisation import actuator_settings, randomisation
    from estexp_jax.api.record import record
    from estexp_jax.api.recover import recover
    from estexp_jax.api.rollout import rollout
    from estexp_jax.api.simulate import simulate
    from estexp_jax.api.simulator import load_explained
    from estexp_jax.physics.model.robot import Robot
    from estexp_jax.recovery.control.trial import Trial

    __version__: str

_DOORS = {
    "Robot": "estexp_jax.physics.model.robot",
    "Trial": "estexp_jax.recovery.control.trial",
    "actuator_settings": "estexp_jax.api.randomisation",
    "check": "estexp_jax.api.check",
    "effects": "estexp_jax.effects",
    "explain": "estexp_jax.api.explain",
    "load_controller": "estexp_jax.api.controller",
    "load_explained": "estexp_jax.api.simulator",
    "propose": "estexp_jax.api.propose",
    "randomisation": "estexp_jax.api.randomisation",
    "record": "estexp_jax.api.record",
    "recover": "estexp_jax.api.recover",
    "register": "estexp_jax.api.effects",
    "rollout": "estexp_jax.api.rollout",
    "simulate": "estexp_jax.api.simulate",
}
__all__ = [
    "Robot",
    "Trial",
    "actuator_settings",
    "check",
    "effects",
    "explain",
    "load_controller",
    "load_explained",
    "propose",
    "randomisation",
    "record",
    "recover",
    "register",
    "rollout",
    "simulate",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from estexp_jax.runs.versions import version

        return version("estexp_jax")
    if name not in _DOORS:
        raise AttributeError(f"module 'estexp_jax' has no attribute '{name}'")
    from importlib import import_module

    from estexp_jax.runs.compilation_cache import quiet_xla

    quiet_xla()  # the doors load JAX; afterwards it would be too late
    module = import_module(_DOORS[name])
    return module if module.__name__ == f"{__name__}.{name}" else getattr(module, name)  # `effects` is a module


def __dir__() -> list[str]:
    return sorted([*globals(), *_DOORS, "__version__"])
