"""Measure several views relative to one view with the same number of pixels.

LP_NUM_THREADS=1 .venv/bin/python tools/measure_views.py [SCENARIO] [--size WxH] [--moments N]

A pair is an arrangement of views and one view with as many pixels; three channels are compared
with one flat wide window. Both are packed and drawn at the same moments of the tour, in turn, for
several ticks each. Figures are medians, ms: processor time of all threads and elapsed time of a
picture (upload, draw, show), and processor time of packing. The last column is the median ratio of
processor times, arrangement over one view.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from subsea.dive.start import headless, start_world
from subsea.dive.tour import Tour
from subsea.frame.packet import Packet, make_scene, pack
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.view.camera import NEAR_CM, off_axis
from subsea.view.display_rigs import cockpit, display_rig
from subsea.view.levels import LodState, empty_lod_state
from subsea.view.rig import CameraRig, DisplayPatch, Eye, views
from subsea.world.step import step
from subsea.world.world import World

Size = tuple[int, int]

CHANNEL_DEG = 45.0  # of a cylinder, that each of three channels shows
WARM_UP_TICKS = 30
BETWEEN_TICKS = 25
IN_A_ROW = 4  # pictures of one rig, after one that is not counted


def pixels_drawn(rig: CameraRig) -> int:
    """Pixels of the canvas that a rig's eyes fill."""
    return sum(eye.viewport[2] * eye.viewport[3] for eye in rig.eyes)


def one_view(pixels: int) -> CameraRig:
    """A plain display of 16:9 with this number of pixels."""
    height = round(np.sqrt(pixels * 9 / 16))
    return display_rig("mono", (round(pixels / height), height))


def channels(size: Size, turns_deg: tuple[float, ...], half_tangent: float) -> CameraRig:
    """Flat channels side by side; each is turned by an angle to the right of the observer."""
    width, height = size[0] // len(turns_deg), size[1]
    near = NEAR_CM * half_tangent
    frustum = off_axis(-near, near, -near * height / width, near * height / width)
    eyes = []
    for number, turn in enumerate(np.radians(turns_deg)):
        ahead = np.array([np.sin(turn), 0.0, np.cos(turn)])
        axes = np.array([[np.cos(turn), 0.0, -np.sin(turn)], [0.0, 1.0, 0.0], ahead])
        eyes.append(Eye((number * width, 0, width, height), np.zeros(3), axes, frustum))
    canvas = width * len(turns_deg), height
    whole = (0, 0, *canvas)
    return CameraRig(canvas, (canvas,), tuple(eyes), (DisplayPatch(whole, whole, whole),))


def three_channels(size: Size) -> tuple[CameraRig, CameraRig]:
    """Three channels of a cylinder, and one window that shows as much of it on a plane."""
    half = np.radians(CHANNEL_DEG) / 2
    three = channels(size, (-CHANNEL_DEG, 0.0, CHANNEL_DEG), float(np.tan(half)))
    return three, channels(three.canvas, (0.0,), float(np.tan(3 * half)))


def pairs(size: Size) -> dict[str, tuple[CameraRig, CameraRig]]:
    """Arrangements by name, each with one view of as many pixels."""
    width, height = size
    wide = 3 * (round(1.5 * width) // 3), round(height / 1.5)
    dome = 2 * (round(np.sqrt(width * height)) // 2)
    rigs = {
        "side-by-side": display_rig("side-by-side", size),
        "anaglyph": display_rig("anaglyph", size),
        "dome": display_rig("dome", (dome, dome)),
        "panorama": display_rig("panorama", size),
        "equirectangular": display_rig("equirectangular", size),
    }
    found = {name: (rig, one_view(pixels_drawn(rig))) for name, rig in rigs.items()}
    return {"three channels": three_channels(wide)} | found


class Measured:
    """A rig, what it drew last, and the times of its pictures."""

    def __init__(self, rig: CameraRig, world: World) -> None:
        """Start without measurements."""
        self.rig = rig
        self.memory: LodState = empty_lod_state(len(world.state.fishes.species))
        self.packets: list[Packet] = []
        self.packing: list[float] = []  # seconds of each, in the order of the packets
        self.drawing: list[float] = []
        self.wall: list[float] = []
        self.triangles: list[int] = []
        self.calls = 0

    def pack(self, world: World) -> None:
        """Pack the present tick."""
        quality = PRESETS["low"]
        start = time.thread_time()
        packet = pack(
            world, views(self.rig, cockpit(world.state.submarine, 1.0)), 1.0,
            options=quality.packing, memory=self.memory,
        )  # fmt: skip
        if self.packets:
            self.packing.append(time.thread_time() - start)
        self.packets.append(packet)

    def draw(self, context: Any, renderer: Renderer) -> None:
        """Draw the packets in a row, on a canvas of this rig alone."""
        renderer.arrange(self.rig)
        for number, packet in enumerate(self.packets):
            context.finish()
            wall, start = time.perf_counter(), time.process_time()
            renderer.draw(packet)
            context.finish()
            if number:
                self.drawing.append(time.process_time() - start)
                self.wall.append(time.perf_counter() - wall)
                self.triangles.append(renderer.triangles)
                self.calls = max(self.calls, renderer.draw_calls)
        self.packets = []


def moments(world: World, number: int) -> Iterator[Callable[[], None]]:
    """Moments of the tour, each as a function that advances by a tick."""
    tour = Tour()

    def tick() -> None:
        step(world, tour.helm(world))

    for k in range(number):
        for _ in range(BETWEEN_TICKS if k else WARM_UP_TICKS):
            tick()
        yield tick


def median(seconds: list[float]) -> float:
    """The median in milliseconds."""
    return 1000.0 * float(np.median(seconds))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario", nargs="?", default="peaceful")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--moments", type=int, default=8)
    parser.add_argument("--fish", type=int)
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    world = start_world(options.scenario, fish=options.fish)
    rigs = {
        name: tuple(Measured(rig, world) for rig in pair)
        for name, pair in pairs((width, height)).items()
    }
    mono = Measured(display_rig("mono", (width, height)), world)
    every = [mono, *(one for pair in rigs.values() for one in pair)]
    with headless() as context:
        renderer = Renderer(context, make_scene(world), mono.rig, PRESETS["low"])
        for number, tick in enumerate(moments(world, options.moments)):
            for _ in range(IN_A_ROW + 1):
                tick()
                for one in every:
                    one.pack(world)
            # Alternate the order.
            for one in every if number % 2 else every[::-1]:
                one.draw(context, renderer)
        name = context.info["GL_RENDERER"]
        renderer.release()
    print(f"{name}, {options.scenario}, {options.size}: medians of a picture, ms")
    print(f"{'':22s}{'pixels':>9s}{'views':>6s}{'draw':>7s}{'wall':>7s}{'pack':>6s}", end="")
    print(f"{'triangles':>10s}{'calls':>6s}{'ratio':>7s}")
    _line("mono", mono, None)
    for name, (arranged, plain) in rigs.items():
        _line(name, arranged, plain)
        _line("  one view", plain, None)


def _line(name: str, one: Measured, plain: Measured | None) -> None:
    print(
        f"{name:22s}{pixels_drawn(one.rig):9d}{len(one.rig.eyes):6d}{median(one.drawing):7.1f}"
        f"{median(one.wall):7.1f}{median(one.packing):6.2f}{np.mean(one.triangles):10.0f}"
        f"{one.calls:6d}",
        end="",
    )
    if plain is None:
        print()
    else:
        whole, other = (np.add(m.drawing, m.packing) for m in (one, plain))
        print(f"{np.median(whole / other):7.2f}")


if __name__ == "__main__":
    main()
