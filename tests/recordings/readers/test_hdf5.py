"""HDF5: robomimic's demonstrations, ALOHA's episodes, MATLAB's files, tables, and files that lead elsewhere."""

import sys

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.read import holds_episodes, read_table
from estexp_jax.recordings.table import Selection

ROWS = np.arange(20.0)


@pytest.fixture
def h5py():
    return pytest.importorskip("h5py", reason="needs the extra `hdf5`: pip install 'estexp_jax[hdf5]'")


def test_groups_are_paths_and_lists_have_an_index(tmp_path, h5py):
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        file["action"] = np.stack([ROWS, -ROWS], axis=1).astype(np.float32)
        file["observations/qpos"] = np.stack([ROWS, -ROWS], axis=1)
        file["observations/images/top"] = np.zeros((20, 4, 4, 3), np.uint8)
        file["label"] = "pick"
        file["log"] = np.array([(0.5, 1)] * 20, dtype=[("t", "f8"), ("on", "?")])
    table = read_table(tmp_path / "a.hdf5")
    np.testing.assert_array_equal(table.column("observations/qpos", 1), -ROWS)
    np.testing.assert_array_equal(table.column("log.t"), np.full(20, 0.5))
    assert table.column("log.on")[0] == 1.0
    with pytest.raises(InputError, match=r"'observations/images/top': is no column of numbers: its shape is"):
        table.column("observations/images/top")
    part = read_table(tmp_path / "a.hdf5", Selection(wanted=frozenset({"action"})))
    assert set(part.columns) == {"action"} and "observations/qpos" in part.unread


def test_demonstrations_are_episodes(tmp_path, h5py):
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        for k in (0, 2, 10):
            file[f"data/demo_{k}/actions"] = ROWS + k
    assert holds_episodes(tmp_path / "a.hdf5")
    table = read_table(tmp_path / "a.hdf5", Selection(episode=10))
    np.testing.assert_array_equal(table.column("actions"), ROWS + 10)
    assert table.label == "a_episode_10.hdf5"
    with pytest.raises(InputError, match=r"holds several episodes; choose one .* there are: 0, 2, 10"):
        read_table(tmp_path / "a.hdf5")
    with pytest.raises(InputError, match="has no episode 1"):
        read_table(tmp_path / "a.hdf5", Selection(episode=1))


def test_matlab_arrays_are_turned_round(tmp_path, h5py):
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file["t"], file["q"] = ROWS[None], np.stack([ROWS, -ROWS])
        for name in ("t", "q"):
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    table = read_table(tmp_path / "a.mat")
    np.testing.assert_array_equal(table.column("t"), ROWS)
    np.testing.assert_array_equal(table.column("q", 1), -ROWS)


def test_files_that_lead_elsewhere_are_not_followed(tmp_path, h5py):
    (tmp_path / "secret").write_bytes(bytes(160))
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["x"] = ROWS
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["link"] = h5py.ExternalLink(str(tmp_path / "b.h5"), "/x")
        file["loop"] = h5py.SoftLink("/")
        file.create_dataset("raw", (20,), "f8", external=[(str(tmp_path / "secret"), 0, 160)])
        layout = h5py.VirtualLayout((20,), "f8")
        layout[:] = h5py.VirtualSource(str(tmp_path / "b.h5"), "x", (20,))
        file.create_virtual_dataset("virtual", layout)
        file["own"] = ROWS
    table = read_table(tmp_path / "a.h5")
    assert set(table.columns) == {"own"}
    for name in ("raw", "virtual"):
        with pytest.raises(InputError, match="its values lie in other files"):
            table.column(name)


def test_sizes_are_checked_before_memory_is_allocated(tmp_path, h5py):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("x", (10**12,), "f8", chunks=(1000,))
    with pytest.raises(InputError, match="claims to hold 1,000,000,000,000 numbers"):
        read_table(tmp_path / "a.h5")


def test_what_is_no_hdf5_is_told(tmp_path, h5py, monkeypatch):
    (tmp_path / "a.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(500))
    with pytest.raises(InputError, match=r"a\.mat: is not an HDF5 file.*save -v7\.3"):
        read_table(tmp_path / "a.mat")
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match=r"needs the extra `hdf5`; pip install 'estexp_jax\[hdf5\]'"):
        read_table(tmp_path / "a.mat")
