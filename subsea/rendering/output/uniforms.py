"""Uniforms that all shaders share: eye, water, time, lamps."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from msgspec.structs import replace

from subsea.base.arrays import Array
from subsea.frame.packet import MOST_BITES, Packet
from subsea.habitat.day import daylight_at
from subsea.habitat.stone import night_at, shares_of_suns, sun_at
from subsea.rendering.gl.shaders import view_block
from subsea.scenario.schema import LUMINANCE, Water, attenuation
from subsea.view.camera import View

CONTRAST_LEFT = 0.02  # at the visibility of a scenario
# Daylight at noon at the surface. The sun's is that of a surface that faces it.
SUNLIGHT, SKYLIGHT = np.array([5.3, 4.2, 3.6]), np.array([0.50, 0.76, 0.95])
SANDLIGHT = np.array([0.32, 0.36, 0.36])  # reflected upward by sand
AIR = np.array([0.10, 0.17, 0.32])  # optical depth of the air, sun in the zenith
MOST_AIR = 9.0  # air mass at the horizon
DUSK = np.array([0.22, 0.24, 0.34])  # of the sky's light, when the sun is at the horizon
# Night, as eyes that have adapted to it see it: light of the sky, of the moon, and the pupil.
NIGHT, MOONLIGHT = np.array([0.110, 0.175, 0.270]), np.array([0.070, 0.100, 0.135])
OWL, MOON_SHAFTS = 5.0, 0.3  # widest pupil; strength of shafts of the moon's light
# Water without a type: attenuation downward in 1/cm, and shares of the extinction along the view.
PLAIN_DOWN, PLAIN_ALONG = np.array([0.0020, 0.00080, 0.00042]), np.array([1.25, 1.0, 0.84])
ABSORBED = 0.5  # share of different losses along the view that the eye does not make up for
LEAST_ALONG = 0.4  # share of the extinction of green light that any colour has
# The eye adapts to the light around it: share of the loss that it makes up for, in the colour that
# water absorbs least and most. It adapts less the deeper it is.
ADAPTED_LEAST, ADAPTED_MOST = 0.45, 1.10
ADAPTS_TO_CM = 1000.0  # depth at which half of it is made up for
LEVEL_CM = 350.0  # depth at which the colour of distant water is seen level as it is given
# The pupil: exponent of the eye's light over that at LEVEL_CM at noon, and its limits.
PUPIL, NARROW, WIDE = 0.55, 0.75, 2.2
FAR = 0.75  # of distant water, of the colour that is given
VIOLET = np.array([1.7, 0.92, 1.0])  # of the deep, which an eye sees below blue water
RISE, SINK = 0.53, 0.60  # how much more and less there is of the colour that water takes most
# Light scattered forward around the sun: a broad glow and a narrow one.
BROAD, NEAR_SUN = np.array([0.02, 0.08, 0.11]), np.array([0.22, 0.45, 0.50])
PLAIN_FAR = np.array([0.007, 0.080, 0.190])  # distant water that those belong to


@dataclass(frozen=True)
class Daylight:
    """The light of a scenario, without the eye; colours are linear RGB."""

    sun: Array  # (3,) unit vector toward the sun, below the surface
    sunlight: Array  # below the surface, of a surface that faces the sun
    skylight: Array
    sandlight: Array
    down: Array  # attenuation of daylight with depth, 1/cm
    along: Array  # extinction along a view ray, 1/cm
    far: Array  # radiance of distant water, seen level from LEVEL_CM
    glow: Array  # (2, 3) broad and narrow, about the sun
    open: float = 0.0  # how far the pupil may open from WIDE to OWL, in [0, 1]
    shafts: float = 1.0  # strength of the shafts of light

    @cached_property
    def adapted(self) -> Array:
        """Share of the loss of each colour that the eye makes up for."""
        return ADAPTED_LEAST + (ADAPTED_MOST - ADAPTED_LEAST) * self.taken

    @cached_property
    def level(self) -> Array:
        """Daylight (3,) at LEVEL_CM over that at the surface, balanced."""
        return self.at(LEVEL_CM)

    @cached_property
    def steady(self) -> dict[str, Any]:
        """The uniforms that do not depend on the eye."""
        x, _, z = self.sun
        across = np.array([z, 0.0, -x]) / np.hypot(x, z)
        colours = {
            "u_sun": self.sun,
            "u_across": across,
            "u_aside": np.cross(self.sun, across),
            "u_sunlight": self.sunlight,
            "u_skylight": self.skylight,
            "u_sandlight": self.sandlight,
            "u_down": self.down,
            "u_along": self.along,
            "u_rise": np.exp(RISE * self.taken**0.75),
            "u_sink": VIOLET * np.exp(-SINK * np.sqrt(self.taken)),
        }
        shown: dict[str, Any] = {name: tuple(one.tolist()) for name, one in colours.items()}
        shares = shares_of_suns(self.sun).tolist()
        suns = {"u_early": tuple(shares[:4]), "u_late": tuple(shares[4:])}
        return shown | suns | {"u_shafting": self.shafts}

    @cached_property
    def taken(self) -> Array:
        """Rank of each colour by its loss in water, 0 for the least to 1."""
        return np.asarray((self.down - self.down.min()) / np.ptp(self.down))

    def balance(self, depth: float) -> Array:
        """Factor (3,) on all light by the white balance of an eye at a depth, cm."""
        return np.asarray(np.exp(self.down * self.adapted * depth / (1.0 + depth / ADAPTS_TO_CM)))

    def at(self, depth: float) -> Array:
        """Daylight (3,) at an eye at a depth over that at the surface, balanced."""
        return np.asarray(np.exp(-self.down * depth) * self.balance(depth))

    def pupil(self, depth: float) -> float:
        """Factor on all light by the pupil of an eye at a depth, cm; 1 in plain water at noon."""
        return self.pupil_in(self.at(depth))

    def pupil_in(self, light: Array) -> float:
        """Factor on all light by the pupil of an eye in this `light` (3,), as of `at`."""
        bright = LUMINANCE @ (self.flat * light)
        wide = WIDE + (OWL - WIDE) * self.open
        return min(max(float((_usual() / bright) ** PUPIL), NARROW), wide)

    @cached_property
    def flat(self) -> Array:
        """Daylight (3,) on level ground at no depth."""
        return np.asarray(self.sun[2] * self.sunlight + self.skylight)


@lru_cache(maxsize=16)
def daylight(water: Water) -> Daylight:
    """The light in a scenario's water."""
    sun, sine = sun_at(water.hour)
    noon, top = sun_at(12.0)
    # The path through the air, and the share of the flat light that enters the water.
    air = np.minimum(1.0 / np.maximum([sine, top], 1.0 / MOST_AIR), MOST_AIR)
    entering = max(sine, 0.02) / sun[2] / (top / noon[2])
    sunlight = SUNLIGHT * entering * np.exp(-AIR * (air[0] - air[1]))
    skylight = SKYLIGHT * (DUSK + (1.0 - DUSK) * min(max(sine, 0.0) / top, 1.0))
    dark, moon = night_at(water.hour)
    # Where the clock stands, the pictures of a day keep the pupil that they were made for.
    opening = max(1.0 - daylight_at(water.hour), dark) if water.day_minutes else dark
    if dark > 0.0:
        sunlight = (1.0 - dark) * sunlight + moon * MOONLIGHT
        skylight = skylight + dark * (NIGHT - skylight)
    now, then = sun[2] * sunlight + skylight, noon[2] * SUNLIGHT + SKYLIGHT
    green = -np.log(CONTRAST_LEFT) / water.visibility_cm
    far, glow = np.array(water.far), np.array([BROAD, NEAR_SUN])
    if water.type is None:
        down, along = PLAIN_DOWN, green * PLAIN_ALONG
    else:
        down = np.array(attenuation(water.type))
        # All colours are scattered alike; what is absorbed differs.
        along = np.maximum(green + ABSORBED * (down - down[1]), LEAST_ALONG * green)
        hue = np.sqrt(far / PLAIN_FAR)
        glow = glow * np.clip(hue / hue[1], 0.3, 3.0)
    return Daylight(
        np.array(sun), sunlight, skylight, SANDLIGHT * now / then, down, along, far * now / then,
        glow * sunlight / SUNLIGHT, opening, 1.0 - dark + MOON_SHAFTS * moon,
    )  # fmt: skip


@lru_cache(maxsize=1)
def _usual() -> float:
    """Luminance about an eye in plain water at LEVEL_CM at noon."""
    sun = np.array(sun_at(12.0)[0])
    plain = Daylight(
        sun, SUNLIGHT, SKYLIGHT, SANDLIGHT, PLAIN_DOWN, PLAIN_ALONG, PLAIN_FAR, np.zeros((2, 3))
    )
    return float(LUMINANCE @ ((sun[2] * SUNLIGHT + SKYLIGHT) * plain.at(LEVEL_CM)))


def light_uniforms(water: Water, eye: Array | tuple[float, ...]) -> dict[str, Any]:
    """The uniforms of `optics.glsl` that depend on water, hour and the height of the eye.

    They depend on nothing else of a view, so that all screens of a theatre match.
    """
    light = daylight(water)
    depth = max(-float(eye[2]), 0.0)
    left, balance = np.exp(-light.down * depth), light.balance(depth)
    balance *= light.pupil_in(left * balance)
    here = left * balance / light.level
    return light.steady | {
        "u_balance": tuple(balance.tolist()),
        "u_far": tuple((FAR * light.far * here).tolist()),
        "u_broad": tuple((light.glow[0] * here).tolist()),
        "u_narrow": tuple((light.glow[1] * here).tolist()),
        "u_extinction": float(light.along[1]),
    }


# Period of the shaders' time; waves and snow jump when it ends. Their float32 resolves 1 ms up to
# here, but only 8 ms after a day, and waves would jerk.
TIDE_S = 4 * 3600.0


def water_of(packet: Packet, water: Water) -> Water:
    """The `water` of a scene at the hour of a packet."""
    return water if packet.hour is None else replace(water, hour=packet.hour)


def uniforms_of(packet: Packet, view: View, water: Water, unit: float = 1.0) -> dict[str, Any]:
    """The uniforms of a view, in the scene's `water` at the hour of the packet.

    `unit` is `RenderTarget.unit` of the canvas that the view is drawn on.
    """
    water = water_of(packet, water)
    columns = np.empty((4, 4, 4), np.float32)  # in OpenGL's column-major order
    columns[0], columns[1] = view.view.T, view.projection.T
    columns[2], columns[3] = view.world_to_clip.T, np.linalg.inv(view.world_to_clip).T
    matrices = columns.tobytes()
    values = (
        {
            "u_view": matrices[:64],
            "u_projection": matrices[64:128],
            "u_view_projection": matrices[128:192],
            "u_inverse": matrices[192:],
            "u_eye": tuple(float(x) for x in view.eye),
            "u_size": (float(view.viewport[2]), float(view.viewport[3])),
            "u_without": float(view.without),
            "u_time": packet.time_s % TIDE_S,
            "u_unit": unit,
        }
        | light_uniforms(water, view.eye)
        | _lamps(packet)
        | _bites(packet)
    )
    return values | {"view": view_block(values)}


NO_BITES = {"u_bites": bytes(16 * MOST_BITES), "u_bitten": 0}


def _lamps(packet: Packet) -> dict[str, Any]:
    """Positions and axes of the lamps; empty while they are off."""
    if packet.lamps is None:
        return {}
    places, ways = ([tuple(map(float, one)) for one in part] for part in packet.lamps)
    return {"u_lamps": places, "u_beams": ways}


def _bites(packet: Packet) -> dict[str, Any]:
    """Places where growth was eaten, padded to the length of the shaders' array."""
    if not len(packet.bites):
        return NO_BITES
    rows = np.zeros((MOST_BITES, 4), np.float32)
    rows[: len(packet.bites)] = packet.bites
    return {"u_bites": rows.tobytes(), "u_bitten": len(packet.bites)}
