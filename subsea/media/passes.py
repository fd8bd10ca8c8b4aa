"""Passes of a film for compositing: light before it is developed, and data beside it.

Light is the mean of the pictures of a frame, with the blur of motion and lens. Depth, normals and
motion are those of a pinhole when the shutter opens, at the middle of each pixel: a mean of them
would be of no use. The film waits with a frame until the next one is known, to which motion leads.
"""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError, unknown
from subsea.dive.ride import MOST_FISHES, VALUES, values_of
from subsea.frame.packet import FISH as NUMBER
from subsea.frame.packet import Packet
from subsea.media.cryptomatte import Matte, matte
from subsea.media.exr import camera_header, picture_header
from subsea.media.flow import FlowMoment, SeenMaps, body_flow, moment_of, skin_moved
from subsea.rendering.fish.bodies import Shapes, levels_of
from subsea.rendering.gl.id_buffer import KINDS, NUMBERED, IdMaps
from subsea.rendering.output.passes import LightParts
from subsea.rendering.renderer import Renderer
from subsea.view.camera import View
from subsea.view.optics import Optics
from subsea.world.world import World

PASSES = "beauty", "water", "depth", "normal", "motion", "cryptomatte"
ALL = "all"
COVERAGE = 16  # least number of places of a pixel whose identity Cryptomatte counts
FAR_CM = 1e10  # depth of open water: programs can blur by it, but not by infinity
OPENCV = np.diag([1.0, -1.0, -1.0, 1.0])  # from axes x right, y up to x right, y down, z ahead

Write = Callable[[int, dict[str, Array], dict[str, Any]], None]  # a frame: channels and header


def read_passes(text: str) -> tuple[str, ...]:
    """Read names of passes, separated by commas; a UserError for an unknown one.

    `beauty` is always among them.
    """
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in (*PASSES, ALL):
            raise unknown("pass", name, [*PASSES, ALL])
    return tuple(name for name in PASSES if name in names or name == "beauty" or ALL in names)


class _Frame(NamedTuple):
    """A frame whose pictures are taken, or the moment of one that is not wanted."""

    number: int
    view: View
    moment: FlowMoment | None  # without the pass of motion there is none
    frame: int  # of a time code
    maps: IdMaps | None = None  # of a wanted frame
    who: Ints = np.zeros(0, np.int64)  # fishes in the picture, and their levels of detail
    levels: Ints = np.zeros(0, np.int64)
    cut: bool = False  # the camera has leapt before it


class PassFrames:
    """Takes the pictures of frames, and writes each frame when the next one has begun."""

    def __init__(
        self, world: World, renderer: Renderer, passes: tuple[str, ...], rate: Fraction,
        write: Write,
    ) -> None:  # fmt: skip
        """Prepare for the first frame; a UserError for a sea with too many fishes."""
        if len(world.state.fishes.species) > MOST_FISHES:
            raise UserError(f"Cryptomatte holds at most {MOST_FISHES} fishes")
        self._world, self._renderer, self._passes = world, renderer, passes
        self._rate, self._write = rate, write
        self._before: _Frame | None = None
        self._now: _Frame | None = None  # waits for the next
        self._light: dict[str, Array] = {}  # channels of the frame that waits
        self._sums: list[Array] = []
        self._samples: list[NDArray[np.uint16]] = []  # identities at places of pixels
        self._pictures = 0
        self._mattes = mattes(world) if "cryptomatte" in passes else ()
        lengths = tuple(float(x) for x in world.library.recorded_length)
        self._shapes = Shapes(world.species, lengths) if "motion" in passes else None
        renderer.resume()  # the shapes are computed in a context of their own

    def begin(self, number: int, packet: Packet, alpha: float, cut: bool, wanted: bool) -> None:
        """Begin a frame with its packet through a pinhole, drawn before if `wanted`.

        Each frame of a film begins, wanted or not, and one more at its end.
        """
        view = packet.views[0]
        counted = round(packet.time_s * self._rate)
        moment = moment_of(self._world, OPENCV @ view.view, alpha) if self._shapes else None
        frame = _Frame(number, view, moment, counted, cut=cut)
        if self._now is not None:
            self._finish(frame)
        if wanted:
            who, first = np.unique(packet.instances[:, NUMBER].astype(np.int64), return_index=True)
            frame = frame._replace(
                maps=self._renderer.id_maps(packet), who=who, levels=levels_of(packet)[first]
            )
        self._before, self._now = self._now, frame

    def add(self, packet: Packet, pictures: int) -> None:
        """Add a picture of the exposure, which was drawn last, of this number of `pictures`."""
        if "water" in self._passes:
            parts = self._renderer.light_parts(packet)
            before = self._sums or [np.zeros_like(part) for part in parts]
            self._sums = [a + b for a, b in zip(before, parts, strict=True)]
        if self._mattes:
            places = -(-COVERAGE // pictures)
            for place in range(places * self._pictures, places * (self._pictures + 1)):
                views = tuple(beside(view, *pixel_place(place)) for view in packet.views)
                seen = self._renderer.id_maps(replace(packet, views=views))
                self._samples.append(values_of(seen).astype(np.uint16))
        self._pictures += 1

    def expose(self) -> None:
        """End the exposure: the picture of the renderer is the mean of what was added."""
        # A shader may give less than no light where a triangle is seen edge-on.
        light = np.maximum(self._renderer.light(), 0.0)
        channels: dict[str, Array] = {}
        if self._sums:
            parts = LightParts(*(total / self._pictures for total in self._sums))
            share = parts.transmittance.astype(np.float16)
            subject = np.maximum(parts.subject(share.astype(np.float32)), 0.0)
            light = np.maximum(light, parts.veil)
            channels = _rgb("subject.", subject) | {"subject.A": parts.cover}
            channels |= _rgb("transmittance.", share) | _rgb("veil.", parts.veil)
        channels |= _rgb("", light) | {"A": np.ones(light.shape[:2])}
        self._light = {name: part.astype(np.float16) for name, part in channels.items()}
        for one in self._mattes:
            self._light |= one.channels(np.array(self._samples))
        self._sums, self._samples, self._pictures = [], [], 0

    def _finish(self, after: _Frame) -> None:
        """Write the frame that waits."""
        now = self._now
        if now is None or now.maps is None:
            return
        channels, maps = dict(self._light), now.maps
        focal_px = 0.5 * maps.depth.shape[1] * float(now.view.projection[0, 0])
        if "depth" in self._passes:
            channels["Z"] = np.minimum(maps.depth, np.float32(FAR_CM))
        if "normal" in self._passes:
            # From the axes of the camera to those of the world: times the inverse of a turn.
            normal = np.nan_to_num(maps.normals(focal_px)) @ (OPENCV @ now.view.view)[:3, :3]
            channels |= _channels("N.", "XYZ", normal.astype(np.float16))
        if "motion" in self._passes:
            channels |= self._motion(now, after, maps, focal_px)
        header = picture_header(self._rate, now.frame) | camera_header(now.view)
        for one in self._mattes:
            header |= one.header()
        self._write(now.number, channels, header)

    def _motion(
        self, now: _Frame, after: _Frame, maps: IdMaps, focal_px: float
    ) -> dict[str, Array]:
        """The channels of motion: none at the film's beginning, and none over a cut."""
        before = self._before or now
        height, width = maps.depth.shape
        field_deg = float(np.degrees(2.0 * np.arctan(0.5 * width / focal_px)))
        assert now.moment and before.moment and after.moment and self._shapes
        seen = SeenMaps(
            Optics((width, height), field_deg), now.moment.matrix, values_of(maps), maps.depth
        )
        others = (
            now.moment if now.cut else before.moment,
            now.moment if after.cut else after.moment,
        )
        moved = skin_moved(seen, self._shapes, now.moment, others, now.who, now.levels)
        self._renderer.resume()
        everyone = np.arange(len(now.moment.instances))
        out: dict[str, Array] = {}
        flows = body_flow(seen, moved, now.moment, everyone, others)
        for name, flow in zip(("backward", "forward"), flows, strict=True):
            up = np.nan_to_num(flow) * (1.0, -1.0)
            out |= _channels(f"{name}.", "uv", up.astype(np.float32))
        return out


def _rgb(layer: str, light: Array) -> dict[str, Array]:
    return _channels(layer, "RGB", light)


def _channels(layer: str, names: str, values: Array) -> dict[str, Array]:
    return {f"{layer}{name}": values[..., k] for k, name in enumerate(names)}


def mattes(world: World) -> tuple[Matte, ...]:
    """The mattes of a world: each fish, each species, and each other thing.

    Fishes have the names that `--follow` takes, such as ``clownfish:0``.
    """
    first, kinds = VALUES["fish"], world.state.fishes.species
    fishes, species = {}, {}
    counted = dict.fromkeys(world.scenario.species, 0)
    for number, kind in enumerate(kinds):
        name = species[first + number] = world.scenario.species[kind]
        fishes[first + number] = f"{name}:{counted[name]}"
        counted[name] += 1
    sea, reef = world.state.sea, world.state.reef
    numbers = {"pillar": len(sea.pillars), "rock": len(sea.rocks), "coral": len(reef.kind)}
    things = {
        VALUES[kind] + k: f"{kind}:{k}" for kind in NUMBERED for k in range(numbers.get(kind, 0))
    }
    single = (kind for kind in KINDS if kind not in (*NUMBERED, "water"))
    things |= {VALUES[kind]: kind for kind in single}
    values = first + len(kinds)
    named = {"CryptoFish": fishes, "CryptoSpecies": species, "CryptoThing": things}
    return tuple(matte(layer, names, values) for layer, names in named.items())


def pixel_place(number: int) -> tuple[float, float]:
    """A place in a pixel, from its middle, in (-0.5, 0.5): Halton's points of bases 2 and 3.

    They do not go along with the points of the lens (`exposure.EVENLY`).
    """
    place = []
    for base in (2, 3):
        left, digit, share = number + 1, 1.0, 0.0
        while left:
            digit /= base
            share += digit * (left % base)
            left //= base
        place.append(share - 0.5)
    return place[0], place[1]


def beside(view: View, right: float, up: float) -> View:
    """The view whose pixels show what is right of, and above, those of `view`, pixels."""
    projection = view.projection.copy()
    # Points have w = -z, so this is the same part of the picture at all depths.
    projection[0, 2] += 2.0 * right / view.viewport[2]
    projection[1, 2] += 2.0 * up / view.viewport[3]
    return replace(view, projection=projection)
