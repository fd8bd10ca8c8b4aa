"""Paint skin sheets (textures) procedurally; SMC §4 uses photographs of real fishes instead.

Most of a sheet is the left flank with the tail, seen from the side at rest. For a fish with wings
it is one wing unfolded at its edge: from top to bottom spine, upper side, area beyond the tip,
lower side, keel. The fins have regions above, in the parameters of their surfaces. Colours are
mixed in linear light and stored in sRGB; alpha is the opacity, 1 on the body.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.fish.face import DARK, GILLS_APART, draw_eye, draw_face
from subsea.fish.raster import (
    blend,
    boxes_overlap,
    cloud_noise,
    depth_at,
    depth_inside,
    every_fourth,
    grain_noise,
    single,
    smooth_unit,
    smoothstep,
    srgb_texels,
    texels_around,
    tiled,
    upsampled,
)
from subsea.fish.sheet_layout import (
    BODY,
    DORSAL,
    PECTORAL,
    PELVIC,
    SIZE,
    VENTRAL,
    borders,
    crop,
    fin_points,
    half_height,
    head_size,
)
from subsea.fish.species import FinSkin, SkinPatch, SkinPlan, SkinSpots, Species, Stripes
from subsea.fish.surface import Curve, FinPlan, PaddlePlan, SurfacePlan, WingPlan, along

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
    to_rim: Array | None = None, fleshy: float = 0.8,
) -> None:  # fmt: skip
    """Blend rays, rim and the transparency of the membrane between the rays.

    `to_edge` is the distance to the edge in body lengths, `to_rim` in widths of the rim. Beyond
    the share `fleshy` of its height the membrane is as clear as at its edge.
    """
    root = smoothstep(out, 0.02, 0.25)
    picture[:3] *= 1.0 - 0.3 * plain * rays * root
    if fin.rim:
        rim = to_edge / fin.rim_width if to_rim is None else to_rim
        blend(picture, fin.rim, smoothstep(rim, 1.0, 0.7) * root)
    clear = (1.0 - fin.opacity) * smoothstep(out, 0.05, fleshy)
    # Rays stay more opaque than the membrane of a clear fin; its edge frays.
    clear = clear * (1.0 - 0.55 * plain * rays)
    picture[3] *= (1.0 - clear) * smoothstep(to_edge, 0.0, 0.004)


FLANK = 0.45  # apparent width from above of features on the flank of a flat head
EDGE_SHADE = 0.02  # width of the band along the edge of a wing, body lengths
PORES = 0.0115  # from one scale of the lateral line to the next, body lengths
CUT_SPINES, CUT_RAYS = 0.15, 0.05  # cuts in the membrane between them, share of the fin
PADDLE_RAYS = 13
PADDLE_CONTRAST = 1.5  # of the rays of paired fins, over those of others
PADDLE_FLESHY = 0.3  # of their length from the root on, where they lose the flank's opacity


def paint(species: Species, size: tuple[int, int] = SIZE) -> NDArray[np.uint8]:
    """The sheet (height, width, 4) of a species, bottom row first as in OpenGL."""
    surface, skin = species.surface, species.skin
    sheet = np.zeros((4, size[1], size[0]), np.float32)  # planes: red, green, blue, opacity
    body = crop(sheet, BODY)
    _, height, width = body.shape
    top = half_height(surface)
    front, rear = borders(surface)
    s = single(front + (rear - front) * (np.arange(width) + 0.5) / width)
    y = single(-top + 2 * top * (np.arange(height)[:, None] + 0.5) / height)
    body[3] = 1.0
    if surface.wing:
        _paint_wings(body, species, surface.wing, s, y)
    else:
        _paint_flank(body, species, s, y)
    for frame, fin, look, ridge in (
        (DORSAL, surface.dorsal, skin.dorsal, surface.back),
        (VENTRAL, surface.ventral, skin.ventral, surface.belly),
    ):
        if fin and look:
            _paint_fin(crop(sheet, frame), fin, look, ridge, skin, _Body(body, s, y))
    for frame, paddle in ((PECTORAL, surface.pectoral), (PELVIC, surface.pelvic)):
        if paddle and skin.paddles:
            _paint_paddle(crop(sheet, frame), paddle, skin.paddles, skin, _Body(body, s, y))
    return srgb_texels(sheet)


class _Body(NamedTuple):
    """The painted body, whose colours continue at the roots of fins."""

    picture: Array  # (4, h, w)
    s: Array  # (w,) distance from the snout of each column
    y: Array  # (h, 1) height of each row

    def colours(self, s: Array, y: Array) -> Array:
        """The colours (3, …) at points."""
        _, height, width = self.picture.shape
        column = (s - self.s[0]) * ((width - 1) / (self.s[-1] - self.s[0]))
        row = (y - self.y[0, 0]) * ((height - 1) / (self.y[-1, 0] - self.y[0, 0]))
        row = row.clip(0, height - 1).astype(np.int32)
        return np.asarray(self.picture[:3, row, column.clip(0, width - 1).astype(np.int32)])


def _paint_flank(picture: Array, species: Species, s: Array, y: Array) -> None:
    """Paint a body seen from its left: base colours, patterns, tail, head."""
    surface, skin = species.surface, species.skin
    back, belly = single(along(surface.back, s)), single(along(surface.belly, s))
    # 1 at the dorsal ridge, 0 on the axis, -1 at the ventral ridge.
    level = np.where(y > 0, y / back, -y / belly)
    cloud = tiled(cloud_noise(), level.shape)
    uneven = UNEVEN * head_size(surface) * cloud
    shade = level + 0.05 * cloud
    picture[:3] = np.array(skin.belly, np.float32)[:, None, None]
    blend(picture, skin.flank, smoothstep(shade, -0.75, 0.1))
    blend(picture, skin.back, smoothstep(shade, 0.25, 0.95))
    if skin.clear_back:
        behind_eye = smoothstep(s, surface.eye.at + 0.05, surface.eye.at + 0.2)
        picture[3] -= skin.clear_back * smoothstep(level, 0.0, 0.5) * behind_eye
    if skin.stripes:
        blend(picture, skin.stripes.colour, stripe_share(skin.stripes, s, y, uneven))
    if skin.cape:
        line = single(along(skin.cape.line, s))
        blend(picture, skin.cape.colour, smoothstep(shade - line, -skin.cape.soft, skin.cape.soft))
    for patch in skin.patches:
        if not patch.over_fins:
            blend_patch(picture, patch, s, y, uneven)
    tail = smoothstep(s, surface.tail.begin - 0.05, surface.tail.begin + 0.02)
    blend(picture, skin.tail.colour, tail * np.ones_like(level))
    for patch in skin.patches:
        if patch.over_fins:
            blend_patch(picture, patch, s, y, uneven)
    _draw_tail(picture, skin, surface, s, np.where(y > 0, back, -belly), y)
    blotch(picture, skin.blotches)
    if skin.gills == 1 and skin.scales:
        _draw_lateral_line(picture, surface, s, y, level)
    _draw_shadow_of_fin(picture, surface, s, y)
    draw_face(picture, surface, skin, s, y, level)


def _paint_wings(picture: Array, species: Species, wing: WingPlan, s: Array, y: Array) -> None:
    """Paint a body with wings: both sides, spots, tail and face."""
    surface, skin, eye = species.surface, species.skin, species.surface.eye
    half = len(y) // 2
    below, above = picture[:, :half], picture[:, half:][:, ::-1]  # both from the spine outward
    right = half_height(surface) + y[:half]
    outline = [*wing.outline, *((x, -z) for x, z in wing.outline[::-1])]
    inside = depth_inside(outline, s, right)
    for side, colour in ((above, skin.back), (below, skin.belly)):
        side[:3] = np.array(colour, np.float32)[:, None, None]
        # Toward the edge both sides have the colour of the flank.
        blend(side, skin.flank, smoothstep(inside, EDGE_SHADE, 0.0))
    if skin.spots:
        scatter_spots(above, skin.spots, s, right, smoothstep(inside, 0.004, 0.008))
    for patch in skin.patches:
        blend_patch(above, patch, s, right, 0.0)
    begin = surface.tail.begin
    blend(picture, skin.tail.colour, smoothstep(s, begin - 0.03, begin) * np.ones_like(y))
    (tip, _), (corner, wide) = skin.mouth  # from the middle to the right
    lips = tip + (corner - tip) * (right / wide) ** 2
    mouth = smoothstep(np.abs(s - lips), 0.003, 0.001) * smoothstep(right, wide, 0.8 * wide)
    blend(below, DARK, 0.8 * mouth)
    for k in range(skin.gills):
        behind = s - eye.at - 0.045 - GILLS_APART * k
        slit = np.hypot(behind / 0.3, right - 0.045 + 0.003 * k)
        blend(below, DARK, 0.5 * smoothstep(slit, 0.010, 0.005))
    # The spiracle opens behind the eye.
    hole = np.hypot((s - eye.at - 0.02) / 0.008, (right - eye.height) / 0.006)
    blend(above, DARK, 0.85 * smoothstep(hole, 1.0, 0.6))
    blotch(picture, skin.blotches)
    # The eyes are lateral: seen from above the flank of the head is narrow.
    draw_eye(above, skin, s - eye.at, (right - eye.height) / FLANK, eye.radius)


def _draw_tail(
    picture: Array, skin: SkinPlan, surface: SurfacePlan, s: Array, reach: Array, y: Array
) -> None:
    """Draw the tail fin; `reach` is its extent from the axis, up where y > 0, else down."""
    begin, fin = surface.tail.begin, skin.tail
    rear = slice(int(np.searchsorted(s, begin)), None)
    share = y / reach[:, rear]
    shares = np.linspace(-1.0, 1.0, 257)
    edge = single(np.interp(share, shares, surface.tail.edge_at(shares)))
    out = single(((s[rear] - begin) / (edge - begin)).clip(0.0, 1.2))
    rays, between = ray_pattern(0.5 + 0.5 * share, out, 0, fin.soft_rays)  # fan out
    end = 1.0 - between * CUT_RAYS
    to_edge = np.minimum((end - out) * (edge - begin), reach[:, rear] - np.abs(y))
    blend_membrane(picture[:, :, rear], fin, skin.rays, out, rays, to_edge)


def _paint_fin(
    picture: Array, plan: FinPlan, fin: FinSkin, ridge: Curve, skin: SkinPlan, body: _Body
) -> None:
    """Paint a dorsal or ventral fin: columns along its base, rows from the root to its edge."""
    _, height, width = picture.shape
    share = single((np.arange(width) + 0.5) / width)
    up = single((np.arange(height)[:, None] + 0.5) / height)
    s, y = fin_points(plan, ridge, share, up)
    # 0 where it leaves the body, 1 at its edge.
    skirt = single(np.interp(s, body.s, along(ridge, body.s)))
    rise = np.abs(y) - np.abs(skirt)
    out = (rise / np.maximum(rise[-1], 0.004)).clip(0.0, 1.0)
    picture[:3], picture[3] = body.colours(s, np.where(rise > 0.0, 0.9 * skirt, y)), 1.0
    blend(picture, fin.colour, smoothstep(out, 0.0, 0.2))
    uneven = single(UNEVEN * tiled(cloud_noise(), out.shape))
    if fin.striped and skin.stripes:
        stripes = stripe_share(skin.stripes, s, y, uneven)
        blend(picture, skin.stripes.colour, stripes * smoothstep(out, 0.97, 0.85))
    coarse = fin_points(plan, ridge, every_fourth(share), every_fourth(up[:, 0])[:, None])
    for patch in skin.patches:
        if patch.over_fins and boxes_overlap(patch.outline, *coarse):
            depth = upsampled(upsampled(depth_at(patch.outline, *coarse).T, width).T, height)
            blend_rings(picture, patch, depth + uneven)
    rays, between = ray_pattern(share, out, fin.spines, fin.soft_rays)
    spiny = share * (fin.spines + fin.soft_rays) < fin.spines
    end = 1.0 - between * np.where(spiny, CUT_SPINES, CUT_RAYS)
    to_edge = (end - out) * np.maximum(rise[-1], 0.004)
    if not fin.spines + fin.soft_rays:
        to_edge = to_edge + 0.01
    blend_membrane(picture, fin, skin.rays, out, rays, to_edge)
    blotch(picture, skin.blotches)


def _paint_paddle(
    picture: Array, plan: PaddlePlan, fin: FinSkin, skin: SkinPlan, body: _Body
) -> None:
    """Paint a paired fin: columns from its root to its end, rows across."""
    _, height, width = picture.shape
    along_it = single((np.arange(width) + 0.5) / width)
    middle = single(2.0 * (np.arange(height)[:, None] + 0.5) / height - 1.0)
    out = along_it + np.zeros_like(middle)
    # Its fleshy root has the colour of the flank.
    root = body.colours(np.array([[plan.at]]), np.array([[plan.height]]))
    picture[:3], picture[3] = root, 1.0
    if plan.wing:
        picture[:3] = np.array(fin.colour, np.float32)[:, None, None]
        if fin.rim:
            blend(picture, fin.rim, smoothstep((1.0 - out) / fin.rim_width, 1.0, 0.7))
    else:
        blend(picture, fin.colour, smoothstep(out + 0.08 * middle**2, 0.06, 0.2))
        rays, between = ray_pattern(0.5 + 0.5 * middle, out, 0, PADDLE_RAYS)
        end = 0.965 - 0.04 * between - 0.2 * middle**4
        beside = 0.5 * plan.width * (1.0 - np.abs(middle)) * smoothstep(out, 0.1, 0.4) + 0.004
        # Rounded where it leaves the flank.
        beside = np.minimum(beside, plan.length * (out - 0.06 * middle**2) + 0.001)
        to_edge = np.minimum((end - out) * plan.length, beside)
        to_rim = (end - out) / fin.rim_width
        plain = PADDLE_CONTRAST * skin.rays
        blend_membrane(picture, fin, plain, out, rays, to_edge, to_rim, PADDLE_FLESHY)
    blotch(picture, skin.blotches)


def _draw_lateral_line(
    picture: Array, surface: SurfacePlan, s: Array, y: Array, level: Array
) -> None:
    """Draw the row of pores from the gill cover to the tail, arched over the pectoral fin."""
    begin, end = surface.eye.at + 0.15, surface.tail.begin
    here = slice(*np.searchsorted(s, (begin, end)))
    t = (s[here] - begin) / (end - begin)
    arch = 0.42 * (1.0 - t) ** 1.2 * (1.0 - smoothstep(t, 0.85, 1.0)) + 0.02
    back = single(along(surface.back, s[here]))
    off = np.abs(y - arch * back) / 0.0028
    near = np.flatnonzero((off < 1.0).any(axis=1))
    rows = slice(near[0], near[-1] + 1)
    pores = 0.5 + 0.5 * np.cos(2 * np.pi / PORES * s[here])
    picture[:3, rows, here] *= 1.0 - (0.1 + 0.1 * pores) * smoothstep(off[rows], 1.0, 0.2)


def _draw_shadow_of_fin(picture: Array, surface: SurfacePlan, s: Array, y: Array) -> None:
    """Darken the flank behind a pectoral fin and around its root."""
    fin = surface.pectoral
    if fin is None or fin.wing:
        return
    middle = (fin.at + 0.3 * fin.length, fin.height - 0.22 * fin.width)
    size = (0.55 * fin.length, 0.7 * fin.width)
    corners = [(middle[0] + a * size[0], middle[1] + b * size[1]) for a in (-1, 1) for b in (-1, 1)]
    rows, columns = texels_around(corners, 0.0, s, y)
    far = np.hypot((s[columns] - middle[0]) / size[0], (y[rows] - middle[1]) / size[1])
    picture[:3, rows, columns] *= 1.0 - 0.22 * smoothstep(far, 1.0, 0.1)
    root = np.hypot((s[columns] - fin.at) / 0.012, (y[rows] - fin.height) / (0.3 * fin.width))
    picture[:3, rows, columns] *= 1.0 - 0.4 * smoothstep(root, 1.0, 0.4)
