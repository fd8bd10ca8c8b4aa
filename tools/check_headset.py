"""Check the headset's session against the OpenXR runtime of this machine.

.venv/bin/python tools/check_headset.py [--frames N] [--kill PID] [--show]

Draws frames in a colour for each eye and for its place, reads each picture back before the runtime
gets it, and prints the states with their times, the sizes, the hands and the end of the session.
With --kill it ends the process of the runtime halfway, and expects a HeadsetLostError of one line.
It needs a display, but no headset: Monado has a simulated one (SIMULATED_ENABLE=1).
Exit code 0 if everything is as it should be, else 1.
"""

import argparse
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import glfw
import moderngl
import numpy as np

from subsea.base.errors import UserError
from subsea.stage.headset.controllers import HeadsetFrame, HeadsetLostError
from subsea.stage.headset.head import home_of, rotation_of
from subsea.stage.headset.openxr import OpenXrHeadset, open_headset

PATIENCE_S = 20.0  # until the session has the focus
BETWEEN_HANDS = 30  # frames
TOLERANCE = 2.5 / 255  # of a colour: two roundings


def main() -> int:
    """Run the check and print what happens; 0 if all is well."""
    options = _options()
    faults: list[str] = []
    with _window(options.show) as context:
        start = time.perf_counter()
        try:
            headset = open_headset()
        except UserError as fault:
            print(f"{fault}")
            return 1
        assert isinstance(headset, OpenXrHeadset)
        sizes = " and ".join(f"{width}x{height}" for width, height in headset.sizes)
        space = "sRGB" if headset.srgb else "RGBA"
        print(f"{headset.name}, pictures of {sizes} in {space}", flush=True)
        try:
            _draw(headset, context, options, start, faults)
            if options.kill:
                faults.append("the runtime ended, and no error said so")
        except HeadsetLostError as fault:
            print(f"{_since(start)} HeadsetLostError: {fault}")
            if not options.kill:
                faults.append(f"{fault}")
            elif "\n" in str(fault):
                faults.append("more than one line")
        before = time.perf_counter()
        headset.close()
        headset.close()  # again is fine
        print(f"{_since(start)} closed in {time.perf_counter() - before:.2f} s, {headset.state}")
        if not options.kill and headset.state not in ("EXITING", "IDLE"):
            faults.append(f"the session did not end: {headset.state}")
        if context.error != "GL_NO_ERROR":
            faults.append(f"OpenGL: {context.error}")
    for fault in faults:
        print(f"fault: {fault}")
    print("not well" if faults else "all is well")
    return 1 if faults else 0


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--kill", type=int, metavar="PID", help="of the runtime's process")
    parser.add_argument("--show", action="store_true", help="make the window visible")
    return parser.parse_args()


@contextmanager
def _window(show: bool) -> Iterator[Any]:
    """An OpenGL 3.3 core context on a window of X11."""
    glfw.init_hint(glfw.PLATFORM, glfw.PLATFORM_X11)  # OpenXR has no binding for EGL's contexts
    if not glfw.init():
        raise SystemExit("no display")
    glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, 3)
    glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, 3)
    glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
    glfw.window_hint(glfw.VISIBLE, show)
    window = glfw.create_window(320, 240, "headset", None, None)
    glfw.make_context_current(window)
    glfw.swap_interval(0)
    context = moderngl.create_context(require=330)
    print(f"OpenGL {context.info['GL_VERSION']}, {context.info['GL_RENDERER']}")
    try:
        yield context
    finally:
        glfw.destroy_window(window)
        glfw.terminate()


def _draw(
    headset: OpenXrHeadset,
    context: Any,
    options: argparse.Namespace,
    start: float,
    faults: list[str],
) -> None:
    """Draw frames until there are enough with the focus; add what is wrong to `faults`."""
    canvases: dict[int, Any] = {}
    state, drawn, waited, begun, first_eyes = "", 0, 0, 0.0, None
    deadline = time.perf_counter() + PATIENCE_S
    while drawn < options.frames:
        headset.poll()
        if headset.state != state:
            state = headset.state
            print(f"{_since(start)} {state}, worn {headset.worn}, focused {headset.focused}")
        if headset.focused and not begun:
            begun = time.perf_counter()
        if not headset.focused and time.perf_counter() > deadline:
            faults.append(f"no focus in {PATIENCE_S:.0f} s")
            return
        frame = headset.begin()
        if frame is None:
            time.sleep(0.01)
            continue
        if frame.visible:
            _check_eyes(frame, faults)
            for number, texture in enumerate(frame.textures):
                canvas = canvases.get(texture)
                if canvas is None:
                    canvas = canvases[texture] = _canvas(context, texture, headset.sizes[number])
                _paint(canvas, number, frame, faults)
            drawn += headset.focused
        waited += not frame.visible
        headset.end()
        if frame.visible and drawn % BETWEEN_HANDS == 1:
            _report(headset, frame, start)
        if headset.focused and drawn % 60 == 10:
            headset.pulse(drawn // 60 % 2, 0.5, 0.05)
        if options.kill and drawn == options.frames // 2:
            print(f"{_since(start)} end process {options.kill}", flush=True)
            os.kill(options.kill, signal.SIGKILL)
            options.kill, killed = -1, time.perf_counter()
            deadline = killed + PATIENCE_S
        if first_eyes is None and frame.tracked:
            first_eyes = frame.eyes
            print(f"{_since(start)} home {home_of(frame.eyes)}")
    seconds = time.perf_counter() - begun
    print(f"{_since(start)} {drawn} frames in {seconds:.2f} s, {drawn / seconds:.1f} a second; "
          f"{waited} more were not visible; {len(canvases)} textures")  # fmt: skip


def _canvas(context: Any, texture: int, size: tuple[int, int]) -> Any:
    wrapped = context.external_texture(texture, size, 4, 0, "f1")
    return context.framebuffer([wrapped])


def _paint(canvas: Any, number: int, frame: HeadsetFrame, faults: list[str]) -> None:
    """Fill a picture with a colour and its upper half with another; read both back."""
    height = frame.eyes[number].pose.position[1] % 1.0
    colours = [(1.0 - number, 0.0, float(number), 1.0), (0.0, float(height), 1.0, 1.0)]
    width, tall = canvas.size
    canvas.clear(*colours[0])
    canvas.clear(*colours[1], viewport=(0, tall // 2, width, tall - tall // 2))
    pixels = np.frombuffer(canvas.read(components=4, alignment=1), np.uint8)
    pixels = pixels.reshape(tall, width, 4) / 255.0
    for part, colour in zip((pixels[: tall // 2], pixels[tall // 2 :]), colours, strict=True):
        if np.abs(part - colour).max() > TOLERANCE:
            seen = part.reshape(-1, 4).mean(0).round(3)
            faults.append(f"eye {number} is {seen}, not {np.round(colour, 3)}")


def _check_eyes(frame: HeadsetFrame, faults: list[str]) -> None:
    """The left eye is to the left, and the angles are those of a picture."""
    left, right = frame.eyes
    apart = rotation_of(left.pose.orientation).T @ (right.pose.position - left.pose.position)
    if not 0.05 < apart[0] < 0.08:
        faults.append(f"the right eye is {apart} m from the left one")
    odd = [eye for eye in frame.eyes if eye.left >= eye.right or eye.down >= eye.up]
    faults.extend(f"odd angles: {eye}" for eye in odd)


def _report(headset: OpenXrHeadset, frame: HeadsetFrame, start: float) -> None:
    aims = [
        "not tracked" if hand.aim is None else f"{np.round(hand.aim.position, 3)}"
        for hand in headset.hands
    ]
    others = [tuple(hand)[1:] for hand in headset.hands]
    eye = frame.eyes[0].pose
    print(f"{_since(start)} left eye at {np.round(eye.position, 3)}, tracked {frame.tracked}; "
          f"hands at {aims[0]} and {aims[1]}, {others}")  # fmt: skip


def _since(start: float) -> str:
    return f"{time.perf_counter() - start:7.3f} s"


if __name__ == "__main__":
    sys.exit(main())
