"""Dive in the headset of this machine's OpenXR runtime, and keep what its eyes saw.

.venv/bin/python -m tools.check_headset_dive FOLDER [--frames N] [--kill PID]

Writes the pictures of the first, middle and last frame, as they are given to the runtime, and one
of the window. Then asks the runtime to end the session, or ends its process with --kill, and
expects the dive to go on in the window. Exit code 0 if it does.
"""

import argparse
import os
import signal
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from PIL import Image

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.stage.headset.openxr import OpenXrHeadset
from subsea.stage.parts import HeadsetPart
from subsea.ui.dive import Dive

WINDOW = 640, 360
AFTER_S = 20.0  # in which the dive must have left the headset


def main() -> int:
    """Dive, and print what happens."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--kill", type=int, metavar="PID", help="of the runtime's process")
    parser.add_argument("--scenario", default="peaceful")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    display = DisplayOptions("headset", WINDOW, quality="low")
    start = time.perf_counter()
    with closing(
        Dive(DiveOptions(options.scenario, seed=1, display=display, parts=[HeadsetPart()]))
    ) as dive:
        head = dive.picture.head
        if head is None:
            return 1
        headset = head.headset
        assert isinstance(headset, OpenXrHeadset)
        print(f"{headset.name}, pictures of {headset.sizes}")
        context, state, last = moderngl.create_context(), "", time.perf_counter()
        drawn, ticks = 0, 0
        keep = _Keeper(headset, context)
        while drawn < options.frames:
            now = time.perf_counter()
            dive.frame(now - last)
            last = now
            if headset.state != state:
                state = headset.state
                print(f"{now - start:7.2f} s {state}")
            if not headset.focused:
                continue
            if drawn in (0, options.frames // 2, options.frames - 2):  # kept with the next frame
                keep.path = options.folder / f"eyes-{drawn}.png"
                hands = [hand.aim and hand.aim.position.round(2) for hand in headset.hands]
                print(f"{now - start:7.2f} s frame {drawn}: head {head.eyes[0].pose.position}, "
                      f"hands {hands}, tick {dive.world.state.tick}")  # fmt: skip
            drawn += 1
            ticks = dive.world.state.tick
        Image.fromarray(dive.window_set.picture()).save(options.folder / "window.png")
        if options.kill:
            os.kill(options.kill, signal.SIGKILL)
        else:
            headset._xr.request_exit_session(headset._session)
        until = time.perf_counter() + AFTER_S
        while dive.picture.head is not None and time.perf_counter() < until:
            dive.frame(0.05)
        for _ in range(10):
            dive.frame(0.1)
        went_on = dive.picture.head is None and dive.world.state.tick > ticks
        print(f"{time.perf_counter() - start:7.2f} s in the window: {went_on}, "
              f"tick {dive.world.state.tick}")  # fmt: skip
    return 0 if went_on else 1


class _Keeper:
    """Writes the pictures of a session's next frame, side by side, before the runtime gets them."""

    def __init__(self, headset: OpenXrHeadset, context: Any) -> None:
        self.path: Path | None = None  # of the next one
        self._begin, self._end, self._context = headset.begin, headset.end, context
        self._sizes, self._textures = headset.sizes, ()
        headset.begin, headset.end = self.begin, self.end  # type: ignore[method-assign]

    def begin(self) -> Any:
        frame = self._begin()
        self._textures = () if frame is None else frame.textures
        return frame

    def end(self) -> None:
        if self.path is not None and self._textures:
            eyes = [self._read(*eye) for eye in zip(self._textures, self._sizes, strict=True)]
            Image.fromarray(np.concatenate(eyes, axis=1)).save(self.path)
            self.path = None
        self._end()

    def _read(self, texture: int, size: tuple[int, int]) -> Any:
        seen = self._context.external_texture(texture, size, 4, 0, "f1")
        canvas = self._context.framebuffer([seen])
        data = np.frombuffer(canvas.read(components=3, alignment=1), np.uint8)
        canvas.release()
        return data.reshape(size[1], size[0], 3)[::-1]


if __name__ == "__main__":
    sys.exit(main())
