"""The sea's light on the lamps of a room: what a lamp shines is what comes from its direction.

As in `water_radiance` of `shaders/optics.glsl`, which draws the open water on the screens, so that
lamps and screens match. Light from above waxes and wanes as waves focus it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace

from subsea.base.arrays import Array
from subsea.base.disk_cache import cached
from subsea.habitat.day import hour_at
from subsea.rendering.gl.textures import near_and_far
from subsea.rendering.output.uniforms import TIDE_S, light_uniforms
from subsea.scenario.schema import LUMINANCE, Water
from subsea.stage.theatre.theatre_file import SLOTS, Lamp, Lights
from subsea.view.rig import CameraPose

WIDE = np.radians(35.0)  # half the angle that a lamp stands for
CENTRE_SHARE = 0.4  # of its middle in its light; eight directions about it share the rest
COARSE = 8  # texels of the caustics in one: lamps show their slow part
AWAY_CM = 150.0  # from the eye to where the light for a level lamp falls
WAVES_SHARE = 0.7  # of the light from straight above that waves focus


def ways_of(lamps: Sequence[Lamp]) -> Array:
    """The directions (n, 3) of lamps: right, up, ahead."""
    turn = np.radians([lamp.azimuth_deg for lamp in lamps])
    rise = np.radians([lamp.elevation_deg for lamp in lamps])
    flat = np.cos(rise)
    return np.stack([flat * np.sin(turn), np.sin(rise), flat * np.cos(turn)], axis=-1)


class SeaLight:
    """Computes the light on lamps."""

    def __init__(self, lamps: Sequence[Lamp]) -> None:
        """Take the directions of the `lamps`."""
        self._ways = np.stack([spread(way) for way in ways_of(lamps)])  # (n, 9, 3)
        self._caustics: Array | None = None  # (m, m), mean 1, once it is needed

    def at(self, water: Water, pose: CameraPose, time_s: float) -> Array:
        """The linear light (n, 3) of lamps about a viewer at a time of a dive, without gain.

        It is 0 to 1 as on a screen.
        """
        if water.day_minutes:
            water = replace(water, hour=hour_at(water.hour, water.day_minutes, time_s))
        uniforms = light_uniforms(water, pose.eye)
        ways = self._ways @ pose.axes
        light = water_radiance(uniforms, ways)
        shares = np.full(light.shape[1], (1.0 - CENTRE_SHARE) / (light.shape[1] - 1))
        shares[0] = CENTRE_SHARE
        mean = np.einsum("nkc,k->nc", light, shares)
        return mean * self._waves(uniforms, pose.eye, ways[:, 0], time_s % TIDE_S)[:, None]

    def _waves(self, uniforms: dict[str, Any], eye: Array, ways: Array, time_s: float) -> Array:
        """Factors (n,), mean about 1, by which waves focus the light for lamps.

        As `caustics_at` of `optics.glsl`, blurred; the deeper the viewer, the weaker.
        """
        if self._caustics is None:
            near, far = np.moveaxis(cached(near_and_far, 1).astype(np.float64), -1, 0)
            self._caustics = _blurred(near + far) / 2.0
        depth = max(-float(eye[2]), 0.0)
        sun = uniforms["u_sun"]
        ground = eye[:2] + AWAY_CM * ways[:, :2] + np.array(sun[:2]) / sun[2] * depth
        size = len(self._caustics)
        light = np.ones(len(ways))
        for turn, drift in (
            (np.array([[0.0029, -0.0009], [0.0009, 0.0029]]), (0.034, 0.019)),
            (np.array([[-0.0010, -0.0035], [0.0035, -0.0010]]), (-0.027, -0.037)),
        ):
            place = (ground @ turn.T + time_s * np.array(drift)) * size
            light = light * _between(self._caustics, place)
        depth_share = min(depth / 60.0, 1.0) / (1.0 + depth / 800.0)
        above = WAVES_SHARE * np.clip(0.5 + 0.5 * ways[:, 2], 0.0, 1.0) ** 2
        return 1.0 + above * depth_share * (light - 1.0)


def water_radiance(uniforms: dict[str, Any], ways: Array) -> Array:
    """Radiance (…, 3) of endless water in directions (…, 3) of the world, as in `optics.glsl`."""
    sun = np.array(uniforms["u_sun"])
    up, down = np.maximum(ways[..., 2], 0.0), np.maximum(-ways[..., 2], 0.0)
    level = (1.0 + up * (1.3 + 0.5 * up)) / (1.0 + down * (1.5 + 3.0 * down))
    level = level * (1.0 + 0.9 * ways[..., :2] @ sun[:2])
    rise, sink = np.array(uniforms["u_rise"]), np.array(uniforms["u_sink"])
    tint = 1.0 + (up**2)[..., None] * (rise - 1.0)
    tint = tint * (1.0 + down[..., None] * (sink - 1.0))
    glow = np.maximum(ways @ sun, 0.0)[..., None] ** 4
    broad, narrow = np.array(uniforms["u_broad"]), np.array(uniforms["u_narrow"])
    far = np.array(uniforms["u_far"]) * level[..., None] * tint
    return np.asarray(far + broad * glow + narrow * glow**4)


def filmic(light: Array) -> Array:
    """Show linear light (…, 3) as the screens do, 0 to 1: `filmic` of `curve.glsl`."""
    y = np.concatenate([light, light.max(axis=-1, keepdims=True)], axis=-1)
    steep = (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14)
    most = np.minimum(y[..., 3:] * steep[..., 3:], 1.0)
    kept = 0.4 - 0.4 * most * most
    return np.asarray(
        np.minimum(light * ((1.0 - kept) * steep[..., :3] + kept * steep[..., 3:]), 1)
    )


def spread(way: Array) -> Array:
    """Directions (9, 3) that a lamp stands for: its own, and eight about it."""
    aside = np.cross(way, (0.0, 0.0, 1.0) if abs(way[2]) < 0.9 else (1.0, 0.0, 0.0))
    aside /= np.linalg.norm(aside)
    turn = np.arange(8)[:, None] * np.pi / 4.0
    about = np.cos(turn) * aside + np.sin(turn) * np.cross(way, aside)
    return np.concatenate([way[None], np.cos(WIDE) * way + np.sin(WIDE) * about])


def levels_of(lamp: Lamp, light: Array) -> bytes:
    """The levels of a lamp's channels for a light (3,) of 0 to 1."""
    red, green, blue = (float(one) for one in light)
    if lamp.colours == "white":
        parts = [float(LUMINANCE @ light)]
    elif lamp.colours == "rgbw":
        white = min(red, green, blue)
        parts = [red - white, green - white, blue - white, white]
    else:
        parts = [red, green, blue]
    shown = [lamp.level * part ** (1.0 / lamp.gamma) for part in parts]
    if lamp.fine:
        return b"".join(round(65535 * one).to_bytes(2, "big") for one in shown)
    return bytes(round(255 * one) for one in shown)


def _blurred(texels: Array) -> Array:
    """Means of blocks of COARSE x COARSE texels, with mean 1."""
    size = len(texels) // COARSE
    means = texels.reshape(size, COARSE, size, COARSE).mean(axis=(1, 3))
    return np.asarray(means / means.mean())


def _between(tile: Array, place: Array) -> Array:
    """Values (n,) of a repeating tile at places (n, 2), x then y, between its texels."""
    size, low = len(tile), np.floor(place).astype(int)
    (x, y), share = low.T, place - low
    fx, fy = share.T
    rows = [tile[(y + k) % size, x % size] * (1 - fx) + tile[(y + k) % size, (x + 1) % size] * fx
            for k in (0, 1)]  # fmt: skip
    return np.asarray(rows[0] * (1 - fy) + rows[1] * fy)


def universes_of(
    lamps: Sequence[Lamp], lights: Lights, light: Array, blank: float
) -> dict[int, bytes]:
    """The levels of all universes for a light (n, 3) of lamps, while screens are so far `blank`."""
    shown = filmic(lights.gain * light)
    return _packed(lamps, [(1.0 - blank) * one + blank * lights.dark for one in shown])


def dark_levels(lamps: Sequence[Lamp], dark: float) -> dict[int, bytes]:
    """The levels of all universes while the screens are black."""
    return _packed(lamps, [np.full(3, dark) for _ in lamps])


def _packed(lamps: Sequence[Lamp], light: Sequence[Array]) -> dict[int, bytes]:
    universes: dict[int, bytearray] = {}
    for lamp, one in zip(lamps, light, strict=True):
        levels = universes.setdefault(lamp.universe, bytearray(SLOTS))
        levels[lamp.channel - 1 : lamp.channels[-1]] = levels_of(lamp, one)
    return {universe: bytes(levels) for universe, levels in universes.items()}
