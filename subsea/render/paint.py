"""Skins painted once at start: what SMC §4 takes from photographs of real fishes.

A skin is the fish's left flank seen from the side at rest, with its fins. That of a fish with wings
shows one of them from above and below, unfolded at the edge: its upper border is the spine, then
comes the wing's upper side, in the middle all that lies beyond the tips, below it the wing's lower
side, and its lower border is the keel. Colours are mixed in
linear light and stored in sRGB; alpha is the opacity, 1 on the body.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.kinematics.surface import Curve, FinPlan, SurfacePlan, WingPlan, along
from subsea.species import Colour, FinSkin, Patch, SkinPlan, Species, Spots, Stripes

Array = NDArray[np.floating[Any]]

SIZE = (1024, 512)  # texels
SNOUT, EDGE = -0.03, 1.05  # distances from the snout at the left and right border, but of wings
MARGIN = 0.03  # above and below the fins, body lengths
SOFT = 0.004  # width of the borders between colours, body lengths
SLENDER = 0.1  # depth in body lengths below which the head is short too
DARK = (0.012, 0.012, 0.016)  # the pupil and the rim of the eye
FLANK = 0.45  # how wide what lies on the flank of a flat head looks from above
EDGE_SHADE = 0.02  # width of the band along the edge of a wing, body lengths
GILLS_APART = 0.016  # body lengths
RAYS = 13.0  # of the tail, on each side


def half_height(surface: SurfacePlan) -> float:
    """Height of the skin's upper border above the axis; the lower one lies as far below."""
    fins = [fin.edge for fin in (surface.dorsal, surface.ventral) if fin]
    curves = (surface.back, surface.belly, *fins)
    wide = surface.wing.span if surface.wing else 0.0
    return MARGIN + max(wide, *(abs(y) for curve in curves for _, y in curve))


def borders(surface: SurfacePlan) -> tuple[float, float]:
    """Distances from the snout at the left and right border; a whip of a tail has one colour."""
    return SNOUT, surface.tail.begin + 0.05 if surface.wing else EDGE


def unfolded(surface: SurfacePlan, right: Array, upper: Array) -> Array:
    """Height on the skin of points at `right` of the spine of a fish with wings, either side up."""
    return np.asarray(np.where(upper, 1.0, -1.0) * (half_height(surface) - np.abs(right)))


def head_size(surface: SurfacePlan) -> float:
    """The size of gill cover and jaws: 1 for most fishes, less for a body like a rope."""
    return min(1.0, surface.depth / SLENDER)


def eye_height(surface: SurfacePlan) -> float:
    """Height of the eye on the skin."""
    eye = surface.eye
    return half_height(surface) - eye.height if surface.wing else eye.height


def paint(species: Species, size: tuple[int, int] = SIZE) -> NDArray[np.uint8]:
    """The skin (height, width, 4), bottom row first, as OpenGL wants it."""
    surface, skin = species.surface, species.skin
    width, height = size
    top = half_height(surface)
    front, rear = borders(surface)
    s = _single(front + (rear - front) * (np.arange(width) + 0.5) / width)
    y = _single(-top + 2 * top * (np.arange(height)[:, None] + 0.5) / height)
    if surface.wing:
        return _bytes(_unfolded_skin(species, surface.wing, s, y))
    back, belly = _single(along(surface.back, s)), _single(along(surface.belly, s))
    # 1 at the dorsal ridge, 0 on the axis, -1 at the ventral ridge.
    level = np.where(y > 0, y / back, -y / belly)
    picture = np.ones((4, height, width), np.float32)  # planes: red, green, blue, opacity
    picture[:3] = np.array(skin.belly, np.float32)[:, None, None]
    _lay(picture, skin.flank, _step(level, -0.75, 0.1))
    _lay(picture, skin.back, _step(level, 0.25, 0.95))
    if skin.clear_back:
        behind_eye = _step(s, surface.eye.at + 0.05, surface.eye.at + 0.2)
        picture[3] -= skin.clear_back * _step(level, 0.0, 0.5) * behind_eye
    stripes = np.zeros_like(level)
    if skin.stripes:
        stripes = _stripes(skin.stripes, s, y)
        _lay(picture, skin.stripes.colour, stripes)
    if skin.cape:
        line = _single(along(skin.cape.line, s))
        _lay(picture, skin.cape.colour, _step(level - line, -0.12, 0.12))
    for patch in skin.patches:
        if not patch.over_fins:
            _lay_patch(picture, patch, s, y)
    _lay_tail(picture, skin, surface, s, np.where(y > 0, back, -belly), y)
    for plan, fin, rise in (
        (surface.dorsal, skin.dorsal, y - back),
        (surface.ventral, skin.ventral, belly - y),
    ):
        if plan and fin:
            _lay_fin(picture, plan, fin, skin.stripes, stripes, s, y, rise)
    for patch in skin.patches:
        if patch.over_fins:
            _lay_patch(picture, patch, s, y)
    _draw_face(picture, surface, skin, s, y, level)
    picture[:3] *= _mottle(height, width)
    return _bytes(picture)


def _unfolded_skin(species: Species, wing: WingPlan, s: Array, y: Array) -> Array:
    """The planes of a skin of a fish with wings: both sides, spots, tail and face."""
    surface, skin, eye = species.surface, species.skin, species.surface.eye
    picture = np.ones((4, len(y), len(s)), np.float32)
    half = len(y) // 2
    below, above = picture[:, :half], picture[:, half:][:, ::-1]  # both from the spine outward
    right = half_height(surface) + y[:half]
    outline = [*wing.outline, *((x, -z) for x, z in wing.outline[::-1])]
    inside = _depth_inside(outline, s, right)
    for side, colour in ((above, skin.back), (below, skin.belly)):
        side[:3] = np.array(colour, np.float32)[:, None, None]
        # Toward the edge both sides take on the colour of the flank.
        _lay(side, skin.flank, _step(inside, EDGE_SHADE, 0.0))
    if skin.spots:
        _strew(above, skin.spots, s, right, _step(inside, 0.004, 0.008))
    for patch in skin.patches:
        _lay_patch(above, patch, s, right)
    begin = surface.tail.begin
    _lay(picture, skin.tail.colour, _step(s, begin - 0.03, begin) * np.ones_like(y))
    (tip, _), (corner, wide) = skin.mouth  # from the middle to the right
    lips = tip + (corner - tip) * (right / wide) ** 2
    mouth = _step(np.abs(s - lips), 0.003, 0.001) * _step(right, wide, 0.8 * wide)
    _lay(below, DARK, 0.8 * mouth)
    for k in range(skin.gills):
        behind = s - eye.at - 0.045 - GILLS_APART * k
        slit = np.hypot(behind / 0.3, right - 0.045 + 0.003 * k)
        _lay(below, DARK, 0.5 * _step(slit, 0.010, 0.005))
    # The eyes look aside: seen from above the flank of the head is narrow.
    distance = np.hypot(s - eye.at, (right - eye.height) / FLANK) / eye.radius
    for colour, outer in ((DARK, 1.1), (skin.iris, 1.0), (DARK, 0.66)):
        _lay(above, colour, _step(distance, outer, outer - 0.14))
    picture[:3] *= _mottle(len(y), len(s))
    return picture


def _strew(picture: Array, plan: Spots, s: Array, right: Array, where: Array) -> None:
    """Lay round spots on a wavering grid, each of its own size."""
    rng = np.random.default_rng(0x5B07)
    rows = np.arange(-0.5 * plan.spacing, right.max(), plan.spacing * np.sqrt(0.75))
    share = np.zeros_like(where)
    for k, z in enumerate(rows):
        for x in np.arange(s[0], s[-1], plan.spacing) + 0.5 * plan.spacing * (k % 2):
            place = np.array([x, z]) + rng.uniform(-0.22, 0.22, 2) * plan.spacing
            radius = rng.uniform(*plan.radius)
            columns = slice(*np.searchsorted(s, place[0] + radius * np.array([-1.5, 1.5])))
            near = np.flatnonzero(np.abs(right[:, 0] - place[1]) < 1.5 * radius)
            far = np.hypot(s[columns] - place[0], right[near] - place[1]) / radius
            share[near, columns] = np.maximum(share[near, columns], _step(far, 1.25, 0.8))
    _lay(picture, plan.colour, share * where)


def _stripes(plan: Stripes, s: Array, y: Array) -> Array:
    """Where the stripes are, 0 to 1: they waver a little, as drawn by hand."""
    waver = 0.09 * np.sin(19.0 * s + 23.0 * y) + 0.05 * np.sin(43.0 * s - 31.0 * y)
    if plan.upright:
        phase = (s - plan.rise * y) / plan.spacing + waver
    else:
        phase = (y - plan.rise * (s - 0.5) + 0.12 * (s - 0.55) ** 2) / plan.spacing + waver
    wave = np.abs((phase % 1.0) - 0.5) * 2.0  # 0 in the middle of a stripe, 1 between two
    soft = SOFT / plan.spacing
    here = _step(s, plan.begin - 0.01, plan.begin + 0.02) * _step(s, plan.end, plan.end - 0.03)
    return _step(wave, plan.share + soft, plan.share - soft) * here


def _lay_patch(picture: Array, plan: Patch, s: Array, y: Array) -> None:
    half = plan.soft / 2
    rows, columns = _around(plan.outline, plan.rim_width + half, s, y)
    picture = picture[:, rows, columns]
    depth = _depth_inside(plan.outline, s[columns], y[rows])
    if plan.rim:
        _lay(picture, plan.rim, _step(depth, -plan.rim_width - half, -plan.rim_width + half))
    _lay(picture, plan.colour, _step(depth, -half, half))


def _lay_tail(
    picture: Array, skin: SkinPlan, surface: SurfacePlan, s: Array, reach: Array, y: Array
) -> None:
    """`reach` is how far the fin extends from the axis, up where y > 0, else down."""
    begin, fin = surface.tail.begin, skin.tail
    _lay(picture, fin.colour, _step(s, begin - 0.05, begin + 0.02) * np.ones_like(reach))
    rear = slice(int(np.searchsorted(s, begin)), None)
    share = y / reach[:, rear]
    edge = surface.tail.edge_at(share.clip(-1.0, 1.0))
    out = _single(((s[rear] - begin) / (edge - begin)).clip(0.0, 1.0))
    # Rays fan out from the root.
    rays = 0.5 + 0.5 * np.cos(np.pi * RAYS * share)
    picture[:3, :, rear] *= 1.0 - 0.22 * skin.rays * rays * _step(out, 0.02, 0.3)
    if fin.rim:
        to_edge = np.minimum(edge - s[rear], reach[:, rear] - np.abs(y)) / fin.rim_width
        _lay(picture[:, :, rear], fin.rim, _step(to_edge, 1.0, 0.7) * _step(out, 0.2, 0.5))
    picture[3, :, rear] *= 1.0 - (1.0 - fin.opacity) * _step(out, 0.1, 0.9)


def _lay_fin(
    picture: Array, plan: FinPlan, fin: FinSkin, striped: Stripes | None, stripes: Array,
    s: Array, y: Array, rise: Array,
) -> None:  # fmt: skip
    """All that rises over the ridge, from the fin's front to its rear."""
    outline = [*plan.edge, (plan.base[1], 0.0), (plan.base[0], 0.0)]  # closed through the body
    around = min(0.02, 2.0 * fin.rim_width)
    rows, columns = _around(outline, around, s, y)
    picture, stripes = picture[:, rows, columns], stripes[rows, columns]
    s, y, rise = s[columns], y[rows], rise[rows, columns]
    to_edge = -_depth_inside(outline, s, y)
    here = (s > plan.base[0] - around) & (rise > 0.0) & (to_edge < around)
    thickness = np.where(here, rise / np.maximum(rise - to_edge, 1e-6), 0.0)  # 0 root, 1 edge
    _lay(picture, fin.colour, here * _step(thickness, 0.0, 0.25))
    if fin.striped and striped:
        _lay(picture, striped.colour, here * stripes * _step(thickness, 0.95, 0.8))
    if fin.rim:
        _lay(picture, fin.rim, here * _step(to_edge, -fin.rim_width, -2.0 / 3.0 * fin.rim_width))
    opacity = 1.0 - (1.0 - fin.opacity) * _step(thickness, 0.05, 1.0)
    picture[3] = np.where(here, opacity, picture[3])


def _draw_face(
    picture: Array, surface: SurfacePlan, skin: SkinPlan, s: Array, y: Array, level: Array
) -> None:
    """The edge of the gill cover or the gill slits, the mouth and the eye."""
    eye = surface.eye
    large = head_size(surface)
    reach = 0.16 + 0.01 * skin.gills
    head = slice(0, int(np.searchsorted(s, max(eye.at + large * reach, skin.mouth[1][0]) + 0.01)))
    picture, s, level = picture[:, :, head], s[head], level[:, head]
    at = (s - eye.at) / large - 0.135 + 0.05 * level**2 + 0.02 * level
    tall, thick = ((0.85, 0.55), 0.006) if skin.gills == 1 else ((0.5, 0.3), 0.0045)
    for k in range(skin.gills):
        gill = np.abs(at + GILLS_APART * (k - 0.5 * (skin.gills - 1)))
        picture[:3] *= 1.0 - 0.4 * _step(gill, thick, 0.0) * _step(np.abs(level), *tall)
    (tip, height), (corner, low) = skin.mouth
    mouth = np.abs(y - height - (low - height) / (corner - tip) * (s - tip)) / large
    mouth = _step(mouth, 0.005, 0.0025) * _step(s, corner + 0.004 * large, corner - 0.004 * large)
    picture[:3] *= 1.0 - 0.75 * mouth * _step(s, tip - 0.004, tip + 0.004)
    distance = np.hypot(s - eye.at, y - eye.height) / eye.radius
    for colour, outer in ((DARK, 1.1), (skin.iris, 1.0), (DARK, 0.66)):
        _lay(picture, colour, _step(distance, outer, outer - 0.14))


def _around(outline: Curve, reach: float, s: Array, y: Array) -> tuple[slice, slice]:
    """Rows and columns of the texels within `reach` of the box around an outline."""
    low, high = np.min(outline, axis=0) - reach, np.max(outline, axis=0) + reach
    rows, columns = (
        np.searchsorted(y[:, 0], (low[1], high[1])),
        np.searchsorted(s, (low[0], high[0])),
    )
    return slice(*rows), slice(*columns)


def _depth_inside(outline: Curve, s: Array, y: Array) -> Array:
    """Distance (h, w) from a smooth closed outline, positive inside, in body lengths.

    They are measured at every fourth texel each way and interpolated.
    """
    corners = _rounded(np.asarray(outline, np.float32))
    x, h = _every_fourth(s), _every_fourth(y[:, 0])[:, None]
    inside = np.zeros((len(h), len(x)), bool)
    nearest = np.full((len(h), len(x)), np.inf, np.float32)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        dx, dy = bx - ax, by - ay
        t = (((x - ax) * dx + (h - ay) * dy) / max(dx * dx + dy * dy, 1e-12)).clip(0.0, 1.0)
        nearest = np.minimum(nearest, (x - ax - t * dx) ** 2 + (h - ay - t * dy) ** 2)
        if ay != by:
            inside ^= ((ay > h) != (by > h)) & (x < ax + dx * (h - ay) / dy)
    coarse = np.where(inside, np.float32(1.0), np.float32(-1.0)) * np.sqrt(nearest)
    return _between(_between(coarse.T, len(s)).T, len(y))


def _every_fourth(x: Array) -> Array:
    """Every fourth of evenly spaced numbers, on beyond the last."""
    step = x[1] - x[0] if len(x) > 1 else 1.0
    return _single(x[0] + 4 * step * np.arange(len(x) // 4 + 2)) if len(x) else x


def _between(values: Array, count: int) -> Array:
    """Rows (count, n) from every fourth of them, linear between."""
    cell, t = np.divmod(np.arange(count), 4)
    share = _single(t / 4)[:, None]
    return np.asarray(values[cell] + share * (values[cell + 1] - values[cell]))


def _rounded(corners: Array) -> Array:
    """Twice Chaikin's corner cutting, which tends to the quadratic B-spline."""
    for _ in range(2):
        following = np.roll(corners, -1, axis=0)
        pair = np.stack([0.75 * corners + 0.25 * following, 0.25 * corners + 0.75 * following], 1)
        corners = pair.reshape(-1, 2)
    return corners


@cache
def _mottle(height: int, width: int) -> Array:
    """Small unevenness of the paint, mean 1; the same for all species."""
    noise = np.random.default_rng(0x5C1).normal(size=(height, width))
    k = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width))
    smooth = np.fft.irfft2(np.fft.rfft2(noise) * np.exp(-((k / 0.04) ** 2)), s=(height, width))
    return _single(1.0 + 0.05 * smooth / smooth.std())


def _step(x: Array, low: float, high: float) -> Array:
    """0 at `low`, 1 at `high`, smooth between; `high` may be the smaller one."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    smooth = 3.0 - 2.0 * t
    smooth *= t
    smooth *= t
    return np.asarray(smooth)


def _lay(picture: Array, colour: Colour, share: Array) -> None:
    """Mix a colour into the planes by `share` (h, w), 0 to 1, where it is not zero."""
    rows, columns = (np.flatnonzero(share.any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    share = _single(share[box])
    for plane, value in zip(picture, colour, strict=False):  # opacity stays
        under = plane[box]
        under += (np.float32(value) - under) * share


def _single(values: Array) -> Array:
    """Eight bits are kept in the end: single precision is ample, and twice as fast."""
    return np.asarray(values, np.float32)


def _bytes(picture: Array) -> NDArray[np.uint8]:
    """Planes to texels; colours to sRGB by a table of 4,096 steps, which eight bits do not show."""
    linear = np.linspace(0.0, 1.0, 4097)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    table = np.round(255.0 * encoded).astype(np.uint8)
    texels = np.empty((*picture.shape[1:], 4), np.uint8)
    for k in range(3):
        texels[..., k] = table[(4096.0 * picture[k].clip(0.0, 1.0) + 0.5).astype(np.int16)]
    texels[..., 3] = np.round(255.0 * picture[3])
    return texels
