"""What a run ran on."""

import json
import platform
from importlib import metadata

from estexp_jax.runs import versions
from estexp_jax.runs.versions import version


def test_versions_are_texts_for_json():
    entries = versions()
    assert entries["python"] == platform.python_version()
    for name in ("mujoco", "mujoco-mjx", "jax", "jaxlib", "numpy"):
        assert entries[name] == metadata.version(name)
    assert int(entries["cores"]) >= 1 and entries["cpu"] and entries["platform"] and "estexp_jax" in entries
    assert json.loads(json.dumps(entries)) == entries


def test_what_is_absent_is_said_to_be():
    assert version("no-such-package-of-ours") == "not installed"
