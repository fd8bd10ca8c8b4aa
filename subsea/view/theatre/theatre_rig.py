"""The rig of a theatre: one view, or two, for each channel, and how they come to its windows."""

from collections.abc import Sequence

import numpy as np

from subsea.core.arrays import Array
from subsea.core.errors import UserError
from subsea.view.camera import NEAR_CM, off_axis
from subsea.view.display_rigs import SURROUNDS, cube
from subsea.view.rig import CUBES, CameraRig, DisplayPatch, Eye, Projection, Rect, Warp
from subsea.view.stereo import EYES, LAYOUTS, Stereo, halves, patches_of
from subsea.view.surround import COLUMNS, MARGIN_PX, ROWS, face_size, visible_parts
from subsea.view.theatre.channels import ProjectorChannel, grid_of, mesh_of
from subsea.view.theatre.screens import Flat, Frustum, frustum_of, points_on, seen_at
from subsea.view.theatre.theatre_file import Theatre

FINEST = 1.5  # most pixels a side that a curved screen's view may have for one of the projector's
WIDEST = 8192  # pixels of a row of pictures on the canvas, unless one alone is wider
MODES = ("mono", *LAYOUTS)


def theatre_rig(
    theatre: Theatre,
    channels: Sequence[ProjectorChannel],
    windows: Sequence[int],
    display: str = "mono",
    stereo: Stereo = EYES,
) -> CameraRig:
    """The rig of those of the `channels` that the windows of these numbers show.

    Its outputs are the windows, in their order. `display` says how two eyes share each channel's
    pixels; what `stereo` says of them replaces the theatre's own.
    """
    if display not in MODES:
        raise UserError(f"--display {display}: the displays of a theatre are {', '.join(MODES)}")
    numbers, shown = [], []
    for number, one in enumerate(channels):
        if one.window in windows:
            numbers.append(number)
            shown.append(one)
    if not shown:
        raise UserError("no channel of this theatre is left to show")
    offsets = _offsets(theatre, channels, display, stereo)
    half = float(offsets[-1][0])
    sizes = [size for one in shown for size in _pictures(one, display)]
    corners, canvas = shelves(sizes)
    drawn = iter([(*corner, *size) for corner, size in zip(corners, sizes, strict=True)])
    eyes: list[Eye] = []
    patches: list[DisplayPatch] = []
    for number, one in zip(numbers, shown, strict=True):
        rects = [next(drawn) for _ in offsets]
        if one.shape in CUBES:
            for rect, offset in zip(rects, offsets, strict=True):
                eyes += _round(one, rect, offset)
        else:
            frusta = [_frustum(one, offset) for offset in offsets]
            for rect, offset, frustum in zip(rects, offsets, frusta, strict=True):
                projection = _with_margin(frustum, rect)
                eyes.append(Eye(rect, offset, frustum.axes, projection))
            rects = [_inner(rect) for rect in rects]
        patch = DisplayPatch(
            one.place, rects[0], rects[-1], shape=one.shape, wide=one.surround.wide, mask=one.mask,
            output=windows.index(one.window), channel=number,
        )  # fmt: skip
        if one.shape in CUBES:
            patch = patch._replace(apart=half / one.distance_cm, warp=one.warp)
        elif not isinstance(one.screen, Flat) or one.warp is not None:
            patch = patch._replace(shape=Projection.WARPED, warp=_warp(one, offsets, frusta))
        patches += (patch,) if display == "mono" else patches_of(LAYOUTS[display], patch)
    outputs = tuple(theatre.window[number].size for number in windows)
    return CameraRig(canvas, outputs, tuple(eyes), tuple(patches), theatre.level)


def seen_channels(
    theatre: Theatre,
    channels: Sequence[ProjectorChannel],
    display: str = "mono",
    stereo: Stereo = EYES,
) -> tuple[tuple[ProjectorChannel, ...], tuple[UserError, ...]]:
    """The channels whose screens lie before all eyes, and an error for each of the others."""
    kept: list[ProjectorChannel] = []
    faults: list[UserError] = []
    offsets = _offsets(theatre, channels, display, stereo)
    for one in channels:
        try:
            for offset in offsets:
                if one.shape not in CUBES:
                    _frustum(one, offset)
                elif np.linalg.norm(offset) >= one.distance_cm:
                    message = f"channel {one.name!r}: the eye is outside of its screen"
                    raise UserError(message, key=one.key)
        except UserError as fault:
            faults.append(fault)
        else:
            kept.append(one)
    if faults and kept:  # the eyes may be farther apart for those that are left
        found, more = seen_channels(theatre, kept, display, stereo)
        return found, (*faults, *more)
    return tuple(kept), tuple(faults)


def shelves(sizes: Sequence[tuple[int, int]]) -> tuple[list[tuple[int, int]], tuple[int, int]]:
    """Corners for pictures of these sizes on a canvas, in rows from below, and its size."""
    widest = max(WIDEST, *(width for width, _ in sizes))
    corners: list[tuple[int, int]] = []
    x = y = row = right = 0
    for width, height in sizes:
        if x + width > widest:
            x, y, row = 0, y + row, 0
        corners.append((x, y))
        x, row = x + width, max(row, height)
        right = max(right, x)
    return corners, (right, y + row)


def _offsets(
    theatre: Theatre, channels: Sequence[ProjectorChannel], display: str, stereo: Stereo
) -> list[Array]:
    """Where the only eye is, or the left one and the right one: (3,) cm of the sea each.

    The same in all windows, and so on all computers: all channels of the theatre count.
    """
    if display == "mono":
        return [np.zeros(3)]
    real = stereo.separation_cm
    apart = theatre.scale * (theatre.eye_distance_cm if real is None else real)
    nearest = min(one.distance_cm for one in channels)
    # The screens are where they are: nothing lies farther apart on them than the eyes do.
    eyes = stereo._replace(separation_cm=apart, screen_cm=nearest, screen_width_cm=None)
    half = eyes.eyes(1.0) / 2.0 * (-1 if stereo.swapped else 1)
    return [np.array([x, 0.0, 0.0]) for x in (-half, half)]


def _pictures(one: ProjectorChannel, display: str) -> list[tuple[int, int]]:
    """Pixels of a channel's pictures on the canvas, one for each eye, with their margins."""
    layout = None if display == "mono" else LAYOUTS[display]
    if one.shape in CUBES:  # whose faces are never squeezed
        face = _face(one)
        return [(COLUMNS * face, ROWS * face)] * (1 if layout is None else 2)
    width, height = one.place[2:]
    if one.screen is not None and not isinstance(one.screen, Flat):
        across, up = _finer(one)
        width, height = round(across * width), round(up * height)
    whole: Rect = (0, 0, width, height)
    parts = (whole,) if layout is None else halves(whole, layout.beside)
    if layout is not None and layout.tall:
        parts = whole, whole
    return [(part[2] + 2 * MARGIN_PX, part[3] + 2 * MARGIN_PX) for part in parts]


def _inner(rect: Rect) -> Rect:
    """What is shown of a picture on the canvas."""
    x, y, width, height = rect
    return x + MARGIN_PX, y + MARGIN_PX, width - 2 * MARGIN_PX, height - 2 * MARGIN_PX


def _with_margin(frustum: Frustum, rect: Rect) -> Array:
    """The projection of a frustum for all of a picture.

    Without a margin specks whose middle lies beyond the edge would end at the seam.
    """
    left, right, bottom, top = frustum.edges
    _, _, width, height = _inner(rect)
    x, y = (right - left) * MARGIN_PX / width, (top - bottom) * MARGIN_PX / height
    return off_axis(*(NEAR_CM * edge for edge in (left - x, right + x, bottom - y, top + y)))


def _finer(one: ProjectorChannel) -> tuple[float, float]:
    """How many more pixels a curved screen's planar view needs to be nowhere coarser."""
    assert one.screen is not None
    places, middle = grid_of(one.screen), np.zeros(3)
    points = points_on(one.screen, places.reshape(-1, 2))
    seen = seen_at(_frustum(one, middle), middle, points).reshape(places.shape)
    found = []
    for axis, column in ((1, 0), (0, 1)):
        ratio = np.diff(places, axis=axis)[..., column] / np.diff(seen, axis=axis)[..., column]
        found.append(float(np.clip(ratio.max(), 1.0, FINEST)))
    return found[0], found[1]


def _frustum(one: ProjectorChannel, offset: Array) -> Frustum:
    """The frustum of an eye that takes in a channel's screen."""
    assert one.screen is not None
    points = points_on(one.screen, grid_of(one.screen).reshape(-1, 2))
    try:
        return frustum_of(one.screen, offset, points)
    except UserError as fault:
        raise UserError(f"channel {one.name!r}: {fault}", key=one.key) from fault


def _warp(one: ProjectorChannel, offsets: Sequence[Array], frusta: Sequence[Frustum]) -> Warp:
    """The mesh of a channel, and where each eye's picture has what it shows."""
    assert one.screen is not None
    columns, triangles = mesh_of(one)
    points = points_on(one.screen, columns[:, 2:])
    seen = [seen_at(f, offset, points) for f, offset in zip(frusta, offsets, strict=True)]
    return Warp(np.hstack([columns[:, :2], seen[0], seen[-1]]).astype(np.float32), triangles)


def _face(one: ProjectorChannel) -> int:
    return face_size(_display(one), one.place[2:], one.surround)


def _round(one: ProjectorChannel, rect: Rect, offset: Array) -> tuple[Eye, ...]:
    """The eyes of a channel that shows all round."""
    aside = float(offset[0]) / one.distance_cm
    shown = visible_parts(_display(one), one.place[2:], one.surround, aside)
    return cube(rect[:2], _face(one), shown, offset)


def _display(one: ProjectorChannel) -> str:
    """The display mode that shows alike."""
    return next(name for name, shape in SURROUNDS.items() if shape == one.shape)
