"""Long work of a workbench, waited for."""

from __future__ import annotations

import time

MINUTE = 60.0


def waited(browser):
    """The state when the long work is over."""
    end = time.monotonic() + MINUTE
    while time.monotonic() < end:
        state = browser.get("/api/state").json
        if state["job"]["stand"] != "running":
            return state
        time.sleep(0.02)
    raise AssertionError("the work does not end")


def done(browser, what, **asked):
    """The state after some work."""
    state = browser.get("/api/state").json
    answer = browser.post(f"/api/{what}", {"revision": state["revision"], **asked})
    assert answer.status == 200, answer.text
    after = waited(browser)
    assert after["job"]["stand"] in ("done", "idle"), after["job"]
    return after
