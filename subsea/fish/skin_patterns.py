"""Patterns of skin textures: stripes, spots, patches, fin rays and blotches."""

import numpy as np

from subsea.base.arrays import Array
from subsea.fish.raster import (
    blend,
    depth_inside,
    grain_noise,
    smooth_unit,
    smoothstep,
    texels_around,
    tiled,
)
from subsea.fish.species import FinSkin, SkinPatch, SkinSpots, Stripes

SOFT = 0.003  # width of the borders between colours, body lengths
UNEVEN = 0.0016  # amplitude of the borders' waviness, body lengths
SPOT_SOFT = 0.0013  # half the width of a spot's border, body lengths


def blotch(picture: Array, amount: float) -> None:
    """Vary colours between warmer and cooler by noise."""
    shape = picture.shape[1:]
    cloud, other = tiled(grain_noise()[::-1], shape), tiled(grain_noise()[:, ::-1], shape)
    for plane, warmth, light in zip(
        picture, (0.055, 0.01, -0.05), (0.06, 0.07, 0.06), strict=False
    ):
        plane *= 1.0 + amount * (np.float32(warmth) * cloud + np.float32(light) * other)


def scatter_spots(picture: Array, plan: SkinSpots, s: Array, right: Array, where: Array) -> None:
    """Paint round spots and rings of random size on a jittered grid."""
    rng = np.random.default_rng(0x5B07)
    rows = np.arange(-0.5 * plan.spacing, right.max(), plan.spacing * np.sqrt(0.75))
    share = np.zeros_like(where)
    for k, z in enumerate(rows):
        for x in np.arange(s[0], s[-1], plan.spacing) + 0.5 * plan.spacing * (k % 2):
            place = np.array([x, z]) + rng.uniform(-0.22, 0.22, 2) * plan.spacing
            size, kind = rng.uniform(), rng.uniform()
            radius = plan.radius[0] + (plan.radius[1] - plan.radius[0]) * size
            columns = slice(*np.searchsorted(s, place[0] + radius * np.array([-1.5, 1.5])))
            near = np.flatnonzero(np.abs(right[:, 0] - place[1]) < 1.5 * radius)
            far = np.hypot(s[columns] - place[0], right[near] - place[1]) - radius
            spot = smoothstep(far, SPOT_SOFT, -SPOT_SOFT)
            if kind < plan.rings and size > 0.35:  # a smaller ring would close
                spot *= smoothstep(far + 0.5 * radius, -SPOT_SOFT, SPOT_SOFT)
            share[near, columns] = np.maximum(share[near, columns], spot)
    blend(picture, plan.colour, share * where)


def stripe_share(plan: Stripes, s: Array, y: Array, uneven: Array) -> Array:
    """Coverage of slightly wavy stripes, 0 to 1, that taper at both ends."""
    waver = 0.09 * _sine(19.0 * s, 23.0 * y) + 0.05 * _sine(43.0 * s, -31.0 * y)
    if plan.upright:
        phase = (s - plan.rise * y + uneven) / plan.spacing + waver
    else:
        phase = (y - plan.rise * (s - 0.5) + 0.12 * (s - 0.55) ** 2 + uneven) / plan.spacing + waver
    wave = np.abs((phase % 1.0) - 0.5) * 2.0  # 0 in the middle of a stripe, 1 between two
    soft = SOFT / plan.spacing
    taper = smoothstep(s, plan.begin - 0.005, plan.begin + 0.05)
    taper = taper * smoothstep(s, plan.end + 0.005, plan.end - 0.05)
    share = plan.share * np.sqrt(taper)
    return smooth_unit((share + soft - wave) / (2.0 * soft)) * (taper > 0.0)


def _sine(a: Array, b: Array) -> Array:
    """Sine of a + b, fast where one varies by column and the other by row."""
    return np.asarray(np.sin(a) * np.cos(b) + np.cos(a) * np.sin(b))


def blend_patch(picture: Array, plan: SkinPatch, s: Array, y: Array, uneven: Array | float) -> None:
    """Blend a patch into the body; `uneven` (h, w) shifts its outline, body lengths."""
    half = plan.soft / 2
    rows, columns = texels_around(plan.outline, plan.rim_width + half + 3 * UNEVEN, s, y)
    picture = picture[:, rows, columns]
    depth = depth_inside(plan.outline, s[columns], y[rows])
    if isinstance(uneven, np.ndarray):
        depth += uneven[rows, columns]
    blend_rings(picture, plan, depth)


def blend_rings(picture: Array, plan: SkinPatch, depth: Array) -> None:
    """Blend a patch and its rim, given the distance `depth` inside its outline."""
    half = plan.soft / 2
    if plan.rim:
        blend(picture, plan.rim, smoothstep(depth, -plan.rim_width - half, -plan.rim_width + half))
    blend(picture, plan.colour, smoothstep(depth, -half, half))


def ray_pattern(share: Array, out: Array, spines: int, rays: int) -> tuple[Array, Array]:
    """Return the strength of fin rays, and the position between two (0 on a ray, 1 midway).

    `share` (0 to 1) runs along the base, with spines in front, and `out` (0 to 1) to the edge.
    Soft rays fork outward.
    """
    count = spines + rays
    if not count:
        return np.zeros_like(out), np.zeros_like(out)
    place = share * count
    off = np.abs(place % 1.0 - 0.5) * 2.0  # 0 in the middle of a ray
    fork = np.where(place < spines, 0.0, 0.34 * smoothstep(out, 0.25, 1.0))
    wide = np.where(place < spines, 0.30 - 0.16 * out, 0.30 - 0.15 * out)
    return smoothstep(np.abs(off - fork), wide + 0.12, wide - 0.14), off**3


def blend_membrane(
    picture: Array, fin: FinSkin, plain: float, out: Array, rays: Array, to_edge: Array,
    to_rim: Array | None = None,
) -> None:  # fmt: skip
    """Blend rays, rim and the transparency of the membrane between the rays.

    `to_edge` is the distance to the edge in body lengths, `to_rim` in widths of the rim.
    """
    root = smoothstep(out, 0.02, 0.25)
    picture[:3] *= 1.0 - 0.3 * plain * rays * root
    if fin.rim:
        rim = to_edge / fin.rim_width if to_rim is None else to_rim
        blend(picture, fin.rim, smoothstep(rim, 1.0, 0.7) * root)
    clear = (1.0 - fin.opacity) * smoothstep(out, 0.05, 0.8)
    # Rays stay more opaque than the membrane of a clear fin; its edge frays.
    clear = clear * (1.0 - 0.55 * plain * rays)
    picture[3] *= (1.0 - clear) * smoothstep(to_edge, 0.0, 0.004)
