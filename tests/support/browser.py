"""A headless Chromium, driven by its DevTools protocol."""

import asyncio
import base64
import json
import shutil
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import aiohttp

START_S, ANSWER_S = 60.0, 60.0  # a busy machine takes its time
FLAGS = (
    "--headless=new", "--no-sandbox", "--no-first-run", "--mute-audio",
    "--disable-background-networking", "--disable-component-update", "--ignore-certificate-errors",
    "--remote-debugging-port=0", "--disable-dev-shm-usage",
)  # fmt: skip
# Draws WebGL without a GPU.
WEBGL = "--use-angle=swiftshader", "--enable-unsafe-swiftshader"


class Browser:
    """One page. Calls wait for the browser, which runs in a thread and process of its own."""

    def __init__(self, port: int) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._number = 0
        self._socket: Any = None
        self._session: Any = None
        self.logged: list[str] = []  # errors and warnings of the page, such as those of its CSP
        self._wait(self._connect(port))
        for domain in ("Page", "Runtime", "Log", "Accessibility"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **values: Any) -> Any:
        """Call a method of the protocol; returns its result."""
        return self._wait(self._call(method, values))

    def open(self, url: str) -> None:
        """Open a page."""
        self.call("Page.navigate", url=url)
        self.until("document.readyState === 'complete'")

    def run(self, script: str) -> Any:
        """The value of an expression in the page."""
        found = self.call(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def until(self, script: str, seconds: float = ANSWER_S) -> Any:
        """Wait until an expression is true; returns it."""
        end = time.monotonic() + seconds
        while not (value := self.run(script)):
            assert time.monotonic() < end, f"{script}; the page logged {self.logged}"
            time.sleep(0.05)
        return value

    def press(self, key: str, text: str = "", shift: bool = False) -> None:
        """Press and release a key, such as Tab."""
        codes = {"Tab": 9, "Enter": 13, " ": 32, "ArrowDown": 40, "ArrowLeft": 37}
        about = {"key": key, "windowsVirtualKeyCode": codes.get(key, 0), "modifiers": 8 * shift}
        kind = "keyDown" if text else "rawKeyDown"
        self.call("Input.dispatchKeyEvent", type=kind, text=text, **about)
        self.call("Input.dispatchKeyEvent", type="keyUp", **about)

    def type(self, text: str) -> None:
        """Type a text into what has the focus."""
        self.call("Input.insertText", text=text)

    def size(self, width: int, height: int) -> None:
        """Set the size of the page in pixels."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=False)  # fmt: skip

    def screenshot(self, path: Path, kind: str = "png") -> None:
        """Save a picture of the page."""
        data = self.call("Page.captureScreenshot", format=kind, captureBeyondViewport=False)["data"]
        path.write_bytes(base64.b64decode(data))

    def tree(self) -> list[dict[str, Any]]:
        """The page as a screen reader finds it: role, name and properties of each part."""
        nodes = self.call("Accessibility.getFullAXTree")["nodes"]
        return [
            {
                "role": node["role"]["value"],
                "name": node.get("name", {}).get("value", ""),
                **{one["name"]: one["value"].get("value") for one in node.get("properties", ())},
            }
            for node in nodes
            if not node.get("ignored") and "role" in node
        ]

    def close(self) -> None:
        """End the connection."""
        self._wait(self._socket.close())
        self._wait(self._session.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _wait(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(ANSWER_S)

    async def _connect(self, port: int) -> None:
        self._session = aiohttp.ClientSession()
        async with self._session.get(f"http://127.0.0.1:{port}/json/list") as answer:
            pages = await answer.json()
        page = next(one for one in pages if one["type"] == "page")
        self._socket = await self._session.ws_connect(
            page["webSocketDebuggerUrl"], max_msg_size=1 << 26
        )

    async def _call(self, method: str, values: dict[str, Any]) -> Any:
        self._number += 1
        await self._socket.send_json({"id": self._number, "method": method, "params": values})
        while True:
            message = json.loads((await self._socket.receive(ANSWER_S)).data)
            if message.get("id") == self._number:
                assert "error" not in message, message["error"]
                return message["result"]
            if message.get("method") == "Log.entryAdded":
                self.logged.append(message["params"]["entry"]["text"])
            if message.get("method") == "Runtime.exceptionThrown":
                self.logged.append(str(message["params"]["exceptionDetails"]))


@contextmanager
def browser(webgl: bool = False) -> Iterator[Browser]:
    """A browser with an empty page, with or without WebGL; it ends with the block."""
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
    assert program is not None, "chromium is missing: `apt install chromium`"
    flags = [*FLAGS, *(WEBGL if webgl else ["--disable-gpu"])]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [program, f"--user-data-dir={profile}", *flags, "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        try:
            port = Path(profile) / "DevToolsActivePort"
            end = time.monotonic() + START_S
            while not port.exists() or not port.read_text().strip():
                assert process.poll() is None, "chromium has ended"
                assert time.monotonic() < end, "chromium does not start"
                time.sleep(0.05)
            page = Browser(int(port.read_text().split()[0]))
            try:
                yield page
            finally:
                page.close()
        finally:
            process.kill()
            process.wait()
