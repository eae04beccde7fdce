"""Logs of robots as files: read, checked and bound to a robot's elements."""

from estexp_jax.recordings.bind import read_recording
from estexp_jax.recordings.manifest import read_manifest

__all__ = ["read_manifest", "read_recording"]
