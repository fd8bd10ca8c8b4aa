"""Make a skin sheet from a photograph under deformable meshes (Tu §5.2).

The meshes map flank and fins to the photograph. The background is replaced by the fish's own
colours first, so that neither edges nor coarse mipmaps show it. Paired fins, which a side view
does not show, are painted in the photograph's colours. Both flanks use the same texels.
Needs the extra `skin` (OpenCV).
"""

from typing import Any, NamedTuple

import cv2
import numpy as np
from msgspec import structs

from subsea.base.arrays import Array, Bools, Bytes
from subsea.fish import paint, raster, sheet_layout
from subsea.fish.species import Colour, SkinPlan, Species
from subsea.fish.surface import FIN_V, SurfacePlan
from subsea.geometry.curves import basis_at, dense, greville, through
from subsea.kernels import kernel
from subsea.studio.deformable_mesh import DORSAL, VENTRAL, DeformableMesh, FishMeshes
from subsea.studio.side_view import SideView, SideViewFin, mesh_outlines, side_view, subdivide

RIM = 0.006  # body lengths inside the outline that the background still tints
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
TIERS = 10  # levels from belly to back whose brightness is compared
EVENED = 0.8  # fraction of the shading that is removed
STEEPEST = 2.0  # limit of its log ratio
WEB = 0.04  # body lengths behind its root over which the tail becomes a fin
FINE_MESH = 8  # subdivisions of the meshes that colours are sampled through


class _Source(NamedTuple):
    """The part of the photograph around the fish, without background."""

    picture: Array  # (h, w, 4) linear light, and opacity: 1 on the fish
    corner: Array  # (2,) its upper left corner in the photograph


class _Flank(NamedTuple):
    """The body region of a sheet."""

    picture: Array  # (h, w, 4) linear light and opacity
    level: Array  # (h, w) from belly to back, 0 to 1
    trunk: Bools  # (h, w) the body without its tail
    low: Array  # (2,) lower left corner, body lengths
    size: Array  # (2,) texels per body length
    steep: float  # log ratio of the shading by light from above


def lift_sheet(
    colour: Bytes, meshes: FishMeshes, species: Species, fish: Bools | None = None
) -> Bytes:
    """Make the sheet (640, 1024, 4), bottom row first, from a photograph (h, w, 3).

    ``fish`` (h, w) is the segmented fish: only its colours are used, and its gaps are gaps in the
    fins. Without it the meshes alone count.
    """
    surface, skin = species.surface, species.skin
    rest = side_view(surface)
    source = _source(colour, meshes, surface, fish)
    planes = np.zeros((4, *sheet_layout.SIZE[::-1]), np.float32)
    flank, tail = _lift_flank(source, meshes, rest, surface, skin)
    sheet_layout.crop(planes, sheet_layout.BODY)[:] = flank.picture.transpose(2, 0, 1)
    typical = [tail]
    for name, frame, plan, look, ridge in (
        (VENTRAL, sheet_layout.VENTRAL, surface.ventral, skin.ventral, surface.belly),
        (DORSAL, sheet_layout.DORSAL, surface.dorsal, skin.dorsal, surface.back),
    ):
        if plan and look:
            part = sheet_layout.crop(planes, frame)
            made, tone = _lift_fin(
                source, flank, meshes.fins[name].mesh, rest.fins[name],
                np.dstack(sheet_layout.fin_points(plan, ridge, *_fractions(part.shape[1:]))),
                look.opacity, float(name == DORSAL),
            )  # fmt: skip
            part[:] = made.transpose(2, 0, 1)
            typical.append(tone)
    sheet = raster.srgb_texels(planes)
    fins = next((tone for tone in typical[::-1] if tone), None)
    plain = structs.replace(species, skin=_plain_skin(skin, flank, fins))
    painted = paint.paint(plain).transpose(2, 0, 1)
    for frame in (sheet_layout.PECTORAL, sheet_layout.PELVIC):
        sheet_layout.crop(sheet.transpose(2, 0, 1), frame)[:] = sheet_layout.crop(painted, frame)
    return sheet


def _source(colour: Bytes, meshes: FishMeshes, surface: SurfacePlan, fish: Bools | None) -> _Source:
    """The part of a photograph around the meshes, filled with the fish's own colours."""
    front, tail = meshes.body.nodes[4, 0], meshes.body.nodes[4, 14]
    length = float(np.hypot(*(front - tail))) / surface.tail.begin
    window, corner = _around(colour, meshes, length)
    within = mesh_mask(meshes, colour.shape)[window]
    there = within if fish is None else fish[window]
    inside = cv2.distanceTransform((within & there).astype(np.uint8), cv2.DIST_L2, 5)
    sure = inside > max(RIM * length, 1.0)
    # A small fish has only a rim; meshes may lie beside the fish. Background never counts.
    seen = next((part for part in (sure, within & there) if part.any()), there)
    table = raster.from_srgb(np.arange(256) / 255.0).astype(np.float32)
    light = pull_push(table[colour[window]], seen.astype(np.float32))
    opaque = cv2.GaussianBlur(np.asarray(there, np.float32), (0, 0), 1.0)
    return _Source(np.dstack([light, opaque]), corner)


def _lift_flank(
    source: _Source, meshes: FishMeshes, rest: SideView, surface: SurfacePlan, skin: SkinPlan
) -> tuple[_Flank, Colour | None]:
    """Return body and tail, and the median colour of the tail."""
    height, width = sheet_layout.crop(
        np.empty((4, *sheet_layout.SIZE[::-1])), sheet_layout.BODY
    ).shape[1:]
    front, rear = sheet_layout.borders(surface)
    top, tail = sheet_layout.half_height(surface), surface.tail.begin
    low = np.array([front, -top])
    size = np.array([width / (rear - front), height / (2.0 * top)])
    texels = (subdivide(rest.body, FINE_MESH) - low) * size - 0.5
    places = rasterize(
        texels, subdivide(meshes.body.nodes, FINE_MESH) - source.corner, (height, width)
    )
    inside = np.isfinite(places[..., 0])
    picture = _sample(source.picture, places)
    picture[..., :3] = pull_push(picture[..., :3], inside.astype(np.float32))
    s = front + (np.arange(width) + 0.5) / size[0]
    trunk = inside & (s < tail)
    level = _level(trunk)
    steep = _shading(picture[..., :3], level)
    picture[..., :3] *= _shading_gain(steep, level)[..., None]
    web = raster.smooth_unit((s - tail) / WEB)  # 0 on the body, 1 on the fin
    clear = (1.0 - skin.tail.opacity) * raster.smooth_unit((s - tail) / (1.0 - tail))
    picture[..., 3] = 1.0 + web * (np.where(inside, picture[..., 3], 1.0) * (1.0 - clear) - 1.0)
    tone = _median_colour(picture[..., :3], inside & (s > tail + WEB))
    return _Flank(picture, level, trunk, low, size, steep), tone


def _lift_fin(
    source: _Source,
    flank: _Flank,
    fin: DeformableMesh,
    rest: SideViewFin,
    places: Array,
    opacity: float,
    level: float,
) -> tuple[Array, Colour | None]:
    """A fin (h, w, 4) with texels at `places` (h, w, 2) on the fish, and its median colour.

    Within the body it has the body's colours.
    """
    share, up = _fractions(places.shape[:2])
    # 0 at the body, 1 at the edge; negative within the body and where the fin does not show.
    left = np.interp(share, greville(FIN_V), rest.leaves)
    rise = np.asarray((up - left) / np.maximum(1.0 - left, 1e-3)).clip(-1.0, 1.0)
    weights = dense(basis_at(FIN_V, share), FIN_V)
    root, edge = (weights @ through(row) - source.corner for row in fin.nodes)
    beyond = _sample(source.picture, root + np.maximum(rise, 0.0)[..., None] * (edge - root))
    beyond[..., :3] *= _shading_gain(flank.steep, np.float32(level))
    within = _sample(flank.picture, (places - flank.low) * flank.size - 0.5)
    out = rise > 0.0
    picture = np.where(out[..., None], beyond, within)
    seen = ~out | (picture[..., 3] > 0.5)
    picture[..., :3] = pull_push(picture[..., :3], seen.astype(np.float32))
    clear = (1.0 - opacity) * raster.smooth_unit(rise)
    picture[..., 3] = np.where(out, picture[..., 3] * (1.0 - clear), 1.0)
    return picture, _median_colour(picture[..., :3], seen & (rise > 0.2))


def _fractions(shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Fractions of a fin's region (h, w): along its base (w,), and from root to edge (h, 1)."""
    height, width = shape
    return (np.arange(width) + 0.5) / width, ((np.arange(height) + 0.5) / height)[:, None]


def mesh_mask(meshes: FishMeshes, shape: tuple[int, ...]) -> Bools:
    """Return the pixels (h, w) under the meshes."""
    mask = np.zeros(shape[:2], np.uint8)
    for ring in mesh_outlines(meshes):
        cv2.fillPoly(mask, [np.round(ring * 16.0).astype(np.int32)], 1, shift=4)
    return mask.astype(bool)


def pull_push(values: Array, share: Array) -> Array:
    """Fill values (h, w, k) where `share` (h, w) is 0 from those around (pull-push pyramid)."""
    values = np.asarray(values, np.float32)
    levels = [(values * share[..., None], np.asarray(share, np.float32))]
    while min(levels[-1][1].shape) > 1 and not levels[-1][1].min() > 0.0:
        last, weight = levels[-1]
        size = (weight.shape[1] + 1) // 2, (weight.shape[0] + 1) // 2
        levels.append(
            tuple(cv2.resize(a, size, interpolation=cv2.INTER_AREA) for a in (last, weight))
        )
    last, weight = levels[-1]
    filled = np.asarray(last / np.maximum(weight, 1e-6)[..., None])
    for sums, weight in levels[-2::-1]:
        wide = cv2.resize(filled, weight.shape[::-1], interpolation=cv2.INTER_LINEAR)
        filled = sums + (1.0 - weight)[..., None] * wide
    return np.asarray(filled)


def rasterize(corners: Array, values: Array, shape: tuple[int, int]) -> Array:
    """Values (h, w, k) under a mesh with `corners` (m, n, 2) and `values` (m, n, k).

    Linear on its triangles; NaN outside.
    """
    out = np.full((*shape, values.shape[2]), np.nan, np.float32)
    _draw(np.ascontiguousarray(corners), np.ascontiguousarray(values, np.float64), out)
    return out


@kernel
def _draw(corners: Any, values: Any, out: Any) -> None:
    h, w, count = out.shape
    m, n, _ = corners.shape
    for cell in range(2 * (m - 1) * (n - 1)):
        k, j = (cell // 2) // (n - 1), (cell // 2) % (n - 1)
        a, b, c = (k, j), (k + 1, j + 1), (k + 1, j) if cell % 2 else (k, j + 1)
        ax, ay = corners[a][0], corners[a][1]
        bx, by = corners[b][0] - ax, corners[b][1] - ay
        cx, cy = corners[c][0] - ax, corners[c][1] - ay
        area = bx * cy - by * cx
        if abs(area) < 1e-12:
            continue
        left, right = min(0.0, bx, cx) + ax, max(0.0, bx, cx) + ax
        low, high = min(0.0, by, cy) + ay, max(0.0, by, cy) + ay
        for row in range(max(0, int(np.ceil(low - 1e-6))), min(h, int(np.floor(high + 1e-6)) + 1)):
            for column in range(
                max(0, int(np.ceil(left - 1e-6))), min(w, int(np.floor(right + 1e-6)) + 1)
            ):
                x, y = column - ax, row - ay
                s, t = (x * cy - y * cx) / area, (bx * y - by * x) / area
                if s >= -1e-6 and t >= -1e-6 and s + t <= 1.0 + 1e-6:
                    for i in range(count):
                        out[row, column, i] = (
                            (1.0 - s - t) * values[a][i] + s * values[b][i] + t * values[c][i]
                        )


def _around(colour: Bytes, meshes: FishMeshes, length: float) -> tuple[tuple[slice, slice], Array]:
    """The window of a photograph around the meshes, and its upper left corner."""
    every = np.concatenate(mesh_outlines(meshes))
    margin = 0.1 * length
    low = np.maximum(np.floor(every.min(axis=0) - margin), 0).astype(int)
    high = np.ceil(every.max(axis=0) + margin).astype(int)
    low = np.minimum(low, (colour.shape[1] - 2, colour.shape[0] - 2))
    high = np.maximum(high, low + 2)
    return (slice(low[1], high[1]), slice(low[0], high[0])), low.astype(float)


def _sample(picture: Array, places: Array) -> Array:
    """Values (h, w, k) of a picture at places (h, w, 2), pixels; 0 where these are NaN."""
    x, y = np.nan_to_num(places.astype(np.float32), nan=-9.0).transpose(2, 0, 1)
    x, y = np.ascontiguousarray(x), np.ascontiguousarray(y)
    values = np.asarray(picture, np.float32)
    found = cv2.remap(values, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(found)


def _median_colour(light: Array, where: Bools) -> Colour | None:
    """The median colour of masked texels; None without any."""
    if not where.any():
        return None
    return tuple(float(c) for c in np.median(light[where], axis=0).clip(0.0, 1.0))  # type: ignore[return-value]


def _level(trunk: Bools) -> Array:
    """Height of texels (h, w), belly 0 to back 1; on the tail as at its root."""
    rows = np.arange(len(trunk))[:, None]
    count = trunk.sum(axis=0)
    known = np.flatnonzero(count)
    every = np.arange(trunk.shape[1])
    first = np.interp(every, known, trunk.argmax(axis=0)[known])
    count = np.interp(every, known, count[known])
    return np.asarray(((rows - first) / count).clip(0.0, 1.0), np.float32)


def _shading(light: Array, level: Array) -> float:
    """Log ratio of back to belly brightness; 0 if the belly is brighter.

    Fishes are countershaded. A darker belly in a photograph is shading by light from above, which
    would be applied twice.
    """
    tall = np.log(np.maximum(light @ LUMINANCE, 1e-3))
    inner = (level > 0.05) & (level < 0.95)
    within = np.minimum((level[inner] * TIERS).astype(int), TIERS - 1)
    tiers = [np.median(tall[inner][within == k]) for k in range(TIERS)]
    slope = np.polyfit((np.arange(TIERS) + 0.5) / TIERS, tiers, 1)[0]
    return float(np.clip(slope, 0.0, STEEPEST))


def _shading_gain(steep: float, level: Array | np.float32) -> Array:
    """The factor for colours at a level that removes the shading."""
    return np.exp(np.float32(-EVENED * steep) * (level - np.float32(0.5)))


def _plain_skin(skin: SkinPlan, flank: _Flank, fins: Colour | None) -> SkinPlan:
    """A plain skin in the photograph's colours, for parts that it does not show."""
    light, level = flank.picture[..., :3], flank.level
    tones = {
        name: _median_colour(light, flank.trunk & (level >= low) & (level <= high))
        or getattr(skin, name)
        for name, low, high in (("belly", 0, 0.25), ("flank", 0.25, 0.75), ("back", 0.75, 1))
    }
    paddles = skin.paddles and structs.replace(
        skin.paddles, colour=fins or skin.paddles.colour, rim=None
    )
    return structs.replace(
        skin, **tones, stripes=None, cape=None, patches=[], spots=None, paddles=paddles
    )
