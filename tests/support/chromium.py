"""A headless Chromium that is told by its DevTools protocol through a pipe what to do."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome", "headless_shell")
PATIENCE = 40.0
"""Seconds within which anything that is waited for must come."""


def found() -> str | None:
    """Path of a Chromium on this machine."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


class Page:
    """One page: addresses, keys, scripts, and all that it asked of the network or complained of."""

    def __init__(self, into: int, out: int) -> None:
        self._into, self._out, self._number = into, out, 0
        self._rest = b""
        self._session = ""
        self.requests: list[str] = []
        self.complaints: list[str] = []
        target = self._ask("Target.createTarget", {"url": "about:blank"})["targetId"]
        attached = self._ask("Target.attachToTarget", {"targetId": target, "flatten": True})
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self._ask(f"{domain}.enable", {})

    def open(self, address: str) -> None:
        self._ask("Page.navigate", {"url": address})

    def size(self, width: int, height: int) -> None:
        view = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self._ask("Emulation.setDeviceMetricsOverride", view)

    def scheme(self, name: str) -> None:
        media = {"features": [{"name": "prefers-color-scheme", "value": name}]}
        self._ask("Emulation.setEmulatedMedia", media)

    def run(self, script: str) -> Any:
        """What an expression gives in the page."""
        asked = {"expression": script, "returnByValue": True, "awaitPromise": True}
        answer = self._ask("Runtime.evaluate", asked)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def wait(self, script: str) -> Any:
        """What an expression gives as soon as that is something."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with contextlib.suppress(AssertionError):
                if value := self.run(script):
                    return value
            time.sleep(0.05)
        raise AssertionError(f"{script} gives nothing; the page complains: {self.complaints}")

    def picture(self) -> bytes:
        """What is seen now, as PNG."""
        taken = self._ask("Page.captureScreenshot", {"format": "png"})
        return base64.b64decode(taken["data"])

    def choose(self, selector: str, files: Sequence[Path]) -> None:
        """Files are chosen at a field for files."""
        self._ask("DOM.enable", {})
        root = self._ask("DOM.getDocument", {})["root"]["nodeId"]
        node = self._ask("DOM.querySelector", {"nodeId": root, "selector": selector})["nodeId"]
        names = [str(file) for file in files]
        self._ask("DOM.setFileInputFiles", {"nodeId": node, "files": names})

    def drop(self, script: str, paths: Sequence[Path]) -> None:
        """Files and folders are dropped on the middle of an element."""
        x, y = self._middle(script)
        data = {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self._ask("Input.dispatchDragEvent", {"type": kind, "x": x, "y": y, "data": data})

    def key(self, name: str, text: str = "") -> None:
        for kind in ("keyDown", "keyUp"):
            own = {"type": kind, "key": name, "code": name}
            if text and kind == "keyDown":
                own["text"] = text
            codes = {
                "Enter": 13,
                "Tab": 9,
                "ArrowDown": 40,
                "ArrowRight": 39,
                "ArrowLeft": 37,
                " ": 32,
            }
            codes |= {"PageUp": 33}
            if name in codes:
                own["windowsVirtualKeyCode"] = codes[name]
            self._ask("Input.dispatchKeyEvent", own)

    def point(self, script: str, *, click: bool = False) -> None:
        """Move the mouse to the middle of an element, and click it if asked."""
        x, y = self._middle(script)
        at = {"x": x, "y": y}
        self._ask("Input.dispatchMouseEvent", {"type": "mouseMoved", **at})
        for kind in ("mousePressed", "mouseReleased") if click else ():
            pressed = {"type": kind, **at, "button": "left", "clickCount": 1}
            self._ask("Input.dispatchMouseEvent", pressed)

    def _middle(self, script: str) -> tuple[float, float]:
        """Of an element, brought into view."""
        self.run(f"({script}).scrollIntoView({{block: 'center'}})")
        box = f"(({script}).getBoundingClientRect())"
        x, y = self.run(f"[{box}.x + {box}.width / 2, {box}.y + {box}.height / 2]")
        return x, y

    def _ask(self, method: str, params: dict[str, Any]) -> dict[str, Any]:
        self._number += 1
        number = self._number
        message: dict[str, Any] = {"id": number, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._into, json.dumps(message).encode() + b"\0")
        while True:
            told = self._heard()
            if told.get("id") == number:
                assert "error" not in told, told["error"]
                return told["result"]
            self._noted(told)

    def _heard(self) -> dict[str, Any]:
        end = time.monotonic() + PATIENCE
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._out], [], [], max(end - time.monotonic(), 0.0))
            assert ready, "Chromium does not answer"
            self._rest += os.read(self._out, 1 << 20)
        text, _, self._rest = self._rest.partition(b"\0")
        return json.loads(text)

    def _noted(self, told: dict[str, Any]) -> None:
        method, params = told.get("method"), told.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.complaints.append(json.dumps(params["exceptionDetails"])[:500])
        elif method == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.complaints.append(params["entry"]["text"])


@contextlib.contextmanager
def chromium(path: str, profile: Path) -> Iterator[Page]:
    """A browser with one page, ended afterwards."""
    theirs_in, ours_in = os.pipe()
    ours_out, theirs_out = os.pipe()
    flags = "--headless --no-sandbox --disable-gpu --no-first-run --remote-debugging-pipe"
    line = f'exec "$0" {flags} --user-data-dir="$1" 3<&{theirs_in} 4>&{theirs_out}'
    process = subprocess.Popen(
        ["bash", "-c", line, path, str(profile)],
        pass_fds=(theirs_in, theirs_out),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(theirs_in)
    os.close(theirs_out)
    try:
        yield Page(ours_in, ours_out)
    finally:
        process.terminate()
        process.wait(10)
        os.close(ours_in)
        os.close(ours_out)
