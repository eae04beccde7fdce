"""One log in every format and variant: `--init` maps it without crossing a joint, and its values are the same.

Or it is refused in one message, which names the cause and what to do.
"""

from pathlib import Path

import numpy as np
import pytest

from estexp_jax.cli.main import main
from estexp_jax.errors import InputError
from estexp_jax.recordings.inputs import read_inputs
from estexp_jax.recordings.templates.manifest import write_manifest
from tests.recordings.readers.further_variants import FURTHER
from tests.recordings.readers.refused_variants import REFUSED
from tests.recordings.readers.variants import MODEL, TO_BE_CHECKED, VARIANTS, WITHOUT_CLOCK, truth

ALL = VARIANTS | FURTHER
EXACT = {"LeRobot": 1e-6, "LeRobot, version 3": 1e-6}
"""rad: they store numbers of 32 bits."""
CUT = "MCAP, cut inside a record"
TOLD = {
    CUT: ("the file ends in the middle",),
    "CSV, begun anew": ("its longest part is read",),
    "CSV, readings before the first command": ("3 rows (0.03 s) before the first command of m_base are left out",),
    "MCAP, readings before the first command": ("5 rows (0.05 s) before the first command of m_base are left out",),
    "MCAP, one topic, two definitions": ("topic /command has channels with different definitions",),
    "LeRobot": ("not measured",),
}
"""What the notes on a recording say."""
DOCS = Path(__file__).parents[2] / "docs" / "recordings.md"


@pytest.mark.parametrize("variant", ALL)
def test_every_variant_gives_the_same_recording(tmp_path, variant):
    log = truth()
    (tmp_path / "arm.xml").write_text(MODEL)
    path = ALL[variant](tmp_path, log)
    manifest = tmp_path / "recordings.toml"
    write_manifest(manifest, [str(tmp_path / "arm.xml"), str(path)], [], [])
    text = manifest.read_text()
    told = TO_BE_CHECKED.get(variant, "its unit by its values: check")
    assert "check this" not in text.replace(told, "") and (told in text or variant not in TO_BE_CHECKED)
    if variant in WITHOUT_CLOCK:
        manifest.write_text(text.replace('# time = "?"  #', "time = { hz = 100.0 }  #"))
    [recording] = read_inputs([str(manifest)]).recordings
    exact, rows = EXACT.get(variant, 1e-9), len(log.time)
    assert recording.rows == rows or (variant == CUT and recording.rows > rows)
    time = recording.time - recording.time[0]
    np.testing.assert_allclose(time[:rows], log.time, rtol=0, atol=1e-6)
    np.testing.assert_allclose(recording.ctrl[:rows], log.goals, rtol=0, atol=exact)
    np.testing.assert_allclose(recording.sensor[:rows], log.angles, rtol=0, atol=exact)
    assert (recording.enable == 1.0).all()
    for words in TOLD.get(variant, ()):
        assert any(words in note for note in recording.notes), recording.notes


@pytest.mark.parametrize("variant", REFUSED)
def test_what_is_refused_is_named_with_its_remedy(tmp_path, variant, capsys):
    write, changed, cause, remedy = REFUSED[variant]
    (tmp_path / "arm.xml").write_text(MODEL)
    path, manifest = write(tmp_path, truth()), tmp_path / "recordings.toml"
    command = [str(tmp_path / "arm.xml"), str(path)]
    try:
        write_manifest(manifest, command, [], [])
        manifest.write_text(changed(manifest.read_text()))
        command = [str(manifest)]
    except InputError:
        pass  # nothing of it can be read: so says `check`, too
    assert main(["check", *command]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and "Traceback" not in told
    assert path.name in told and cause in told and remedy in told, told


def test_the_table_of_the_documentation_has_every_variant():
    cells = {line.split("|")[1].strip() for line in DOCS.read_text().splitlines() if line.startswith("|")}
    assert not (ALL.keys() | REFUSED.keys()) - cells
