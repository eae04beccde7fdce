"""Run folders, checkpoints, progress, workers, and versions."""

from estexp_jax.runs.checkpoint import load_checkpoint, save_checkpoint
from estexp_jax.runs.compilation_cache import count_compilations, enable_compilation_cache, forget_programs, quiet_xla
from estexp_jax.runs.files import write_json, write_text
from estexp_jax.runs.folder import RunFolder, open_run
from estexp_jax.runs.progress import ProgressDisplay
from estexp_jax.runs.versions import versions

__all__ = [
    "ProgressDisplay",
    "RunFolder",
    "count_compilations",
    "enable_compilation_cache",
    "forget_programs",
    "load_checkpoint",
    "open_run",
    "quiet_xla",
    "save_checkpoint",
    "versions",
    "write_json",
    "write_text",
]
