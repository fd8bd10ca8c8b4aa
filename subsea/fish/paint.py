"""Skins painted once at start: what SMC §4 takes from photographs of real fishes.

A skin is one sheet. Most of it is the body with its tail: the left flank seen from the side at
rest. That of a fish with wings shows one of them from above and below, unfolded at the edge: its
upper border is the spine, then comes the wing's upper side, in the middle all that lies beyond the
tips, below it the wing's lower side, and its lower border is the keel. Above the body lie the
fins, each in a frame of its own whose sides are the parameters of its surface. Colours are mixed
in linear light and stored in sRGB; alpha is the opacity, 1 on the body.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array
from subsea.fish.species import Colour, FinSkin, SkinPatch, SkinPlan, SkinSpots, Species, Stripes
from subsea.fish.surface import (
    SUNK,
    Curve,
    FinPlan,
    PaddlePlan,
    SurfacePlan,
    WingPlan,
    along,
    travelled,
)

Sheet = TypeVar("Sheet", Array, NDArray[np.uint8])


class SheetRegion(NamedTuple):
    """A rectangle of the sheet, in shares of its width and height from the lower left corner."""

    left: float
    bottom: float
    right: float
    top: float


SIZE = (1024, 640)  # texels
BODY = SheetRegion(0.0, 0.0, 1.0, 0.8)
DORSAL = SheetRegion(0.0, 0.8, 1.0, 0.9)  # to the right the base, upwards from the root to the edge
VENTRAL = SheetRegion(0.0, 0.9, 0.5, 1.0)
PECTORAL = SheetRegion(0.5, 0.9, 0.75, 1.0)  # to the right from the root to the end, upwards across
PELVIC = SheetRegion(0.75, 0.9, 1.0, 1.0)

SNOUT, EDGE = -0.03, 1.05  # distances from the snout at the left and right border, but of wings
MARGIN = 0.02  # above and below the body, body lengths
SOFT = 0.003  # width of the borders between colours, body lengths
UNEVEN = 0.0016  # by how much these borders waver, body lengths
SLENDER = 0.1  # depth in body lengths below which the head is short too
DARK = (0.012, 0.012, 0.016)  # the pupil and the rim of the eye
FLANK = 0.45  # how wide what lies on the flank of a flat head looks from above
EDGE_SHADE = 0.02  # width of the band along the edge of a wing, body lengths
SPOT_SOFT = 0.0013  # half the width of a spot's border, body lengths
GILLS_APART = 0.016  # body lengths
PORES = 0.0115  # from one scale of the lateral line to the next, body lengths
CUT_SPINES, CUT_RAYS = 0.15, 0.05  # how far the membrane is cut in between them, share of the fin
PADDLE_RAYS = 13


def paint_all(species: Sequence[Species]) -> list[NDArray[np.uint8]]:
    """The skins of many species, painted at once: numpy lets go of the interpreter's lock."""
    _cloud(), _grain()  # all want them: not each should make its own
    with ThreadPoolExecutor() as pool:
        return list(pool.map(paint, species))


def half_height(surface: SurfacePlan) -> float:
    """Height of the body's upper border above the axis; the lower one lies as far below."""
    wide = surface.wing.span if surface.wing else 0.0
    return MARGIN + max(
        wide, *(abs(y) for curve in (surface.back, surface.belly) for _, y in curve)
    )


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
    sheet = np.zeros((4, size[1], size[0]), np.float32)  # planes: red, green, blue, opacity
    body = framed(sheet, BODY)
    _, height, width = body.shape
    top = half_height(surface)
    front, rear = borders(surface)
    s = _single(front + (rear - front) * (np.arange(width) + 0.5) / width)
    y = _single(-top + 2 * top * (np.arange(height)[:, None] + 0.5) / height)
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
            _paint_fin(framed(sheet, frame), fin, look, ridge, skin, _Body(body, s, y))
    for frame, paddle in ((PECTORAL, surface.pectoral), (PELVIC, surface.pelvic)):
        if paddle and skin.paddles:
            _paint_paddle(framed(sheet, frame), paddle, skin.paddles, skin, _Body(body, s, y))
    return encoded(sheet)


def framed(sheet: Sheet, frame: SheetRegion) -> Sheet:
    """The part of the sheet (4, h, w) within a frame."""
    _, height, width = sheet.shape
    rows = slice(round(frame.bottom * height), round(frame.top * height))
    return sheet[:, rows, round(frame.left * width) : round(frame.right * width)]


class _Body(NamedTuple):
    """The painted body, from which fins take the colour of their roots."""

    picture: Array  # (4, h, w)
    s: Array  # (w,) distance from the snout of each column
    y: Array  # (h, 1) height of each row

    def colours(self, s: Array, y: Array) -> Array:
        """The colours (3, ...) at places."""
        _, height, width = self.picture.shape
        column = (s - self.s[0]) * ((width - 1) / (self.s[-1] - self.s[0]))
        row = (y - self.y[0, 0]) * ((height - 1) / (self.y[-1, 0] - self.y[0, 0]))
        return np.asarray(
            self.picture[
                :3,
                row.clip(0, height - 1).astype(np.int32),
                column.clip(0, width - 1).astype(np.int32),
            ]
        )


def _paint_flank(picture: Array, species: Species, s: Array, y: Array) -> None:
    """A body seen from its left: colours from back to belly, patterns, tail, then what is bone."""
    surface, skin = species.surface, species.skin
    back, belly = _single(along(surface.back, s)), _single(along(surface.belly, s))
    # 1 at the dorsal ridge, 0 on the axis, -1 at the ventral ridge.
    level = np.where(y > 0, y / back, -y / belly)
    cloud = _over(_cloud(), level.shape)
    uneven = UNEVEN * head_size(surface) * cloud
    shade = level + 0.05 * cloud
    picture[:3] = np.array(skin.belly, np.float32)[:, None, None]
    _lay(picture, skin.flank, _step(shade, -0.75, 0.1))
    _lay(picture, skin.back, _step(shade, 0.25, 0.95))
    if skin.clear_back:
        behind_eye = _step(s, surface.eye.at + 0.05, surface.eye.at + 0.2)
        picture[3] -= skin.clear_back * _step(level, 0.0, 0.5) * behind_eye
    if skin.stripes:
        _lay(picture, skin.stripes.colour, _stripes(skin.stripes, s, y, uneven))
    if skin.cape:
        line = _single(along(skin.cape.line, s))
        _lay(picture, skin.cape.colour, _step(shade - line, -skin.cape.soft, skin.cape.soft))
    for patch in skin.patches:
        if not patch.over_fins:
            _lay_patch(picture, patch, s, y, uneven)
    begin = surface.tail.begin
    _lay(picture, skin.tail.colour, _step(s, begin - 0.05, begin + 0.02) * np.ones_like(level))
    for patch in skin.patches:
        if patch.over_fins:
            _lay_patch(picture, patch, s, y, uneven)
    _draw_tail(picture, skin, surface, s, np.where(y > 0, back, -belly), y)
    _colour_unevenly(picture, skin.blotches)
    if skin.gills == 1 and skin.scales:
        _draw_lateral_line(picture, surface, s, y, level)
    _draw_shadow_of_fin(picture, surface, s, y)
    _draw_face(picture, surface, skin, s, y, level)


def _colour_unevenly(picture: Array, amount: float) -> None:
    """No patch of a living skin has one colour: it is warmer here and cooler there."""
    shape = picture.shape[1:]
    cloud, other = _over(_grain()[::-1], shape), _over(_grain()[:, ::-1], shape)
    for plane, warmth, light in zip(
        picture, (0.055, 0.01, -0.05), (0.06, 0.07, 0.06), strict=False
    ):
        plane *= 1.0 + amount * (np.float32(warmth) * cloud + np.float32(light) * other)


def _paint_wings(picture: Array, species: Species, wing: WingPlan, s: Array, y: Array) -> None:
    """A body with wings: both sides, spots, tail and face."""
    surface, skin, eye = species.surface, species.skin, species.surface.eye
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
        _lay_patch(above, patch, s, right, 0.0)
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
    # The spiracle opens behind the eye.
    hole = np.hypot((s - eye.at - 0.02) / 0.008, (right - eye.height) / 0.006)
    _lay(above, DARK, 0.85 * _step(hole, 1.0, 0.6))
    _colour_unevenly(picture, skin.blotches)
    # The eyes look aside: seen from above the flank of the head is narrow.
    _draw_eye(above, skin, s - eye.at, (right - eye.height) / FLANK, eye.radius)


def _strew(picture: Array, plan: SkinSpots, s: Array, right: Array, where: Array) -> None:
    """Lay round spots on a wavering grid, each of its own size; some of them are rings."""
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
            spot = _step(far, SPOT_SOFT, -SPOT_SOFT)
            if kind < plan.rings and size > 0.35:  # a small one would close
                spot *= _step(far + 0.5 * radius, -SPOT_SOFT, SPOT_SOFT)
            share[near, columns] = np.maximum(share[near, columns], spot)
    _lay(picture, plan.colour, share * where)


def _stripes(plan: Stripes, s: Array, y: Array, uneven: Array) -> Array:
    """Where the stripes are, 0 to 1: they waver a little, and taper at both ends."""
    waver = 0.09 * _sine(19.0 * s, 23.0 * y) + 0.05 * _sine(43.0 * s, -31.0 * y)
    if plan.upright:
        phase = (s - plan.rise * y + uneven) / plan.spacing + waver
    else:
        phase = (y - plan.rise * (s - 0.5) + 0.12 * (s - 0.55) ** 2 + uneven) / plan.spacing + waver
    wave = np.abs((phase % 1.0) - 0.5) * 2.0  # 0 in the middle of a stripe, 1 between two
    soft = SOFT / plan.spacing
    taper = _step(s, plan.begin - 0.005, plan.begin + 0.05)
    taper = taper * _step(s, plan.end + 0.005, plan.end - 0.05)
    share = plan.share * np.sqrt(taper)
    return _smooth((share + soft - wave) / (2.0 * soft)) * (taper > 0.0)


def _sine(a: Array, b: Array) -> Array:
    """Sine of a + b, quickly where one runs along the columns and one along the rows."""
    return np.asarray(np.sin(a) * np.cos(b) + np.cos(a) * np.sin(b))


def _lay_patch(picture: Array, plan: SkinPatch, s: Array, y: Array, uneven: Array | float) -> None:
    half = plan.soft / 2
    rows, columns = _around(plan.outline, plan.rim_width + half + 3 * UNEVEN, s, y)
    picture = picture[:, rows, columns]
    depth = _depth_inside(plan.outline, s[columns], y[rows])
    if isinstance(uneven, np.ndarray):
        depth += uneven[rows, columns]
    _lay_ringed(picture, plan, depth)


def _lay_ringed(picture: Array, plan: SkinPatch, depth: Array) -> None:
    """The colours of a patch, where its outline is `depth` away."""
    half = plan.soft / 2
    if plan.rim:
        _lay(picture, plan.rim, _step(depth, -plan.rim_width - half, -plan.rim_width + half))
    _lay(picture, plan.colour, _step(depth, -half, half))


def _draw_tail(
    picture: Array, skin: SkinPlan, surface: SurfacePlan, s: Array, reach: Array, y: Array
) -> None:
    """`reach` is how far the fin extends from the axis, up where y > 0, else down."""
    begin, fin = surface.tail.begin, skin.tail
    rear = slice(int(np.searchsorted(s, begin)), None)
    share = y / reach[:, rear]
    shares = np.linspace(-1.0, 1.0, 257)
    edge = _single(np.interp(share, shares, surface.tail.edge_at(shares)))
    out = _single(((s[rear] - begin) / (edge - begin)).clip(0.0, 1.2))
    rays, between = _rays(0.5 + 0.5 * share, out, 0, fin.soft_rays)  # they fan out from the root
    end = 1.0 - between * CUT_RAYS
    to_edge = np.minimum((end - out) * (edge - begin), reach[:, rear] - np.abs(y))
    _lay_membrane(picture[:, :, rear], fin, skin.rays, out, rays, to_edge)


def _rays(share: Array, out: Array, spines: int, rays: int) -> tuple[Array, Array]:
    """How plainly a ray shows, and how far between two one is (0 on a ray, 1 in the middle).

    At `share` (0 to 1) of the way along a fin's base, of which spines take the front, and `out`
    (0 to 1) of the way to its edge. Rays part in two on their way.
    """
    count = spines + rays
    if not count:
        return np.zeros_like(out), np.zeros_like(out)
    place = share * count
    off = np.abs(place % 1.0 - 0.5) * 2.0  # 0 in the middle of a ray
    fork = np.where(place < spines, 0.0, 0.34 * _step(out, 0.25, 1.0))
    wide = np.where(place < spines, 0.30 - 0.16 * out, 0.30 - 0.15 * out)
    return _step(np.abs(off - fork), wide + 0.12, wide - 0.14), off**3


def _lay_membrane(
    picture: Array, fin: FinSkin, plain: float, out: Array, rays: Array, to_edge: Array,
    to_rim: Array | None = None,
) -> None:  # fmt: skip
    """Rays, the rim along the edge, and how much light the membrane between the rays lets by.

    `to_edge` is how far the edge is, in body lengths, `to_rim` the same in widths of the rim.
    """
    root = _step(out, 0.02, 0.25)
    picture[:3] *= 1.0 - 0.3 * plain * rays * root
    if fin.rim:
        rim = to_edge / fin.rim_width if to_rim is None else to_rim
        _lay(picture, fin.rim, _step(rim, 1.0, 0.7) * root)
    clear = (1.0 - fin.opacity) * _step(out, 0.05, 0.8)
    # Of a clear fin the rays hold most of what there is to see, and it frays at its edge.
    clear = clear * (1.0 - 0.55 * plain * rays)
    picture[3] *= (1.0 - clear) * _step(to_edge, 0.0, 0.004)


def _paint_fin(
    picture: Array, plan: FinPlan, fin: FinSkin, ridge: Curve, skin: SkinPlan, body: _Body
) -> None:
    """A dorsal or ventral fin: columns along its base, rows from within the body to its edge."""
    _, height, width = picture.shape
    share = _single((np.arange(width) + 0.5) / width)
    up = _single((np.arange(height)[:, None] + 0.5) / height)
    s, y = fin_places(plan, ridge, share, up)
    # From where it leaves the body, 0, to its edge, 1.
    skirt = _single(np.interp(s, body.s, along(ridge, body.s)))
    rise = np.abs(y) - np.abs(skirt)
    out = (rise / np.maximum(rise[-1], 0.004)).clip(0.0, 1.0)
    picture[:3], picture[3] = body.colours(s, np.where(rise > 0.0, 0.9 * skirt, y)), 1.0
    _lay(picture, fin.colour, _step(out, 0.0, 0.2))
    uneven = _single(UNEVEN * _over(_cloud(), out.shape))
    if fin.striped and skin.stripes:
        stripes = _stripes(skin.stripes, s, y, uneven)
        _lay(picture, skin.stripes.colour, stripes * _step(out, 0.97, 0.85))
    coarse = fin_places(plan, ridge, _every_fourth(share), _every_fourth(up[:, 0])[:, None])
    for patch in skin.patches:
        if patch.over_fins and _near(patch.outline, *coarse):
            depth = _between(_between(_depth_at(patch.outline, *coarse).T, width).T, height)
            _lay_ringed(picture, patch, depth + uneven)
    rays, between = _rays(share, out, fin.spines, fin.soft_rays)
    spiny = share * (fin.spines + fin.soft_rays) < fin.spines
    end = 1.0 - between * np.where(spiny, CUT_SPINES, CUT_RAYS)
    to_edge = (end - out) * np.maximum(rise[-1], 0.004)
    if not fin.spines + fin.soft_rays:
        to_edge = to_edge + 0.01
    _lay_membrane(picture, fin, skin.rays, out, rays, to_edge)
    _colour_unevenly(picture, skin.blotches)


def fin_places(plan: FinPlan, ridge: Curve, share: Array, up: Array) -> tuple[Array, Array]:
    """Distances from the snout and heights, from the row in the body to the edge."""
    share = share.clip(0.0, 1.0)
    base = plan.base[0] + (plan.base[1] - plan.base[0]) * share
    edge = travelled(plan.edge, share)
    root = SUNK * along(ridge, base)
    return _single(base + up * (edge[:, 0] - base)), _single(root + up * (edge[:, 1] - root))


def _paint_paddle(
    picture: Array, plan: PaddlePlan, fin: FinSkin, skin: SkinPlan, body: _Body
) -> None:
    """A paired fin: columns from its root to its end, rows across."""
    _, height, width = picture.shape
    along_it = _single((np.arange(width) + 0.5) / width)
    middle = _single(2.0 * (np.arange(height)[:, None] + 0.5) / height - 1.0)
    out = along_it + np.zeros_like(middle)
    # Its root is a lobe of flesh and has the colour of the flank.
    root = body.colours(np.array([[plan.at]]), np.array([[plan.height]]))
    picture[:3], picture[3] = root, 1.0
    if plan.wing:
        picture[:3] = np.array(fin.colour, np.float32)[:, None, None]
        if fin.rim:
            _lay(picture, fin.rim, _step((1.0 - out) / fin.rim_width, 1.0, 0.7))
    else:
        _lay(picture, fin.colour, _step(out + 0.08 * middle**2, 0.06, 0.2))
        rays, between = _rays(0.5 + 0.5 * middle, out, 0, PADDLE_RAYS)
        end = 0.965 - 0.04 * between - 0.2 * middle**4
        beside = 0.5 * plan.width * (1.0 - np.abs(middle)) * _step(out, 0.1, 0.4) + 0.004
        # Rounded where it leaves the flank.
        beside = np.minimum(beside, plan.length * (out - 0.06 * middle**2) + 0.001)
        to_edge = np.minimum((end - out) * plan.length, beside)
        _lay_membrane(picture, fin, skin.rays, out, rays, to_edge, (end - out) / fin.rim_width)
    _colour_unevenly(picture, skin.blotches)


def _draw_lateral_line(
    picture: Array, surface: SurfacePlan, s: Array, y: Array, level: Array
) -> None:
    """The row of pores from the gill cover to the tail, high over the pectoral fin."""
    begin, end = surface.eye.at + 0.15, surface.tail.begin
    here = slice(*np.searchsorted(s, (begin, end)))
    t = (s[here] - begin) / (end - begin)
    arch = 0.42 * (1.0 - t) ** 1.2 * (1.0 - _step(t, 0.85, 1.0)) + 0.02
    back = _single(along(surface.back, s[here]))
    off = np.abs(y - arch * back) / 0.0028
    near = np.flatnonzero((off < 1.0).any(axis=1))
    rows = slice(near[0], near[-1] + 1)
    pores = 0.5 + 0.5 * np.cos(2 * np.pi / PORES * s[here])
    picture[:3, rows, here] *= 1.0 - (0.1 + 0.1 * pores) * _step(off[rows], 1.0, 0.2)


def _draw_shadow_of_fin(picture: Array, surface: SurfacePlan, s: Array, y: Array) -> None:
    """Little light comes in behind a pectoral fin, and to where it is rooted."""
    fin = surface.pectoral
    if fin is None or fin.wing:
        return
    middle = (fin.at + 0.3 * fin.length, fin.height - 0.22 * fin.width)
    size = (0.55 * fin.length, 0.7 * fin.width)
    corners = [(middle[0] + a * size[0], middle[1] + b * size[1]) for a in (-1, 1) for b in (-1, 1)]
    rows, columns = _around(corners, 0.0, s, y)
    far = np.hypot((s[columns] - middle[0]) / size[0], (y[rows] - middle[1]) / size[1])
    picture[:3, rows, columns] *= 1.0 - 0.22 * _step(far, 1.0, 0.1)
    root = np.hypot((s[columns] - fin.at) / 0.012, (y[rows] - fin.height) / (0.3 * fin.width))
    picture[:3, rows, columns] *= 1.0 - 0.4 * _step(root, 1.0, 0.4)


def _draw_face(
    picture: Array, surface: SurfacePlan, skin: SkinPlan, s: Array, y: Array, level: Array
) -> None:
    """The gill cover or the gill slits, the mouth, a nostril and the eye."""
    eye = surface.eye
    large = head_size(surface)
    reach = 0.2 + 0.01 * skin.gills
    head = slice(0, int(np.searchsorted(s, max(eye.at + large * reach, skin.mouth[1][0]) + 0.01)))
    picture, s, level = picture[:, :, head], s[head], level[:, head]
    at = (s - eye.at) / large - 0.135 + 0.05 * level**2 + 0.02 * level
    if skin.gills == 0:
        pore = np.hypot(at / 0.022, level / 0.16)
        picture[:3] *= 1.0 - 0.7 * _step(pore, 1.0, 0.5)
    elif skin.gills == 1:
        _draw_gill_cover(picture, at, level)
    else:
        place = at / GILLS_APART + 0.5 * (skin.gills - 1)
        nearest = np.round(place).clip(0, skin.gills - 1)
        slit = _step(np.abs(place - nearest), 0.28, 0.0) * _step(np.abs(level), 0.5, 0.3)
        picture[:3] *= 1.0 - 0.5 * slit
    _draw_mouth(picture, skin, s, y, large)
    (tip, height), _ = skin.mouth
    toward = 0.52  # of the way from the eye to the mouth
    nose = (eye.at + toward * (tip - eye.at), eye.height + toward * (height - eye.height))
    nose = (nose[0], nose[1] + 0.35 * eye.radius)
    far = np.hypot(s - nose[0], (y - nose[1]) * 1.3) / (0.17 * eye.radius)
    picture[:3] *= (
        1.0 - 0.75 * _step(far, 1.2, 0.6) + 0.18 * _step(far, 2.2, 1.4) * _step(far, 1.0, 1.4)
    )
    _draw_eye(picture, skin, s - eye.at, y - eye.height, eye.radius)


def _draw_gill_cover(picture: Array, at: Array, level: Array) -> None:
    """`at` is the distance behind its edge, which stands off a little and casts a shadow."""
    tall = _step(np.abs(level + 0.08), 0.86, 0.6)
    behind = at > 0.0
    shade = np.where(behind, 0.34 * np.exp(-at.clip(0.0) / 0.014), 0.0)
    shade += 0.42 * np.exp(-((at / 0.0036) ** 2))
    light = np.where(behind, 0.0, 0.22 * np.exp(-(((at + 0.010) / 0.007) ** 2)))
    # The cheek's own edge in front of it, and the ridge between both.
    cheek = at + 0.052 + 0.03 * level
    light += 0.08 * np.exp(-(((cheek - 0.006) / 0.006) ** 2))
    shade += 0.16 * np.exp(-((cheek / 0.0042) ** 2)) * _step(np.abs(level + 0.25), 0.6, 0.35)
    picture[:3] *= 1.0 + _single(tall * (light - shade))
    # The flap that ends it is thin skin, a little darker.
    picture[:3] *= 1.0 - 0.1 * _single(tall * _step(np.abs(at + 0.004), 0.006, 0.002))


def _draw_mouth(picture: Array, skin: SkinPlan, s: Array, y: Array, large: float) -> None:
    """A dark line between two lips that end in a fold at its corner."""
    (tip, height), (corner, low) = skin.mouth
    rows, columns = _around([(tip, height), (corner, low)], 0.02 * large + 0.006, s, y)
    picture, s, y = picture[:, rows, columns], s[columns], y[rows]
    t = (s - tip) / (corner - tip)
    line = height + (low - height) * t + 0.0035 * large * np.sin(np.pi * t.clip(0.0, 1.0))
    off = (y - line) / large
    here = _step(s, corner + 0.004 * large, corner - 0.004 * large) * _step(s, tip - 0.006, tip)
    thick = 0.0105 * (1.0 - 0.55 * t.clip(0.0, 1.0))  # of a lip
    lip = _step(np.abs(off), thick, 0.7 * thick) * here
    fold = _step(np.abs(np.abs(off) - thick), 0.0026, 0.0) * here
    picture[:3] += 0.16 * lip * (picture[:3] + 0.12)
    picture[:3] *= 1.0 - 0.3 * fold
    picture[:3] *= 1.0 - 0.85 * _step(np.abs(off), 0.0042, 0.0015) * here
    end = np.hypot((s - corner) / 0.006, (y - low) / 0.008) / large
    picture[:3] *= 1.0 - 0.4 * _step(end, 1.0, 0.2)


def _draw_eye(picture: Array, skin: SkinPlan, ahead: Array, up: Array, radius: float) -> None:
    """An eye about the place where `ahead` and `up` are 0: socket, iris with its fibres, pupil."""
    rows = np.flatnonzero(np.abs(up).min(axis=1) < 1.8 * radius)
    columns = np.flatnonzero(np.abs(ahead) < 1.8 * radius)
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    picture = picture[:, box[0], box[1]]
    x, h = ahead[box[1]] / radius, up[box[0]] / radius
    far, angle = np.hypot(x, h), np.arctan2(h, x)
    picture[:3] *= 1.0 - 0.35 * _step(far, 1.75, 1.0)
    _lay(picture, DARK, 0.9 * _step(far, 1.13, 1.02))
    fibres = 0.06 * np.sin(23.0 * angle + 2.0 * np.sin(5.0 * angle)) + 0.05 * np.sin(41.0 * angle)
    iris = np.array(skin.iris, np.float32)[:, None, None] * _single(
        # Shaded by the brow, darker outside, bright where it meets the pupil.
        (0.86 - 0.28 * h) * (1.0 + fibres) * (1.12 - 0.5 * _step(far, 0.72, 1.0))
        + 0.5 * _step(np.abs(far - skin.pupil - 0.07), 0.07, 0.0)
    )
    ring = _single(_step(far, 1.0, 0.9))
    picture[:3] += (iris - picture[:3]) * ring
    _lay(picture, DARK, _step(far, skin.pupil + 0.05, skin.pupil - 0.05))
    # What is seen of the bright surface in the pupil.
    picture[2] += 0.03 * _single(_step(far, 0.5, 0.3) * _step(h, -0.1, 0.5))


def _around(outline: Curve, reach: float, s: Array, y: Array) -> tuple[slice, slice]:
    """Rows and columns of the texels within `reach` of the box around an outline."""
    low, high = np.min(outline, axis=0) - reach, np.max(outline, axis=0) + reach
    rows, columns = (
        np.searchsorted(y[:, 0], (low[1], high[1])),
        np.searchsorted(s, (low[0], high[0])),
    )
    return slice(*rows), slice(*columns)


def _near(outline: Curve, s: Array, y: Array) -> bool:
    """Whether the box around an outline has a share in that around some places."""
    low, high = np.min(outline, axis=0) - 0.02, np.max(outline, axis=0) + 0.02
    return bool(s.max() > low[0] and s.min() < high[0] and y.max() > low[1] and y.min() < high[1])


def _depth_inside(outline: Curve, s: Array, y: Array) -> Array:
    """Distance (h, w) from a smooth closed outline, positive inside, in body lengths.

    They are measured at every fourth texel each way and interpolated.
    """
    coarse = _depth_at(outline, _every_fourth(s), _every_fourth(y[:, 0])[:, None])
    return _between(_between(coarse.T, len(s)).T, len(y))


def _depth_at(outline: Curve, x: Array, h: Array) -> Array:
    """The same at any places."""
    corners = _rounded(np.asarray(outline, np.float32))
    shape = np.broadcast_shapes(x.shape, h.shape)
    inside = np.zeros(shape, bool)
    nearest = np.full(shape, np.inf, np.float32)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        dx, dy = bx - ax, by - ay
        t = (((x - ax) * dx + (h - ay) * dy) / max(dx * dx + dy * dy, 1e-12)).clip(0.0, 1.0)
        nearest = np.minimum(nearest, (x - ax - t * dx) ** 2 + (h - ay - t * dy) ** 2)
        if ay != by:
            inside ^= ((ay > h) != (by > h)) & (x < ax + dx * (h - ay) / dy)
    return np.where(inside, np.float32(1.0), np.float32(-1.0)) * np.sqrt(nearest)


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
def _cloud() -> Array:
    """Unevenness of a skin (256, 512), deviation 1, whose edges meet; the same for all species."""
    return _tile(lambda k: np.exp(-((k / 0.011) ** 2)))


@cache
def _grain() -> Array:
    """Another one, finer."""
    return _tile(lambda k: np.exp(-((k / 0.012) ** 2)) + 0.15 * np.exp(-((k / 0.1) ** 2)))


def _tile(share: Callable[[Array], Array]) -> Array:
    """Noise (256, 512) with a spectrum."""
    noise = np.random.default_rng(0x5C1).normal(size=(256, 512))
    k = np.hypot(np.fft.fftfreq(256)[:, None], np.fft.rfftfreq(512))
    smooth = np.fft.irfft2(np.fft.rfft2(noise) * share(k), s=(256, 512))
    return _single(smooth / smooth.std())


def _over(tile: Array, shape: tuple[int, ...]) -> Array:
    """A tile repeated over (h, w)."""
    times = -(-shape[0] // tile.shape[0]), -(-shape[1] // tile.shape[1])
    return np.tile(tile, times)[: shape[0], : shape[1]]


def _step(x: Array, low: float | Array, high: float | Array) -> Array:
    """0 at `low`, 1 at `high`, smooth between; `high` may be the smaller one."""
    return _smooth((x - low) / (high - low))


def _smooth(t: Array) -> Array:
    """0 below 0, 1 above 1, smooth between."""
    t = np.clip(t, 0.0, 1.0)
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


def encoded(picture: Array) -> NDArray[np.uint8]:
    """Planes (4, h, w) to texels (h, w, 4).

    Colours become sRGB by a table of 4,096 steps, which eight bits do not show.
    """
    linear = np.linspace(0.0, 1.0, 4097)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    table = np.round(255.0 * encoded).astype(np.uint8)
    texels = np.empty((*picture.shape[1:], 4), np.uint8)
    for k in range(3):
        steps = (np.float32(4096.0) * picture[k] + np.float32(0.5)).astype(np.int16)
        texels[..., k] = table.take(steps, mode="clip")
    texels[..., 3] = np.round(255.0 * picture[3].clip(0.0, 1.0))
    return texels
