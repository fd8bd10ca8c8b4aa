"""Faces of skin textures: eye, mouth, nostril, and gill cover or gill slits."""

from math import radians

import numpy as np

from subsea.base.arrays import Array
from subsea.fish.raster import blend, single, smoothstep, texels_around
from subsea.fish.sheet_layout import head_size
from subsea.fish.species import SkinPlan, Species
from subsea.fish.surface import SurfacePlan

DARK = (0.012, 0.012, 0.016)  # the pupil and the rim of the eye
GILLS_APART = 0.016  # body lengths
GILL = 0.135  # of the edge of the gill cover behind the eye, body lengths
# Angle by which the lower jaw turns down.
GAPE_RAD = {"predator": radians(32.0), "prey": radians(22.0), "pacifist": radians(22.0)}
LIPS = 0.25  # half the width of the border between the jaws over the length of the mouth


def jaws(species: Species) -> tuple[float, float]:
    """Angle of the wide open lower jaw, rad; half the width of the border, body lengths."""
    surface, (tip, corner) = species.surface, species.skin.mouth
    # The mouth of a ray is on its lower side, which is elsewhere on the skin.
    gape = 0.0 if surface.wing else GAPE_RAD[species.kind]
    return gape, LIPS * (corner[0] - tip[0]) * head_size(surface)


def draw_face(
    picture: Array, surface: SurfacePlan, skin: SkinPlan, s: Array, y: Array, level: Array
) -> None:
    """Draw gill cover or gill slits, mouth, nostril and eye."""
    eye = surface.eye
    large = head_size(surface)
    reach = 0.2 + 0.01 * skin.gills
    head = slice(0, int(np.searchsorted(s, max(eye.at + large * reach, skin.mouth[1][0]) + 0.01)))
    picture, s, level = picture[:, :, head], s[head], level[:, head]
    at = (s - eye.at) / large - GILL + 0.05 * level**2 + 0.02 * level
    if skin.gills == 0:
        pore = np.hypot(at / 0.022, level / 0.16)
        picture[:3] *= 1.0 - 0.7 * smoothstep(pore, 1.0, 0.5)
    elif skin.gills == 1:
        _draw_gill_cover(picture, at, level)
    else:
        place = at / GILLS_APART + 0.5 * (skin.gills - 1)
        nearest = np.round(place).clip(0, skin.gills - 1)
        slit = smoothstep(np.abs(place - nearest), 0.28, 0.0) * smoothstep(np.abs(level), 0.5, 0.3)
        picture[:3] *= 1.0 - 0.5 * slit
    _draw_mouth(picture, skin, s, y, large)
    (tip, height), _ = skin.mouth
    toward = 0.52  # of the way from the eye to the mouth
    nose = (eye.at + toward * (tip - eye.at), eye.height + toward * (height - eye.height))
    nose = (nose[0], nose[1] + 0.35 * eye.radius)
    far = np.hypot(s - nose[0], (y - nose[1]) * 1.3) / (0.17 * eye.radius)
    picture[:3] *= (
        1.0
        - 0.75 * smoothstep(far, 1.2, 0.6)
        + 0.18 * smoothstep(far, 2.2, 1.4) * smoothstep(far, 1.0, 1.4)
    )
    draw_eye(picture, skin, s - eye.at, y - eye.height, eye.radius)


def _draw_gill_cover(picture: Array, at: Array, level: Array) -> None:
    """Draw the gill cover, whose edge casts a shadow; `at` is the distance behind that edge."""
    tall = smoothstep(np.abs(level + 0.08), 0.86, 0.6)
    behind = at > 0.0
    shade = np.where(behind, 0.34 * np.exp(-at.clip(0.0) / 0.014), 0.0)
    shade += 0.42 * np.exp(-((at / 0.0036) ** 2))
    light = np.where(behind, 0.0, 0.22 * np.exp(-(((at + 0.010) / 0.007) ** 2)))
    # The edge of the cheek in front of it, and the ridge between both.
    cheek = at + 0.052 + 0.03 * level
    light += 0.08 * np.exp(-(((cheek - 0.006) / 0.006) ** 2))
    shade += 0.16 * np.exp(-((cheek / 0.0042) ** 2)) * smoothstep(np.abs(level + 0.25), 0.6, 0.35)
    picture[:3] *= 1.0 + single(tall * (light - shade))
    # The flap at its end is thin skin, a little darker.
    picture[:3] *= 1.0 - 0.1 * single(tall * smoothstep(np.abs(at + 0.004), 0.006, 0.002))


def _draw_mouth(picture: Array, skin: SkinPlan, s: Array, y: Array, large: float) -> None:
    """Draw the mouth: a dark line between two lips that end in a fold."""
    (tip, height), (corner, low) = skin.mouth
    rows, columns = texels_around([(tip, height), (corner, low)], 0.02 * large + 0.006, s, y)
    picture, s, y = picture[:, rows, columns], s[columns], y[rows]
    t = (s - tip) / (corner - tip)
    line = height + (low - height) * t + 0.0035 * large * np.sin(np.pi * t.clip(0.0, 1.0))
    off = (y - line) / large
    here = smoothstep(s, corner + 0.004 * large, corner - 0.004 * large) * smoothstep(
        s, tip - 0.006, tip
    )
    thick = 0.0105 * (1.0 - 0.55 * t.clip(0.0, 1.0))  # of a lip
    lip = smoothstep(np.abs(off), thick, 0.7 * thick) * here
    fold = smoothstep(np.abs(np.abs(off) - thick), 0.0026, 0.0) * here
    picture[:3] += 0.16 * lip * (picture[:3] + 0.12)
    picture[:3] *= 1.0 - 0.3 * fold
    picture[:3] *= 1.0 - 0.85 * smoothstep(np.abs(off), 0.0042, 0.0015) * here
    end = np.hypot((s - corner) / 0.006, (y - low) / 0.008) / large
    picture[:3] *= 1.0 - 0.4 * smoothstep(end, 1.0, 0.2)


def draw_eye(picture: Array, skin: SkinPlan, ahead: Array, up: Array, radius: float) -> None:
    """Draw an eye centred where `ahead` and `up` are 0: socket, iris with fibres, pupil."""
    rows = np.flatnonzero(np.abs(up).min(axis=1) < 1.8 * radius)
    columns = np.flatnonzero(np.abs(ahead) < 1.8 * radius)
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    picture = picture[:, box[0], box[1]]
    x, h = ahead[box[1]] / radius, up[box[0]] / radius
    far, angle = np.hypot(x, h), np.arctan2(h, x)
    picture[:3] *= 1.0 - 0.35 * smoothstep(far, 1.75, 1.0)
    blend(picture, DARK, 0.9 * smoothstep(far, 1.13, 1.02))
    fibres = 0.06 * np.sin(23.0 * angle + 2.0 * np.sin(5.0 * angle)) + 0.05 * np.sin(41.0 * angle)
    iris = np.array(skin.iris, np.float32)[:, None, None] * single(
        # Shaded by the brow, darker outside, bright at the pupil.
        (0.86 - 0.28 * h) * (1.0 + fibres) * (1.12 - 0.5 * smoothstep(far, 0.72, 1.0))
        + 0.5 * smoothstep(np.abs(far - skin.pupil - 0.07), 0.07, 0.0)
    )
    ring = single(smoothstep(far, 1.0, 0.9))
    picture[:3] += (iris - picture[:3]) * ring
    blend(picture, DARK, smoothstep(far, skin.pupil + 0.05, skin.pupil - 0.05))
    # The reflection of the water surface in the pupil.
    picture[2] += 0.03 * single(smoothstep(far, 0.5, 0.3) * smoothstep(h, -0.1, 0.5))
