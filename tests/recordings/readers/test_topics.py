"""Messages of several topics: clocks, stamps that were never set, and names that change places."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.topics import TopicMerger
from estexp_jax.recordings.table import Selection

UNIX = 1_700_000_000_000_000_000
WANTED = frozenset({"/cmd.x", "/state.x"})


def _same(message):
    return message


def _merged(messages, wanted: frozenset[str] | None = WANTED, **selection):
    """The table of (topic, log time in ns, message), each published 5 ns before."""
    merger, notes = TopicMerger("a.log", Selection(wanted=wanted, **selection)), []
    for topic, time, message in messages:
        if merger.open(topic, topic, lambda: _same):
            merger.add(topic, message, time, time - 5)
    return merger.table(notes)


def _stamped(topic, log, stamp, x):
    return topic, log, {"header": {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}}, "x": x}


def _log(command_stamp, state_stamp, n=10):
    rows = [(UNIX + k * 5_000_000, k * 5_000_000) for k in range(n)]
    commands = [_stamped("/cmd", log, command_stamp(t), float(k)) for k, (log, t) in enumerate(rows)]
    return commands + [_stamped("/state", log + 10, state_stamp(t), float(-k)) for k, (log, t) in enumerate(rows)]


def _unix(t):
    return UNIX + t


def _never(t):
    return 0


def test_stamps_that_were_never_set_are_refused():
    with pytest.raises(InputError, match=r"a\.log: /cmd\.x: 10 of 10 messages have the stamp 0 on the clock 'header'"):
        _merged(_log(_never, _unix), clock="header")
    with pytest.raises(InputError, match=r"all stamps are 0 on the clock 'header'; another clock: clock = \"log\""):
        _merged(_log(_never, _never), clock="header")


def test_a_column_may_have_a_clock_of_its_own():
    table = _merged(_log(_never, _unix), clock="header", clocks={"/cmd.x": "log"})
    np.testing.assert_array_equal(table.column("/cmd.x"), np.arange(10.0))
    np.testing.assert_allclose(table.column("time"), np.arange(10) * 0.005, atol=1e-9)


def test_single_stamps_that_were_not_set_are_left_out_and_told():
    table = _merged(_log(_unix, lambda t: _unix(t) if t > 10_000_000 else 0), clock="header")
    np.testing.assert_array_equal(table.column("/state.x"), [np.nan] * 3 + [-3.0, -4, -5, -6, -7, -8, -9])
    assert table.notes == ("/state.x: 3 of 10 messages have the stamp 0 on the clock 'header': they are left out",)


def test_stamps_that_most_messages_share_are_refused():
    with pytest.raises(InputError, match=r"/cmd\.x: 10 messages have 1 different times .* clock = \"log\""):
        _merged(_log(lambda t: UNIX, _unix), clock="header")
    burst = [("/cmd", UNIX + 10 * (k // 3), {"x": float(k)}) for k in range(9)]
    with pytest.raises(InputError, match=r"9 messages have 3 different times .* clock = \"header\""):
        _merged(burst, frozenset({"/cmd.x"}))
    assert _merged(burst, None).names == ("time", "/cmd.x")  # nobody may need it


def test_a_clock_that_begins_at_0_is_one():
    table = _merged(_log(lambda t: t, lambda t: t), clock="header")
    np.testing.assert_allclose(table.column("time"), np.arange(10) * 0.005)
    assert table.column("/cmd.x")[0] == 0.0 and not table.notes


def test_foxglove_stamps_and_messages_without_any():
    message = {"timestamp": {"sec": 3, "nsec": 7}, "x": 1.0}
    table = _merged(
        [("/cmd", 0, message), ("/cmd", 1, {**message, "timestamp": {"sec": 4, "nsec": 7}})], clock="header"
    )
    np.testing.assert_array_equal(table.column("time"), [0.0, 1.0])
    with pytest.raises(InputError, match=r"topic '/cmd': a message has no time on the clock 'header'.*for this column"):
        _merged([("/cmd", 0, {"x": 1.0})], clock="header")


def test_an_index_that_leads_to_another_joint_than_before_is_refused():
    one, two = ({"joint_names": names, "q": [1.0, 2.0]} for names in (["a", "b"], ["b", "a"]))
    messages = [("/s", 0, one), ("/s", 5, one), ("/s", 9, two)]
    with pytest.raises(InputError, match=r"the names changes: .q\[0\] is 'a' in one message and 'b' in another"):
        _merged(messages, frozenset({"/s.q[0]"}))
    assert _merged(messages, frozenset({"/s.q[b]"})).column("/s.q[b]").tolist() == [2.0, 2.0, 1.0]
    assert _merged(messages[:2], frozenset({"/s.q[0]"})).column("/s.q[0]").tolist() == [1.0, 1.0]
    assert set(_merged(messages, None).names) == {"time", "/s.q[a]", "/s.q[b]"}


def test_a_message_without_the_joint_is_no_sample():
    both = [({"name": ["elbow"], "q": [1.0]}), ({"name": ["finger", "thumb"], "q": [9.0, 7.0]})]
    table = _merged([("/s", k, both[k % 2]) for k in range(6)], frozenset({"/s.q[elbow]"}))
    assert table.column("/s.q[elbow]").tolist() == [1.0, 1.0, 1.0]


def test_a_message_may_be_a_number_itself():
    assert _merged([("/x", 1, 2.5), ("/x", 2, False), ("/x", 3, "text")], None).column("/x").tolist() == [2.5, 0.0]
