"""Make the picture of docs/how-to/export-scene.md: one moment in the dive, a browser and Blender.

Run from the root of a checkout with Chromium after `make blender`:
PYTHONPATH=. python docs/make_export_scene_picture.py
"""

import functools
import http.server
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

from picture_files import output_folder, save
from PIL import Image, ImageDraw, ImageFont

from subsea.cli.main import main as subsea
from tests.support.browser import browser

SCENE, START_S, FPS, FRAMES = "peaceful", 16.0, 30, 3
WHAT = ["--start", str(START_S), "--seconds", str(FRAMES / FPS), "--fish", "60"]
SIZE = 640, 360
SHOWN = 426, 240
BLENDER = Path(".venv/blender/bin/python")


def main() -> None:
    """Film, export and open the scene."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        size = ["--size", f"{SIZE[0]}x{SIZE[1]}"]
        pictures = {"dive": folder / "films", "browser": folder / "web.png",
                    "Blender": folder / "blender.png"}  # fmt: skip
        # A folder of frames, as a single picture would show the end of the last one.
        subsea(["film", str(pictures["dive"]), "--scenario", SCENE, *WHAT, *size])
        pictures["dive"] = sorted(pictures["dive"].glob("*.png"))[-1]
        subsea(["export", SCENE, "--to", "web", "--out", str(folder / "web"), *WHAT, *size])
        _in_browser(folder / "web", pictures["browser"])
        command = [BLENDER, "tools/blender_scene.py", folder / "web/scene.glb", FPS, FRAMES - 1,
                   folder / "points.npz", pictures["Blender"]]  # fmt: skip
        subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL)
        whole = Image.new("RGB", (SHOWN[0] * len(pictures), SHOWN[1]))
        for k, (name, path) in enumerate(pictures.items()):
            shown = Image.open(path).convert("RGB").resize(SHOWN, Image.Resampling.LANCZOS)
            whole.paste(shown, (k * SHOWN[0], 0))
            place = (k * SHOWN[0] + 8, 5)
            ImageDraw.Draw(whole).text(place, name, "white", ImageFont.load_default(15))
        save(whole, output_folder() / "exported-scene.jpg")


def _in_browser(site: Path, picture: Path) -> None:
    """Photograph the page at the last frame, without its controls."""
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=site)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with browser(webgl=True) as page:
            page.size(*SIZE)
            still = [{"name": "prefers-reduced-motion", "value": "reduce"}]
            page.call("Emulation.setEmulatedMedia", features=still)
            page.open(f"http://127.0.0.1:{server.server_address[1]}/index.html")
            page.until("window.viewer !== undefined")
            page.run(
                "for (const one of document.querySelectorAll('header, nav, footer'))"
                " one.hidden = true;"
                f"viewer.seek({(FRAMES - 1) / FPS}); viewer.draw()"
            )
            page.screenshot(picture)
        server.shutdown()


if __name__ == "__main__":
    sys.exit(main())
