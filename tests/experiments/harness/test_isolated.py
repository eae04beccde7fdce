"""Calls in a process of their own: what they give, and that they ended, hung or failed."""

import os
import time

from experiments.harness.isolated import isolated


def called(what: str) -> dict[str, object]:
    if what == "end":
        os._exit(1)
    if what == "hang":
        time.sleep(60.0)
    if what == "fail":
        raise IndexError("out of bounds")
    return {"result": what}


def test_a_process_that_ends_hangs_or_fails_does_not_stop_the_others() -> None:
    names = ("good", "end", "fail", "hang", "better")
    found = list(isolated(called, [(name,) for name in names], 20.0))
    assert [row["result"] for row in found] == ["good", "crashed", "crashed", "crashed", "better"]
    messages = [row.get("message") for row in found]
    assert messages == [None, "the process ended", "IndexError: out of bounds", "no end within 20 s", None]
