"""What a run ran on."""

import json
import platform
from importlib import metadata

from estexp_jax.runs import versions
from estexp_jax.runs.versions import version


def test_versions_are_texts_for_json():
    found = versions()
    assert found["python"] == platform.python_version()
    for name in ("mujoco", "mujoco-mjx", "jax", "jaxlib", "numpy"):
        assert found[name] == metadata.version(name)
    assert int(found["cores"]) >= 1 and found["cpu"] and found["platform"] and "estexp_jax" in found
    assert json.loads(json.dumps(found)) == found


def test_what_is_absent_is_said_to_be():
    assert version("no-such-package-of-ours") == "not installed"
