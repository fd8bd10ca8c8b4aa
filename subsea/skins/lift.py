"""From a photograph under deformable meshes to the sheet that a species wears (Tu §5.2).

The meshes say which place of the photograph each place of the flank and of the fins is: colours are
taken from there. What lies behind the fish is removed first, and the fish's own colours go on
beyond its outline, so that neither its edge nor a coarse mipmap shows the water that it swam in.
What a photograph from the side does not show, the paired fins, is painted in the colours that it
has. The sheet is one flank; the other one is drawn as its mirror image.

Needs the extra `skin` (OpenCV).
"""

from typing import Any

import cv2
import numpy as np
from msgspec import structs
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.spline import basis_at, dense, greville, through
from subsea.kinematics.surface import FIN_V, SUNK, along, travelled
from subsea.skins import paint
from subsea.skins.deformable import BODY, DORSAL, VENTRAL, Net
from subsea.skins.flank import RestFin, at_rest, finer, outlines
from subsea.species import Colour, FinSkin, SkinPlan, Species

Array = NDArray[np.floating[Any]]
Bytes = NDArray[np.uint8]
Mask = NDArray[np.bool_]

RIM = 0.006  # body lengths inside the outline where the background still shines through
NEAR = 0.035  # so near to it the fish told apart is asked, farther inside the meshes alone
FINE_MESH = 8  # times as many places as nodes, of the meshes that colours are taken through


def lifted(colour: Bytes, net: Net, species: Species, fish: Mask | None = None) -> Bytes:
    """The sheet (640, 1024, 4) of a species, bottom row first, from a photograph (h, w, 3).

    ``fish`` (h, w) is what was told apart from the background: near the outline only colours from
    there are taken, and fins have gaps where it has. Without it the meshes alone decide.
    """
    surface, skin = species.surface, species.skin
    rest = at_rest(surface)
    width, height = paint.SIZE
    length = float(np.hypot(*(net.body.nodes[4, 0] - net.body.nodes[4, 14]))) / surface.tail.begin
    window, shift = _around(colour, net, length)
    light = _linear(colour[window])
    within = covered(net, colour.shape[:2])[window]
    there = within if fish is None else fish[window]
    light = bled(light, _sure(within, there, length).astype(np.float32))
    opaque = cv2.GaussianBlur(np.asarray(there | _deep(within, length), np.float32), (0, 0), 1.0)
    picture = np.dstack([light, opaque])

    sheet = np.zeros((height, width, 4), np.float32)
    body = paint.framed(sheet.transpose(2, 0, 1), paint.BODY).transpose(1, 2, 0)
    front, rear = paint.borders(surface)
    top = paint.half_height(surface)
    rows, columns = body.shape[:2]
    size = np.array([columns / (rear - front), rows / (2.0 * top)])
    texels = (finer(rest.body, FINE_MESH) - (front, -top)) * size - 0.5
    places = drawn(texels, finer(net.body.nodes, FINE_MESH) - shift, (rows, columns))
    inside = np.isfinite(places[..., 0])
    body[:] = _looked_up(picture, places)
    body[..., :3] = bled(body[..., :3], inside.astype(np.float32))
    tail = surface.tail.begin
    s = front + (np.arange(columns) + 0.5) / size[0]
    out = np.clip((s - tail) / (1.0 - tail), 0.0, 1.0)
    thin = _smooth((s - tail) / 0.04)  # how far the body has become a fin
    web = np.where(inside, body[..., 3], 1.0) * (1.0 - (1.0 - skin.tail.opacity) * _smooth(out))
    body[..., 3] = 1.0 + thin * (web - 1.0)

    colours = {}
    for name, frame, plan, look, ridge in (
        (DORSAL, paint.DORSAL, surface.dorsal, skin.dorsal, surface.back),
        (VENTRAL, paint.VENTRAL, surface.ventral, skin.ventral, surface.belly),
    ):
        if not plan or not look or name not in rest.fins:
            continue
        part = paint.framed(sheet.transpose(2, 0, 1), frame).transpose(1, 2, 0)
        share = (np.arange(part.shape[1]) + 0.5) / part.shape[1]
        up = ((np.arange(part.shape[0]) + 0.5) / part.shape[0])[:, None]
        rise = _risen(rest.fins[name], share, up)
        sunk = plan.base[0] + (plan.base[1] - plan.base[0]) * share
        edge = travelled(plan.edge, share)
        root = SUNK * along(ridge, sunk)
        where = np.stack(
            np.broadcast_arrays(sunk + up * (edge[:, 0] - sunk), root + up * (edge[:, 1] - root)),
            axis=2,
        )
        weights = dense(basis_at(FIN_V, share), FIN_V)
        low, high = (weights @ through(row) - shift for row in net.fins[name].mesh.nodes)
        above = low + np.maximum(rise, 0.0)[..., None] * (high - low)
        beneath = (where - (front, -top)) * size - 0.5
        part[:] = np.where(
            (rise > 0.0)[..., None],
            _looked_up(picture, above),
            _looked_up(np.ascontiguousarray(body), beneath),
        )
        seen = (part[..., 3] > 0.5) | (rise <= 0.0)
        colours[name] = _typical(part[..., :3], seen & (rise > 0.2))
        part[..., :3] = bled(part[..., :3], seen.astype(np.float32))
        web = part[..., 3] * (1.0 - (1.0 - look.opacity) * _smooth(rise))
        part[..., 3] = np.where(rise > 0.0, web, 1.0)
    colours[BODY] = _typical(body[..., :3], inside & (s > tail + 0.05)[None])
    plain = structs.replace(species, skin=_plain(skin, body[..., :3], inside, s < tail, colours))
    painted = paint.paint(plain)
    out_sheet = paint.encoded(sheet.transpose(2, 0, 1))
    for frame in (paint.PECTORAL, paint.PELVIC):
        into = paint.framed(out_sheet.transpose(2, 0, 1), frame)
        into[:] = paint.framed(painted.transpose(2, 0, 1), frame)
    return out_sheet


def covered(net: Net, shape: tuple[int, ...]) -> Mask:
    """Which pixels (h, w) lie under the meshes."""
    mask = np.zeros(shape[:2], np.uint8)
    for ring in outlines(net):
        cv2.fillPoly(mask, [np.round(ring * 16.0).astype(np.int32)], 1, shift=4)
    return mask.astype(bool)


def bled(values: Array, share: Array) -> Array:
    """Values (h, w, k) where `share` (h, w) is 1; elsewhere those around go on, ever more blurred.

    By a pyramid of means, as mipmaps are made (push and pull).
    """
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


def drawn(corners: Array, values: Array, shape: tuple[int, int]) -> Array:
    """Values (h, w, k) on texels under a mesh with `corners` (m, n, 2) and `values` (m, n, k).

    Linear on its triangles; nan outside.
    """
    out = np.full((*shape, values.shape[2]), np.nan, np.float32)
    _draw(np.ascontiguousarray(corners), np.ascontiguousarray(values, np.float64), out)
    return out


@njit(cache=True)
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


def _around(colour: Bytes, net: Net, length: float) -> tuple[tuple[slice, slice], Array]:
    """The part of a photograph that the meshes lie in, and its corner."""
    every = np.concatenate(outlines(net))
    margin = 0.1 * length
    low = np.maximum(np.floor(every.min(axis=0) - margin), 0).astype(int)
    high = np.ceil(every.max(axis=0) + margin).astype(int)
    low = np.minimum(low, (colour.shape[1] - 2, colour.shape[0] - 2))
    high = np.maximum(high, low + 2)
    return (slice(low[1], high[1]), slice(low[0], high[0])), low.astype(float)


def _sure(within: Mask, there: Mask, length: float) -> Mask:
    """Where the colours are the fish's own: inside the meshes, away from any outline."""
    inner = _far_inside(within & (there | _deep(within, length)))
    sure = inner > RIM * length
    return np.asarray(sure if sure.any() else within)


def _deep(within: Mask, length: float) -> Mask:
    """Farther inside the meshes than the fish told apart is asked."""
    return np.asarray(_far_inside(within) > NEAR * length)


def _far_inside(mask: Mask) -> Array:
    """Distance (h, w) to the nearest pixel outside a mask; what lies beyond the picture is none."""
    return np.asarray(cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5))


def _looked_up(picture: Array, places: Array) -> Array:
    """Values (h, w, k) of a picture at places (h, w, 2), pixels; 0 where these are nan."""
    x, y = np.nan_to_num(places.astype(np.float32), nan=-9.0).transpose(2, 0, 1)
    found = cv2.remap(
        np.asarray(picture, np.float32),
        np.ascontiguousarray(x),
        np.ascontiguousarray(y),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return np.asarray(found)


def _risen(rest: RestFin, share: Array, up: Array) -> Array:
    """How far texels (h, w) of a fin's frame are from where it leaves the body, 0, to its edge, 1.

    Negative within the body, and all along where the fin does not show.
    """
    at = greville(FIN_V)
    left = np.interp(share, at, rest.leaves)
    return np.asarray((up - left) / np.maximum(1.0 - left, 1e-3)).clip(-1.0, 1.0)


def _typical(light: Array, where: Mask) -> Colour | None:
    """The median colour (linear light) of those places."""
    if not where.any():
        return None
    return tuple(float(c) for c in np.median(light[where], axis=0).clip(0.0, 1.0))  # type: ignore[return-value]


def _plain(
    skin: SkinPlan, light: Array, inside: Mask, trunk: Mask, colours: dict[str, Colour | None]
) -> SkinPlan:
    """A skin in the colours of the photograph, without patterns: for what that does not show."""
    trunk = inside & trunk
    row = np.arange(len(light))[:, None] * np.ones_like(trunk)
    count = np.maximum(trunk.sum(axis=0), 1)
    first = np.where(trunk.any(axis=0), trunk.argmax(axis=0), 0)
    level = (row - first) / count  # 0 at the belly, 1 at the back
    tones = {
        name: _typical(light, trunk & (level >= low) & (level < high)) or getattr(skin, name)
        for name, low, high in (("belly", 0, 0.25), ("flank", 0.25, 0.75), ("back", 0.75, 1.1))
    }
    fins = next((c for c in (colours.get(DORSAL), colours.get(VENTRAL), colours[BODY]) if c), None)

    def worn(look: FinSkin | None) -> FinSkin | None:
        return look and structs.replace(look, colour=fins or look.colour, rim=None)

    return structs.replace(
        skin, **tones, stripes=None, cape=None, patches=[], spots=None,
        tail=worn(skin.tail), dorsal=worn(skin.dorsal), ventral=worn(skin.ventral),
        paddles=worn(skin.paddles),
    )  # fmt: skip


def _linear(colour: Bytes) -> Array:
    """Linear light (h, w, 3), 0 to 1, of sRGB."""
    value = np.arange(256) / 255.0
    table = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return table.astype(np.float32)[colour]


def _smooth(t: Array) -> Array:
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))
