"""A room with projectors that are not where they should be, and cameras that photograph them.

A small renderer for tests: every pixel of a camera is traced to the screen and from there into all
projectors. So the truth is known: where on the screen each pixel of each projector is.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from PIL import Image

from subsea.stage.calibration.lit_theatre import lit_theatre
from subsea.stage.calibration.optics import PhotoCamera, rotation_vector
from subsea.stage.calibration.photographs import light_steps
from subsea.stage.calibration.surface import LitSurface
from subsea.stage.theatre.layouts import layout
from subsea.stage.theatre.lenses import nodes_text
from subsea.stage.theatre.measures import chosen
from subsea.stage.theatre.screens import Flat
from subsea.stage.theatre.theatre_writer import compose_layout, mesh_name
from subsea.view.structured_light import light_picture


@dataclass(frozen=True)
class LampLens:
    """A projector as it really hangs: a pinhole with radial distortion."""

    place: np.ndarray  # (3,) cm from the eye
    axes: np.ndarray  # (3, 3) rows right, up, ahead
    half: tuple[float, float]  # of the picture at unit distance
    size: tuple[int, int]
    shift: tuple[float, float] = (0.0, 0.0)  # of the lens to the right and up, half pictures
    bend: float = 0.0  # at the corner of the picture
    gain: tuple[float, float, float] = (1.0, 1.0, 1.0)
    gamma: float = 2.2
    black: float = 0.0

    def rays(self, shown):
        """The unit directions (n, 3) of the light of pixels (n, 2) from the upper left corner."""
        middle = np.array(self.size) / 2
        away = (shown - middle) / middle
        far = ((shown - middle) ** 2).sum(axis=1, keepdims=True) / (middle @ middle)
        slopes = (away * (1 + self.bend * far) * [1, -1] + self.shift) * self.half
        ways = np.column_stack([slopes, np.ones(len(slopes))]) @ self.axes
        return ways / np.linalg.norm(ways, axis=1, keepdims=True)

    def pixels(self, points):
        """The pixels (n, 2) that light points (n, 3); NaN behind the lens."""
        seen = (points - self.place) @ self.axes.T
        ahead = np.where(seen[:, 2] > 1e-6, seen[:, 2], np.nan)
        middle = np.array(self.size) / 2
        straight = (seen[:, :2] / ahead[:, None] / self.half - self.shift) * [1, -1] * middle
        # Far beyond the picture the distortion has no way back.
        straight[(np.abs(straight) > 1.3 * middle).any(axis=1)] = np.nan
        away = straight.copy()
        for _ in range(8):  # the distortion backwards
            far = (away**2).sum(axis=1, keepdims=True) / (middle @ middle)
            away = straight / (1 + self.bend * far)
        return away + middle

    def turned(self, degrees, moved=(0.0, 0.0, 0.0), **changes):
        """The projector turned about right, up and ahead, and moved by centimetres."""
        turn = rotation_vector(np.radians(degrees))
        place = self.place + np.array(moved)
        return replace(self, axes=turn @ self.axes, place=place, **changes)


@dataclass
class LitRoom:
    """Channels with their true projectors and surfaces."""

    channels: list  # of the theatre
    surfaces: list[LitSurface]
    lamps: list[LampLens]
    ambient: float = 0.01  # light of the room, of the brightest white
    bounce: float = 0.0  # share of all light that comes back from everywhere
    albedo: float = 0.8
    noise: float = 1.0  # standard deviation, code values
    seed: int = 1
    rng: np.random.Generator = field(init=False)

    def __post_init__(self):
        self.rng = np.random.default_rng(self.seed)

    def photograph(self, camera: PhotoCamera, folder: Path, skip=(), steps=None, shows=None):
        """Write the photographs of a camera in PNG; returns their paths.

        `shows` gives the pictures (h, w, 3) of all projectors in the step of a number; None: the
        pattern of one of them, and the others are black.
        """
        folder.mkdir(parents=True, exist_ok=True)
        width, height = camera.size
        fine = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)]  # samples of a pixel
        x, y = np.meshgrid(np.arange(width), np.arange(height))
        corner = np.column_stack([x.ravel(), y.ravel()]).astype(float)
        dark = np.full((len(corner), 3), 0.0, np.float32)
        seen = [[] for _ in self.lamps]  # of each projector: lit pixels, pixels shown, falloff
        for offset in fine:
            rays = camera.rays(corner + offset)
            for k, (surface, lamp) in enumerate(zip(self.surfaces, self.lamps, strict=True)):
                shown = lamp.pixels(surface.meet(camera.place, rays))
                with np.errstate(invalid="ignore"):
                    lit = np.flatnonzero(((shown >= 0) & (shown < lamp.size)).all(axis=1))
                falloff = 1 - 0.6 * ((shown[lit] / lamp.size - 0.5) ** 2).sum(axis=1)
                falloff = (falloff / len(fine)).astype(np.float32)[:, None]
                seen[k].append((lit, shown[lit].astype(np.int32), falloff))
                dark[lit] += lamp.black * falloff
        grain = self.rng.normal(0, self.noise, 3 * len(corner) + 10_000).astype(np.float32)
        paths = []
        for number, step in enumerate(steps or light_steps(self.channels)):
            if number in skip:
                continue
            light = dark.copy()
            shining = {step.channel: light_picture(step.pattern, self.lamps[step.channel].size)}
            if shows is not None:
                shining = dict(enumerate(shows(number)))
            for channel, picture in shining.items():
                lamp = self.lamps[channel]
                bright = (1 - lamp.black) * np.array(lamp.gain)
                for lit, shown, falloff in seen[channel]:
                    codes = picture[shown[:, 1], shown[:, 0]].astype(np.float32) / 255
                    light[lit] += falloff * (codes**lamp.gamma * bright.astype(np.float32))
            light = self.albedo * (light + self.bounce * light.mean(axis=0)) + self.ambient
            begin = self.rng.integers(10_000)
            noisy = encoded(0.85 * light) + grain[begin : begin + light.size].reshape(light.shape)
            codes = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
            paths.append(folder / f"photo_{number}.png")
            Image.fromarray(codes.reshape(height, width, 3)).save(paths[-1], compress_level=1)
        return paths

    def truth(self, number: int, shown):
        """The points (n, 3) that pixels (n, 2) of a projector light."""
        lamp = self.lamps[number]
        return self.surfaces[number].meet(lamp.place, lamp.rays(shown))


def encoded(light):
    """The code values of linear light (IEC 61966-2-1)."""
    known = np.linspace(0, 1, 4096)
    code = np.where(known <= 0.0031308, 12.92 * known, 1.055 * known ** (1 / 2.4) - 0.055)
    return (255 * code[np.clip(4095 * light + 0.5, 0, 4095).astype(np.int32)]).astype(np.float32)


def look(camera_at, target, size, lens, focal, bend=(0.0, 0.0), middle=(0.0, 0.0)):
    """A camera at a place (3,) that looks at a point (3,)."""
    place, target = np.array(camera_at, float), np.array(target, float)
    ahead = (target - place) / np.linalg.norm(target - place)
    up = np.array([0.0, 1.0, 0.0]) if abs(ahead[1]) < 0.9 else np.array([0.0, 0.0, -1.0])
    right = np.cross(up, ahead)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(ahead, right), ahead])
    return PhotoCamera(size, lens, focal, bend, middle, place, axes)


def planned_room(kind, size, folder, turned_deg=2.0, moved_cm=3.0, seed=1, **measures):
    """Write a planned theatre `room.toml`; returns its path and a room whose projectors are off.

    Each projector of `size` pixels is turned about three axes and moved along them by random
    amounts of these standard deviations, and has a lens with up to some percent of distortion.
    """
    folder.mkdir(parents=True, exist_ok=True)
    plan = layout(kind, chosen(kind, {"across": size[0], "down": size[1], **measures}))
    path = folder / "room.toml"
    path.write_text(compose_layout(plan, "room", size, False, ""))
    for one in plan.channels:
        if one.nodes is not None:
            (folder / mesh_name("room", one.name)).write_text(nodes_text(one.nodes))
    lit = lit_theatre(str(path))
    rng = np.random.default_rng(seed)
    lamps = []
    for surface, one in zip(lit.surfaces, plan.channels, strict=True):
        lamp = LampLens(np.array(one.lens.place), one.lens.axes, one.lens.half, size)
        if isinstance(surface.screen, Flat) and surface.radius is None:  # lens shift
            screen = surface.screen
            middle = screen.corner + (screen.along + screen.up) / 2 - lamp.place
            sides = [np.linalg.norm(screen.along), np.linalg.norm(screen.up)]
            half = np.array(sides) / 2 / middle[2]
            shift = middle[:2] / middle[2] / half
            lamp = replace(lamp, half=tuple(half), shift=tuple(shift))
        lamps.append(
            lamp.turned(
                rng.normal(0, turned_deg, 3), rng.normal(0, moved_cm, 3), bend=rng.normal(0, 0.01)
            )
        )
    return path, LitRoom(list(lit.channels), lit.surfaces, lamps)


def write_points(path, camera, at, error_px=0.3, seed=5):
    """Write reference points (n, 3) of a camera, found in the photographs with some error."""
    rng = np.random.default_rng(seed)
    pixels = camera.seen(np.array(at, float)) + rng.normal(0, error_px, (len(at), 2))
    tables = [
        f'[[point]]\nname = "mark {k}"\nat_cm = {[round(float(x), 3) for x in point]}\n'
        f"pixel = {[round(float(x), 2) for x in pixel]}\n"
        for k, (point, pixel) in enumerate(zip(at, pixels, strict=True))
    ]
    path.write_text("\n".join(tables))


def errors_px(room, number, measured_points, shown):
    """The errors (n,) of points (n, 3) for pixels (n, 2): pixels of a projector, from the eye."""

    def angle(one, other):
        unit = [part / np.linalg.norm(part, axis=1, keepdims=True) for part in (one, other)]
        return 2 * np.arcsin(np.linalg.norm(unit[0] - unit[1], axis=1) / 2)

    true = room.truth(number, shown)
    across, down = (angle(true, room.truth(number, shown + step)) for step in ([1, 0], [0, 1]))
    return angle(true, measured_points) / np.sqrt(across * down)
