"""docs/pictures/console.jpg: the presenter's console in a browser.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24") and Chromium: PYTHONPATH=. python docs/make_console_picture.py
"""

import socket
import threading
from contextlib import closing
from ipaddress import ip_address
from pathlib import Path
from tempfile import TemporaryDirectory

from picture_files import output_folder, save
from PIL import Image

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.dive.settings import DisplaySettings, Settings
from subsea.stage.console.options import ConsoleOptions, ListenAddress
from subsea.stage.parts import ConsolePart
from subsea.ui.dive import Dive
from tests.support.browser import browser

SIZE, PAGE = (640, 360), (1180, 820)


def main() -> None:
    """Draw a dive until its console was photographed."""
    display = DisplayOptions(size=SIZE, quality="medium")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    console = ConsolePart(ConsoleOptions(ListenAddress(ip_address("127.0.0.1"), port)))
    settings = Settings(display=DisplaySettings(introduction="off"))  # which has captions, too
    options = DiveOptions("rendezvous", seed=1, display=display, settings=settings, parts=[console])
    with closing(Dive(options)) as dive:
        dive.overlay.hide_help()
        with TemporaryDirectory() as folder:
            path = Path(folder) / "page.png"
            client = threading.Thread(target=_photograph, args=(port, path))
            client.start()
            while client.is_alive():
                dive.frame(0.033)
            with Image.open(path) as picture:
                save(picture.convert("RGB"), output_folder() / "console.jpg")


def _photograph(port: int, path: Path) -> None:
    with browser() as page:
        page.size(*PAGE)
        page.open(f"http://127.0.0.1:{port}/")
        page.until("document.getElementById('picture').naturalWidth > 0")
        page.run("document.getElementById('tour').value = 'directed'")
        page.run("document.getElementById('tour-form').requestSubmit()")
        page.until("document.getElementById('now').textContent.startsWith('On tour')")
        page.run("document.getElementById('caption').value = 'Welcome to the reef.'")
        page.run("document.getElementById('caption-form').requestSubmit()")
        page.until("document.getElementById('now').textContent.includes('Welcome')")
        page.run("new Promise(done => setTimeout(() => done(true), 4000))")
        page.screenshot(path)


if __name__ == "__main__":
    main()
