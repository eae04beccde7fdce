"""LeRobot data sets: which episode, which files, and being told what is wrong with them."""

import json
import shutil

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from estexp_jax.cli.main import main
from estexp_jax.errors import InputError
from estexp_jax.recordings import read_manifest
from estexp_jax.recordings.readers.read import read_table
from estexp_jax.recordings.table import Selection
from tests.recordings.readers.forms import write_lerobot


def _log(value):
    time = np.arange(30) * 0.01
    return time, np.full(30, float(value)), time + value


@pytest.fixture
def folder(tmp_path):
    """A data set of three episodes in two files."""
    write_lerobot(tmp_path / "set", [_log(k) for k in range(3)])
    return tmp_path / "set"


def _info(folder, **changes):
    path = folder / "meta" / "info.json"
    path.write_text(json.dumps({k: v for k, v in (json.loads(path.read_text()) | changes).items() if v is not None}))
    return folder


@pytest.mark.parametrize("episode", range(3))
@pytest.mark.parametrize("indexed", [True, False])
def test_an_episode_is_found_with_and_without_the_index(folder, episode, indexed):
    if not indexed:
        shutil.rmtree(folder / "meta" / "episodes")
    table = read_table(folder, Selection(episode=episode))
    assert table.label == f"set_episode_{episode}.parquet"
    np.testing.assert_allclose(table.column("timestamp"), np.arange(30) * 0.01, atol=1e-7)
    np.testing.assert_array_equal(table.column("action", 1), np.full(30, float(episode)))
    np.testing.assert_array_equal(table.column("action.elbow.pos"), table.column("action", 1))
    with pytest.raises(InputError, match=r"column 'observation.image': is no column of numbers"):
        table.column("observation.image")
    with pytest.raises(InputError, match=r"no column 'x'; known are: .*action\.elbow\.pos"):
        table.column("x")


def test_a_data_file_alone_is_a_log_too(folder):
    path = folder / "data" / "chunk-000" / "file-000.parquet"
    table = read_table(path, Selection(episode=1))
    assert (table.label, len(table.column("timestamp"))) == ("file-000_episode_1.parquet", 30)
    np.testing.assert_array_equal(table.column("action.elbow.pos"), np.ones(30))
    with pytest.raises(InputError, match=r"holds several episodes; choose one with `episode = 0`.*there are: 0, 1$"):
        read_table(path)
    with pytest.raises(InputError, match=r"has no episode 7; .*there are: 0, 1"):
        read_table(path, Selection(episode=7))


def test_the_older_layout_is_read(folder, tmp_path):
    template = "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"
    whole = folder / "data" / "chunk-000" / "file-000.parquet"
    one = parquet.read_table(whole, filters=[("episode_index", "==", 1)])
    parquet.write_table(one, folder / "data" / "chunk-000" / "episode_000001.parquet")
    _info(folder, codebase_version="v2.1", data_path=template)
    np.testing.assert_array_equal(read_table(folder, Selection(episode=1)).column("action", 1), np.ones(30))
    with pytest.raises(InputError, match=r"episode 2: no such data file .*episode_000002\.parquet"):
        read_table(folder, Selection(episode=2))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({}, r"set: has 3 episodes; choose one with `episode = 0` under \[\[recording\]\]"),
        ({"codebase_version": "v1.6"}, r"codebase_version: is 'v1\.6'; versions v2\.x and v3\.x"),
        ({"codebase_version": None}, r"codebase_version: is None"),
        ({"total_episodes": -1}, r"total_episodes: is '-1'"),
        ({"total_episodes": 10**30}, r"total_episodes: is '1000"),
        ({"total_episodes": "three"}, r"total_episodes: is 'three'"),
        ({"total_episodes": 1, "data_path": None}, r"data_path: is 'None'"),
        ({"total_episodes": 1, "data_path": "../../etc/{file_index}.parquet"}, r"may lead out of the data set"),
        ({"total_episodes": 1, "data_path": "/etc/{file_index}.parquet"}, r"may lead out of the data set"),
        ({"total_episodes": 1, "data_path": "data/**/{file_index}.parquet"}, r"may lead out of the data set"),
        ({"total_episodes": 1, "data_path": "{chunk_index.__class__}.parquet"}, r"may lead out of the data set"),
        ({"total_episodes": 1, "data_path": "{file_index:09999999999d}.parquet"}, r"may lead out of the data set"),
        ({"total_episodes": 1, "data_path": "none/{file_index:03d}.parquet"}, r"no such data file|0 data files"),
    ],
)
def test_wrong_descriptions_are_told(folder, changes, message):
    with pytest.raises(InputError, match=message):
        read_table(_info(folder, **changes))


@pytest.mark.parametrize("text", ["", "[]", "{", "[" * 100_000, "\ud800"])
def test_descriptions_that_are_no_json(folder, text):
    (folder / "meta" / "info.json").write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(InputError, match=r"info\.json: is no"):
        read_table(folder)


def test_an_index_that_lies_is_told(folder):
    table = {"episode_index": [0], "data/chunk_index": [99], "data/file_index": [99]}
    parquet.write_table(pyarrow.table(table), folder / "meta/episodes/chunk-000/file-000.parquet")
    with pytest.raises(InputError, match=r"no such data file .*chunk-099/file-099\.parquet"):
        read_table(folder, Selection(episode=0))


def test_episodes_of_one_set_have_names_of_their_own(folder, pendulum_xml):
    (folder.parent / "pendulum.xml").write_text(pendulum_xml)
    entries = "".join(f'[[recording]]\nfile = "set"\nepisode = {k}\n' for k in (2, 0))
    (folder.parent / "recordings.toml").write_text(f"""
model = "pendulum.xml"
[columns]
time = "timestamp"
"ctrl.servo.1" = {{ column = "action", index = 1, unit = "deg" }}
"ctrl.actuator_1" = {{ value = 0.0 }}
"sensor.angle" = "observation.state.elbow.pos"
{entries}""")
    first, second = read_manifest(folder.parent / "recordings.toml").recordings
    assert (first.name, second.name) == ("set_episode_2.parquet", "set_episode_0.parquet")
    np.testing.assert_allclose(first.ctrl[:, 0], np.radians(2.0))
    assert not any("observation.state" in note for note in first.notes)


def test_init_writes_a_manifest_for_a_data_set(folder, pendulum_xml, monkeypatch):
    monkeypatch.chdir(folder.parent)
    (folder.parent / "arm.xml").write_text(pendulum_xml.replace("hinge", "elbow").replace('type="elbow"', ""))
    assert main(["check", "arm.xml", "set", "--init", "--out", "out"]) == 0
    text = (folder.parent / "out" / "recordings.toml").read_text()
    assert 'file = "../set"\nepisode = 0' in text and '"ctrl.servo.1" = "action.elbow.pos"' in text
    assert 'time = "timestamp"' in text
