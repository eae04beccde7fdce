"""One log in every format and variant: `--init` maps it without crossing a joint, and its values are the same."""

from pathlib import Path

import numpy as np
import pytest

from estexp_jax.recordings.inputs import read_inputs
from estexp_jax.recordings.templates.manifest import write_manifest
from tests.recordings.readers.variants import MODEL, TO_BE_CHECKED, VARIANTS, WITHOUT_CLOCK, truth

DOCS = Path(__file__).parents[2] / "docs" / "recordings.md"


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_variant_gives_the_same_recording(tmp_path, variant):
    log = truth()
    (tmp_path / "arm.xml").write_text(MODEL)
    path = VARIANTS[variant](tmp_path, log)
    manifest = tmp_path / "recordings.toml"
    write_manifest(manifest, [str(tmp_path / "arm.xml"), str(path)], [], [])
    text = manifest.read_text()
    told = TO_BE_CHECKED.get(variant, "its unit by its values: check")
    assert "check this" not in text.replace(told, "") and (told in text or variant not in TO_BE_CHECKED)
    if variant in WITHOUT_CLOCK:
        manifest.write_text(text.replace('# time = "?"  #', "time = { hz = 100.0 }  #"))
    [recording] = read_inputs([str(manifest)]).recordings
    exact = 1e-6 if variant == "LeRobot" else 1e-9
    time = recording.time - recording.time[0]
    np.testing.assert_allclose(time, log.time, rtol=0, atol=1e-6)
    np.testing.assert_allclose(recording.ctrl, log.goals, rtol=0, atol=exact)
    np.testing.assert_allclose(recording.sensor, log.angles, rtol=0, atol=exact)


def test_the_table_of_the_documentation_has_every_variant():
    cells = {line.split("|")[1].strip() for line in DOCS.read_text().splitlines() if line.startswith("|")}
    assert not VARIANTS.keys() - cells
