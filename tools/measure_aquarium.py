"""Measure WebGL Aquarium in Chromium on the software rasteriser, beside `subsea benchmark`.

.venv/bin/python tools/measure_aquarium.py FOLDER [FISH …] [--frames N]

FOLDER is a checkout of github.com/WebGLSamples/WebGLSamples.github.io with all its assets. Prints
the processor time of all processes of Chromium per frame of 1280x720 pixels, to be compared with
`cpu_ms`, `all`, of `subsea benchmark --size 1280x720`. A pixel is read back at the start of each
frame, so that a frame is counted when it is drawn. Needs a display, such as that of xvfb-run.
"""

import argparse
import subprocess
import tempfile
import threading
import time
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlparse

import psutil

WARM_FRAMES = 25  # before the measurement: textures and shaders are loaded
MOST_S = 300.0
COUNTING = b"""<script>(function () {
  let frames = 0;
  const next = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = callback => next(time => {
    if (window.gl)
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    frames++;
    callback(time);
  });
  setInterval(() => {
    const info = window.gl && gl.getExtension('WEBGL_debug_renderer_info');
    const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
    fetch('/count?frames=' + frames + '&renderer=' + encodeURIComponent(name));
  }, 250);
})();</script>"""


class Site(SimpleHTTPRequestHandler):
    """The folder, with a page that counts its frames."""

    counted: tuple[int, str] = 0, ""  # frames so far and the renderer

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing."""

    def do_GET(self) -> None:
        """Answer a request."""
        at = urlparse(self.path)
        if at.path == "/count":
            said = parse_qs(at.query, keep_blank_values=True)
            Site.counted = int(said["frames"][0]), said["renderer"][0]
            self.send_response(204)
            self.end_headers()
        elif at.path == "/aquarium/aquarium.html":
            page = Path(self.translate_path(at.path)).read_bytes()
            page = page.replace(b"<head>", b"<head>" + COUNTING, 1)
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.send_header("Content-Length", str(len(page)))
            self.end_headers()
            self.wfile.write(page)
        else:
            super().do_GET()


def main() -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("fish", nargs="*", type=int, default=[60, 10_000, 30_000])
    parser.add_argument("--frames", type=int, default=40)
    options = parser.parse_args()
    site = partial(Site, directory=str(options.folder))
    with ThreadingHTTPServer(("127.0.0.1", 0), site) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        for fish in options.fish:
            query = f"numFish={fish}&canvasWidth=1280&canvasHeight=720"
            address = f"http://127.0.0.1:{server.server_port}/aquarium/aquarium.html?{query}"
            print(f"{fish} fishes: {measured(address, options.frames)}", flush=True)
        server.shutdown()


def measured(address: str, frames: int) -> str:
    """The processor time of a frame, as a text."""
    Site.counted = 0, ""
    flags = (
        "--no-sandbox", "--window-size=1280,900", "--use-gl=angle", "--use-angle=gl-egl",
        "--ignore-gpu-blocklist", "--no-first-run", "--disable-gpu-vsync",
        "--disable-frame-rate-limit",
    )  # fmt: skip
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = psutil.Popen(
            ["chromium", f"--user-data-dir={profile}", *flags, address],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        try:
            first = _wait(WARM_FRAMES)
            start = _spent(browser)
            last = _wait(first + frames)
            spent = _spent(browser) - start
        finally:
            for one in [*browser.children(recursive=True), browser]:
                one.kill()
            browser.wait()
    return f"{1e3 * spent / (last - first):.1f} ms a frame of {last - first}, {Site.counted[1]}"


def _wait(frames: int) -> int:
    """Wait for a number of frames; returns the number by then."""
    end = time.monotonic() + MOST_S
    while Site.counted[0] < frames:
        if time.monotonic() > end:
            raise SystemExit(f"measure_aquarium: no {frames} frames within {MOST_S:g} s")
        time.sleep(0.02)
    return Site.counted[0]


def _spent(browser: psutil.Process) -> float:
    """Processor time, s, of a process and its children."""
    times = [one.cpu_times() for one in [browser, *browser.children(recursive=True)]]
    return sum(one.user + one.system for one in times)


if __name__ == "__main__":
    main()
