"""What the usual fit of a model's own values answers on the recordings that `explain` is given; for the demo."""

from __future__ import annotations

from estexp_jax.benchmark.parameter_fit import FittedValue, ParameterFit, fit_parameters, sysid_version

__all__ = ["FittedValue", "ParameterFit", "fit_parameters", "sysid_version"]
