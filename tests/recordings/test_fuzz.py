"""Broken and hostile logs and manifests: each is told as the user's error, or is a recording; nothing else happens."""

import hashlib
import json
import signal
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pyarrow import parquet

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings import read_manifest, read_recording
from estexp_jax.recordings.checks.excitation import missing
from estexp_jax.recordings.checks.inspect import judge
from estexp_jax.recordings.columns import Source
from estexp_jax.recordings.readers.read import read_table
from estexp_jax.recordings.table import Selection
from experiments.robustness.fuzz.folders import TOML
from tests.recordings.readers.forms import FORMS, write_form, write_lerobot

ARM = """
<mujoco><worldbody><body><joint name="elbow" axis="0 1 0"/><geom size=".1"/></body></worldbody>
<actuator><position name="servo" joint="elbow" ctrlrange="-1 1"/></actuator>
<sensor><jointpos name="angle" joint="elbow"/></sensor></mujoco>
"""
FLAT = {"time": Source("time"), "ctrl.servo": Source("goal"), "sensor.angle": Source("position")}
LEROBOT = {"time": Source("timestamp"), "ctrl.servo": Source("action", index=1)}
LEROBOT |= {"sensor.angle": Source("observation.state.elbow.pos")}
MCAP = {"ctrl.servo": Source("/goal.position[0]"), "sensor.angle": Source("/joint_states.position[elbow]")}
LONGEST_S = 20
ROWS = 40

UNHURRIED = (HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.large_base_example)
QUICK, SLOW = 50, 2500
NUMBERS = st.floats() | st.sampled_from([1e300, -1e300, 5e-324, float("nan"), float("inf"), 1e30, 0.0])
NAMES = st.sampled_from(
    [
        "time",
        "goal",
        "position",
        "ctrl.servo",
        "sensor.angle",
        "qpos.elbow",
        "enable.servo",
        "ctrl.x",
        "",
        "episode_index",
    ]
) | st.text(max_size=8)


def _log():
    time = np.arange(ROWS) * 0.01
    return time, np.sin(time), np.cos(time)


@pytest.fixture(scope="module")
def arm():
    return Robot.from_string(ARM, "arm.xml")


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A good file of each kind, as bytes."""
    folder = tmp_path_factory.mktemp("good")
    (folder / "arm.xml").write_text(ARM)
    files = {}
    for form in FORMS:
        try:
            write_form(form, folder / form, [_log()], folder / "arm.xml")
        except ImportError:
            continue
        if form != "lerobot":
            files[form] = (folder / form / f"log_0.{form}").read_bytes()
    return files


class Tally:
    """Which inputs were given, and which of them were refused."""

    def __init__(self):
        self.given, self.refused = set(), set()

    def note(self, content, refused):
        key = hashlib.blake2b(content, digest_size=8).digest()
        self.given.add(key)
        if refused:
            self.refused.add(key)


def _hang(*_):
    raise AssertionError(f"longer than {LONGEST_S} s")


def _outcome(attempt):
    """Run it; whether it refused. Anything but an InputError or an end is the test's failure."""
    signal.signal(signal.SIGALRM, _hang)
    signal.alarm(LONGEST_S)
    try:
        attempt()
    except InputError as error:
        assert 0 < len(str(error)) < 40_000 and "\n" not in str(error)
        return True
    finally:
        signal.alarm(0)
    return False


def _recording(robot, path, mapping, selection=Selection()):  # noqa: B008
    """Read a log in all ways that the program does; as a recording, if it is one."""
    table = read_table(path, selection)
    for name in (*table.names, *table.parts):
        with suppress(InputError):
            assert table.column(name).dtype == np.float64
    recording = read_recording(robot, path, mapping=mapping, selection=selection, mend=True)
    assert np.isfinite(recording.ctrl).all() and not np.isinf(recording.sensor).any()
    judged = judge(robot, recording)
    json.dumps([judged, list(missing([judged]))], allow_nan=False)


def _mutated(content, edits):
    """Bytes with some overwritten, cut out, put in, or cut off behind."""
    data = bytearray(content)
    for kind, place, new in edits:
        at = place % (len(data) + 1)
        if kind == 0:
            data[at : at + len(new)] = new
        elif kind == 1:
            data[at:at] = new * 3
        elif kind == 2:
            del data[at : at + len(new) + 1]
        elif kind == 3:
            del data[at:]
        else:
            other = (place // 7) % (len(data) + 1)
            data[at:at] = data[other : other + 40]
    return bytes(data)


EDITS = st.lists(st.tuples(st.integers(0, 4), st.integers(0, 10**6), st.binary(min_size=1, max_size=8)), max_size=6)


def _csv_text():
    cells = NUMBERS.map(repr) | st.text(max_size=6) | st.sampled_from(["", "nan", "-inf", "1e999", '"', "0x1"])
    row = st.lists(cells, min_size=2, max_size=4)
    rows = st.lists(row, max_size=6).map(lambda rows: "\n".join(",".join(cells) for cells in rows))
    header = st.lists(NAMES, min_size=1, max_size=4).map(",".join)
    return st.tuples(header, rows).map(lambda parts: "\n".join(parts).encode("utf-8", "surrogatepass"))


def _arrays():
    kinds = st.sampled_from(
        ["f8", "f4", "f2", "i8", "u8", "i1", "?", "c16", "U3", "S2", "M8[s]", "O", "f8,i4", "V4", "g"]
    )
    shapes = st.sampled_from([(), (0,), (3,), (4,), (3, 2), (3, 0), (2, 3, 4), (1,)])

    def array(kind, shape, values):
        made = np.zeros(shape, dtype=kind)
        if np.dtype(kind).kind in "fc" and made.size:
            with np.errstate(all="ignore"):
                made.flat[:] = np.resize(np.array(values), made.size).astype(kind)
        return made

    one = st.builds(array, kinds, shapes, st.lists(NUMBERS, min_size=1, max_size=4))
    return st.dictionaries(NAMES.filter(lambda name: "\0" not in name and "/" not in name), one, max_size=4)


def _npz_bytes(arrays):
    with tempfile.SpooledTemporaryFile() as stream:
        np.savez_compressed(stream, **{name.encode("utf-8", "replace").decode(): v for name, v in arrays.items()})
        stream.seek(0)
        return stream.read()


def _tables():
    values = st.lists(NUMBERS | st.none(), min_size=3, max_size=3)
    lists = st.lists(st.lists(NUMBERS | st.none(), max_size=3) | st.none(), min_size=3, max_size=3)
    words = st.lists(st.text(max_size=3), min_size=3, max_size=3)
    whole = st.lists(st.integers(-(2**63), 2**63 - 1), min_size=3, max_size=3)
    column = values.map(pyarrow.array) | lists.map(lambda v: pyarrow.array(v, pyarrow.list_(pyarrow.float64())))
    column |= words.map(lambda v: pyarrow.array([w.encode("utf-8", "replace").decode() for w in v]))
    column |= whole.map(pyarrow.array)
    named = st.tuples(NAMES.map(lambda name: name.encode("utf-8", "replace").decode()), column)
    return st.lists(named, min_size=1, max_size=5)


def _parquet_bytes(columns):
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.Table.from_arrays([c for _, c in columns], names=[n for n, _ in columns]), sink)
    return sink.getvalue().to_pybytes()


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | NUMBERS | st.text(max_size=6),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["position", "name", "header", "stamp", "sec", "x"]), inner, max_size=3)
    ),
    max_leaves=8,
)


def _mcap_bytes(messages):
    from mcap.writer import Writer

    with tempfile.SpooledTemporaryFile() as stream:
        writer = Writer(stream)  # pyright: ignore[reportArgumentType]
        writer.start()
        channels = {topic: writer.register_channel(topic, "json", 0) for topic in ("/goal", "/joint_states")}
        for topic, time, data in messages:
            writer.add_message(channels[topic], log_time=time, publish_time=time, data=data)
        writer.finish()
        stream.seek(0)
        return stream.read()


def _messages():
    data = JSON.map(lambda value: json.dumps(value).encode()) | st.binary(max_size=6)
    shaped = st.builds(lambda v: json.dumps({"position": v, "name": ["elbow"]}).encode(), st.lists(NUMBERS, max_size=2))
    one = st.tuples(st.sampled_from(["/goal", "/joint_states"]), st.integers(0, 2**64 - 1), data | shaped)
    return st.lists(one, max_size=8)


def _fuzz(robot, kind, content, mapping, tally):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"log.{kind}"
        path.write_bytes(content)
        tally.note(content, _outcome(lambda: _recording(robot, path, mapping)))


def _run(examples, strategy, check):
    settings(max_examples=examples, deadline=None, database=None, suppress_health_check=UNHURRIED)(
        given(strategy)(check)
    )()


def _assert_many(tally, examples):
    assert len(tally.given) >= 0.5 * min(examples, 1000)
    if examples == SLOW:
        assert len(tally.refused) >= 1000, f"{len(tally.refused)} of {len(tally.given)} were bad"


EXAMPLES = [QUICK, pytest.param(SLOW, marks=pytest.mark.slow)]


@pytest.mark.parametrize("examples", EXAMPLES)
@pytest.mark.parametrize("kind", ["csv", "npz", "parquet", "mcap"])
def test_logs(arm, good, kind, examples):
    if kind not in good:
        pytest.skip("MCAP needs the extra `mcap`: pip install 'estexp_jax[mcap]'")
    made = {
        "csv": _csv_text,
        "npz": lambda: _arrays().map(_npz_bytes),
        "parquet": lambda: _tables().map(_parquet_bytes),
    }
    made["mcap"] = lambda: _messages().map(_mcap_bytes)
    mutated = EDITS.map(lambda edits: _mutated(good[kind], edits))
    tally, mapping = Tally(), MCAP if kind == "mcap" else FLAT
    strategy = mutated | made[kind]() | st.tuples(made[kind](), EDITS).map(lambda pair: _mutated(*pair))
    _run(examples, strategy, lambda content: _fuzz(arm, kind, content, mapping, tally))
    _assert_many(tally, examples)


@pytest.mark.parametrize("examples", EXAMPLES)
def test_lerobot_data_sets(arm, tmp_path, examples):
    write_lerobot(tmp_path / "set", [_log()] * 2)
    info, data = tmp_path / "set/meta/info.json", tmp_path / "set/data/chunk-000/file-000.parquet"
    index = tmp_path / "set/meta/episodes/chunk-000/file-000.parquet"
    whole = {path: path.read_bytes() for path in (info, data, index)}
    keys = st.sampled_from(list(json.loads(whole[info])))
    paths = st.sampled_from(
        ["../../{file_index}.parquet", "/{file_index}.parquet", "{x}.parquet", "data/{file_index:99d}"]
    )
    changes = st.dictionaries(keys, JSON | paths, min_size=1, max_size=2)
    changed = changes.map(lambda c: (info, json.dumps(json.loads(whole[info]) | c).encode()))
    broken = st.tuples(st.sampled_from([info, data, index]), EDITS.filter(bool))
    strategy = changed | broken.map(lambda pair: (pair[0], _mutated(whole[pair[0]], pair[1])))
    tally = Tally()

    def check(change):
        path, content = change
        path.write_bytes(content)
        chosen = Selection(episode=1)
        tally.note(content, _outcome(lambda: _recording(arm, tmp_path / "set", LEROBOT, chosen)))
        path.write_bytes(whole[path])

    _run(examples, strategy, check)
    _assert_many(tally, examples)


HOSTILE = st.sampled_from(
    [
        "../../../../etc/passwd",
        "/etc/passwd",
        "/dev/zero",
        "a\\u0000.csv",
        "x" * 5000,
        "~",
        ".",
        "..",
        "log.csv/x",
        "C:\\\\x",
    ]
)
VALUES = st.sampled_from(
    ["nan", "inf", "-1e308", "1e308", "[]", "{}", "true", "1979-05-27", "9" * 400, '""', "[nan, 1]", "-1"]
)
VALUES |= st.sampled_from(["0x" + "f" * 5000, "9" * 400, "1e9999"])
WORDS = st.sampled_from(
    ["arm.xml", "log.csv", "time", "goal", "position", "servo", "kp", "mass", "1.0", "2.0", "0.0", '"train"', '"s"']
    + ["column", "unit", "scale", "offset", "[columns]", "[[recording]]", "file", "role", "sensor.angle", "ctrl.servo"]
)


@pytest.mark.parametrize("examples", EXAMPLES)
def test_manifests(good, tmp_path, examples):
    (tmp_path / "arm.xml").write_text(ARM)
    (tmp_path / "log.csv").write_bytes(good["csv"])
    swap = st.tuples(WORDS, WORDS | VALUES | HOSTILE | st.text(max_size=5))
    swapped = st.lists(swap, min_size=1, max_size=3)
    tally = Tally()

    def check(change):
        swaps, edits = change
        text = TOML
        for old, new in swaps:
            text = text.replace(old, new, 1)
        content = _mutated(text.encode("utf-8", "surrogatepass"), edits)
        (tmp_path / "recordings.toml").write_bytes(content)

        def attempt():
            for recording in read_manifest(tmp_path / "recordings.toml", mend=True).recordings:
                json.dumps(judge(Robot.from_string(ARM), recording), allow_nan=False)

        tally.note(content, _outcome(attempt))

    _run(examples, st.tuples(swapped, st.just([]) | EDITS), check)
    _assert_many(tally, examples)
