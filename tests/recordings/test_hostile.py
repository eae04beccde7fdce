"""Logs that somebody made to do harm: bombs, pickles, ways out, and names that a page or terminal would obey."""

import io
import json
import os
import zipfile

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from estexp_jax.cli.main import main
from estexp_jax.errors import InputError
from estexp_jax.recordings import read_manifest, table
from estexp_jax.recordings.readers.read import read_table

ARM = """
<mujoco><worldbody><body><joint name="{name}" axis="0 1 0"/><geom size=".1"/></body></worldbody>
<actuator><position name="servo" joint="{name}"/></actuator>
<sensor><jointpos name="angle" joint="{name}"/></sensor></mujoco>
"""


class Touch:
    """Unpickled, it would make a file."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (self.path,)


def _npz(path, **members):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return path


def _header(shape, kind="<f8"):
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": kind, "fortran_order": False, "shape": shape})
    return stream.getvalue()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (_header((10**15,)), r"claims to hold 1,000,000,000,000,000 numbers"),
        (_header((10**6, 10**9)), r"claims to hold"),
        (_header((-5,)), r"its shape is \(-5,\)"),
        (_header((10**6,)), r"its shape is \(1000000,\), but it holds \d+ bytes"),
        (_header((3,), "|O") + b"x", r"it holds object, not numbers"),
        (b"\x93NUMPY\x01\x00\xff\xff{'descr': " + b"-" * 60_000, r"is no column"),
        (b"\x93NUMPY\x09\x00", r"is no column"),
        (b"", r"is no column"),
    ],
)
def test_arrays_that_claim_too_much(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read_table(_npz(tmp_path / "a.npz", x=content)).column("x")


def test_nothing_is_unpickled(tmp_path):
    np.savez(tmp_path / "a.npz", x=np.array([Touch(str(tmp_path / "made"))], dtype=object))
    with pytest.raises(InputError, match="holds object"):
        read_table(tmp_path / "a.npz").column("x")
    assert not (tmp_path / "made").exists()


def test_bombs_are_refused_before_they_unpack(tmp_path, monkeypatch):
    monkeypatch.setattr(table, "MOST_NUMBERS", 100_000)
    _npz(tmp_path / "a.npz", x=_header((10**6,)) + bytes(8 * 10**6))
    parquet.write_table(pyarrow.table({"x": np.zeros(10**6)}), tmp_path / "a.parquet")
    lists = pyarrow.FixedSizeListArray.from_arrays(pyarrow.array(np.zeros(10**6)), 1000)
    parquet.write_table(pyarrow.table({"x": lists}), tmp_path / "b.parquet")
    (tmp_path / "a.csv").write_text("x\n" + "0\n" * 100_001)
    for name in ("a.npz", "a.parquet", "b.parquet", "a.csv"):
        with pytest.raises(InputError, match=r"claims to hold 1[\d,]+ numbers; at most 100,000"):
            read_table(tmp_path / name).column("x")


def test_columns_without_number(tmp_path):
    names = [f"c{k}" for k in range(20_000)]
    (tmp_path / "a.csv").write_text(",".join(names) + "\n")
    with pytest.raises(InputError, match=r"row 1: has 20,000 columns; at most 10,000"):
        read_table(tmp_path / "a.csv")
    (tmp_path / "b.csv").write_text(",".join(names[:9000]) + "\n" + ",".join("0" * 9000) + "\n")
    with pytest.raises(InputError, match=r"no column 'x'; known are: c0, .* and 8800 more"):
        read_table(tmp_path / "b.csv").column("x")


@pytest.mark.parametrize(
    ("file", "message"),
    [
        ("../" * 40 + "etc/passwd", "unknown kind of recording|no such recording"),
        ("/dev/zero", "no such recording"),
        ("/proc/self/environ", "unknown kind of recording|no such recording"),
        ("a\\u0000.csv", "no such recording"),
        ("n" * 5000, "no such recording"),
        ("..", "is a folder, not a recording"),
        ("pipe.csv", "no such recording"),
        ("loop.csv", "no such recording"),
        ("self.csv", "has no header|unknown kind|row 1|columns"),
    ],
)
def test_manifests_that_point_elsewhere(tmp_path, file, message):
    (tmp_path / "arm.xml").write_text(ARM.format(name="elbow"))
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "loop.csv").symlink_to("loop.csv")
    (tmp_path / "self.csv").symlink_to("recordings.toml")
    text = f'model = "arm.xml"\n[[recording]]\nfile = "{file}"\n'
    (tmp_path / "recordings.toml").write_text(text)
    with pytest.raises(InputError, match=message):
        read_manifest(tmp_path / "recordings.toml")


def test_names_do_what_names_do(tmp_path, monkeypatch, capsys):
    """Names with HTML, formulas and terminal codes in them are shown, by check, as what they are."""
    monkeypatch.chdir(tmp_path)
    joint, log = "&lt;script&gt;$\\x$", "<img src=x>$\\frac$\x1b[2J.csv"
    (tmp_path / "arm.xml").write_text(ARM.format(name=joint))
    rows = "\n".join(f"{0.01 * k},{np.sin(k)},{np.cos(k)},0" for k in range(50))
    (tmp_path / log).write_text(f"time,ctrl.servo,sensor.angle,<b>\x1b[31m</b>\n{rows}\n")
    assert main(["check", "arm.xml", log, "--out", "out"]) == 0
    assert "\x1b[2J" not in capsys.readouterr().out
    judged = json.loads((tmp_path / "out" / "check.json").read_text())["recordings"][0]
    assert judged["file"] == "<img src=x>$\\frac$\\x1b[2J.csv" and "<script>$\\x$" in judged["joints"]
    assert judged["notes"] == ["ignored columns: <b>\\x1b[31m</b>"]
    assert main(["check", "arm.xml", "\x1b[2J.csv"]) == 2
    assert "\x1b" not in capsys.readouterr().err


def test_members_that_lead_out_or_are_links_write_nothing(tmp_path):
    """Nothing is ever unpacked to the disk, so where a member says it belongs does not matter."""
    inner = tmp_path / "inner"
    inner.mkdir()
    good = io.BytesIO()
    np.save(good, np.arange(3.0))
    with zipfile.ZipFile(inner / "a.npz", "w") as archive:
        for name in ("../out", "/tmp/estexp-out", "a/../../out", "link"):
            info = zipfile.ZipInfo(f"{name}.npy")
            info.external_attr = 0o120777 << 16
            archive.writestr(info, good.getvalue())
        archive.writestr("target.npy", b"../../etc/passwd")
    archive = read_table(inner / "a.npz")
    assert archive.column("link").tolist() == [0.0, 1.0, 2.0]
    with pytest.raises(InputError, match="is no column"):
        archive.column("target")
    assert [path.name for path in tmp_path.rglob("*")] == ["inner", "a.npz"]


def test_headers_that_python_cannot_read_are_no_columns(tmp_path):
    header = b"\x93NUMPY\x01\x00\x20\x00{'descr': '<f8', (((((((((((((\n  "
    with pytest.raises(InputError, match="is no column"):
        read_table(_npz(tmp_path / "a.npz", x=header)).column("x")


def test_headers_in_the_manner_of_python_2_are_read_without_a_warning(tmp_path):
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (2L,), }"
    content = b"\x93NUMPY\x01\x00" + (len(header) + 1).to_bytes(2, "little") + header + b"\n" + bytes(16)
    assert read_table(_npz(tmp_path / "a.npz", x=content)).column("x").tolist() == [0.0, 0.0]
