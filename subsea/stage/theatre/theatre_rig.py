"""The rig of a theatre: one view for each channel and eye, and its patches on the windows."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.stage.theatre.adjusting import patch_adjustment
from subsea.stage.theatre.channels import ProjectorChannel, screen_grid, screen_mesh
from subsea.stage.theatre.screens import Flat, Frustum, frustum_of, points_on, seen_at
from subsea.stage.theatre.theatre_file import Theatre
from subsea.view.camera import NEAR_CM, off_axis
from subsea.view.display_rigs import SURROUNDS, cube
from subsea.view.rig import CUBES, CameraRig, DisplayPatch, Eye, Projection, Rect, Warp
from subsea.view.stereo import EYES, LAYOUTS, Stereo, halves, patches_of
from subsea.view.surround import COLUMNS, MARGIN_PX, ROWS, face_size, inner, visible_parts
from subsea.view.theatre_vessel import TheatreVessel

FINEST = 1.5  # largest number of pixels of a curved screen's view per pixel of the projector
WIDEST = 8192  # pixels of a row on the canvas, unless a single picture is wider
MODES = ("mono", *LAYOUTS)
DISPLAY_OF = {shape: display for display, shape in SURROUNDS.items()}  # with the same projection


def theatre_rig(
    theatre: Theatre,
    channels: Sequence[ProjectorChannel],
    windows: Sequence[int],
    display: str = "mono",
    stereo: Stereo = EYES,
) -> CameraRig:
    """The rig of the `channels` in the windows of these numbers, which are its outputs.

    `display` says how two eyes share each channel's pixels; `stereo` replaces the theatre's own
    values.
    """
    if display not in MODES:
        raise UserError(f"--display {display}: the displays of a theatre are {', '.join(MODES)}")
    shown = {
        number: channel for number, channel in enumerate(channels) if channel.window in windows
    }
    if not shown:
        raise UserError("no channel of this theatre is left to show")
    both = _offsets(theatre, channels, display, stereo)
    half = float(both[-1][0])
    sizes = [size for channel in shown.values() for size in _pictures(channel, display)]
    corners, canvas = shelves(sizes)
    drawn = iter([(*corner, *size) for corner, size in zip(corners, sizes, strict=True)])
    eyes: list[Eye] = []
    patches: list[DisplayPatch] = []
    for number, channel in shown.items():
        rects = [next(drawn) for _ in both]
        offsets = _own_offsets(theatre, channel, both, stereo)
        if channel.shape in CUBES:
            for rect, offset in zip(rects, offsets, strict=True):
                eyes += _cube_eyes(channel, rect, offset)
        else:
            frusta = [_frustum(channel, offset) for offset in offsets]
            for rect, offset, frustum in zip(rects, offsets, frusta, strict=True):
                projection = _with_margin(frustum, rect)
                eyes.append(Eye(rect, offset, frustum.axes, projection))
            rects = [inner(rect) for rect in rects]
        patch = DisplayPatch(
            channel.place, rects[0], rects[-1], shape=channel.shape, wide=channel.surround.wide,
            output=windows.index(channel.window), channel=number, **_light(channel),
        )  # fmt: skip
        if channel.shape in CUBES:
            patch = patch._replace(apart=half / channel.distance_cm, warp=channel.warp)
        elif not isinstance(channel.screen, Flat) or channel.warp is not None:
            patch = patch._replace(shape=Projection.WARPED, warp=_warp(channel, offsets, frusta))
        patches += (patch,) if display == "mono" else patches_of(LAYOUTS[display], patch)
    outputs = tuple(theatre.window[number].size for number in windows)
    return CameraRig(
        canvas, outputs, tuple(eyes), tuple(patches), theatre.level,
        vessel=_vessel(theatre, channels),
    )  # fmt: skip


def readjusted(rig: CameraRig, channels: Sequence[ProjectorChannel]) -> CameraRig:
    """The rig of `theatre_rig` with other adjustments and masks of its channels.

    Pictures that are now turned on their side need a new rig instead.
    """
    lights = [_light(channel) for channel in channels]
    return rig._replace(
        patches=tuple(patch._replace(**lights[patch.channel]) for patch in rig.patches)
    )


def _light(channel: ProjectorChannel) -> dict[str, Any]:
    """The fields of a patch that line-up changes."""
    return {
        "mask": channel.mask,
        "gamma": channel.adjustment.gamma,
        "adjustment": patch_adjustment(channel.adjustment, channel.size),
    }


def visible_channels(
    theatre: Theatre,
    channels: Sequence[ProjectorChannel],
    display: str = "mono",
    stereo: Stereo = EYES,
) -> tuple[tuple[ProjectorChannel, ...], tuple[UserError, ...]]:
    """The channels whose screens are in front of all eyes, and an error for each other one."""
    kept: list[ProjectorChannel] = []
    faults: list[UserError] = []
    offsets = _offsets(theatre, channels, display, stereo)
    for channel in channels:
        try:
            for offset in _own_offsets(theatre, channel, offsets, stereo):
                if channel.shape not in CUBES:
                    _frustum(channel, offset)
                elif np.linalg.norm(offset) >= channel.distance_cm:
                    message = f"channel {channel.name!r}: the eye is outside of its screen"
                    raise UserError(message, key=channel.key)
        except UserError as fault:
            faults.append(fault)
        else:
            kept.append(channel)
    if faults and kept:  # the eyes may be farther apart for those that are left
        visible, more = visible_channels(theatre, kept, display, stereo)
        return visible, (*faults, *more)
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


def _vessel(theatre: Theatre, channels: Sequence[ProjectorChannel]) -> TheatreVessel | None:
    """The vessel of a theatre; all channels count, so all nodes draw the same."""
    table = theatre.vessel
    if table is None:
        return None
    return TheatreVessel(
        max(min(channel.distance_cm for channel in channels), 2.0 * NEAR_CM),
        float(np.radians(table.spring_deg)),
        float(np.radians(table.rim_deg)),
        float(np.radians(table.tilt_deg)),
        float(np.radians(table.panel_deg)) if table.instruments else None,
    )


def _offsets(
    theatre: Theatre, channels: Sequence[ProjectorChannel], display: str, stereo: Stereo
) -> list[Array]:
    """Offsets (3,) of the eyes, cm of the sea; all channels count, so all nodes agree."""
    if display == "mono":
        return [np.zeros(3)]
    real = stereo.separation_cm
    apart = theatre.scale * (theatre.eye_distance_cm if real is None else real)
    nearest = min(channel.distance_cm for channel in channels)
    # Screens are at their real distance, so the parallax never exceeds the eye separation.
    eyes = stereo._replace(separation_cm=apart, screen_cm=nearest, screen_width_cm=None)
    half = eyes.eyes(1.0) / 2.0 * (-1 if stereo.swapped else 1)
    return [np.array([x, 0.0, 0.0]) for x in (-half, half)]


def _own_offsets(
    theatre: Theatre, channel: ProjectorChannel, offsets: list[Array], stereo: Stereo
) -> list[Array]:
    """The offsets of a channel's pictures: those of its one eye if it is for one."""
    if channel.eye is None:
        return offsets
    left, right = _offsets(theatre, [channel], "side-by-side", stereo)
    return [left if channel.eye == "left" else right] * len(offsets)


def _pictures(channel: ProjectorChannel, display: str) -> list[tuple[int, int]]:
    """Pixels of a channel's pictures on the canvas, one for each eye, with their margins."""
    layout = None if display == "mono" else LAYOUTS[display]
    if channel.shape in CUBES:  # whose faces are never squeezed
        face = face_size(DISPLAY_OF[channel.shape], channel.size, channel.surround)
        return [(COLUMNS * face, ROWS * face)] * (1 if layout is None else 2)
    width, height = channel.size
    if channel.screen is not None and not isinstance(channel.screen, Flat):
        across, up = _finer_by(channel)
        width, height = round(across * width), round(up * height)
    whole: Rect = (0, 0, width, height)
    parts = (whole,) if layout is None else halves(whole, layout.beside)
    if layout is not None and layout.tall:
        parts = whole, whole
    return [(part[2] + 2 * MARGIN_PX, part[3] + 2 * MARGIN_PX) for part in parts]


def _with_margin(frustum: Frustum, rect: Rect) -> Array:
    """The projection of a frustum for all of a picture.

    Without a margin specks whose middle lies beyond the edge would end at the seam.
    """
    left, right, bottom, top = frustum.edges
    _, _, width, height = inner(rect)
    x, y = (right - left) * MARGIN_PX / width, (top - bottom) * MARGIN_PX / height
    return off_axis(*(NEAR_CM * edge for edge in (left - x, right + x, bottom - y, top + y)))


def _finer_by(channel: ProjectorChannel) -> tuple[float, float]:
    """Factors on the pixels of a curved screen's planar view, so that it is nowhere coarser."""
    assert channel.screen is not None
    places, middle = screen_grid(channel.screen), np.zeros(3)
    points = points_on(channel.screen, places.reshape(-1, 2))
    seen = seen_at(_frustum(channel, middle), middle, points).reshape(places.shape)
    factors = []
    for axis, column in ((1, 0), (0, 1)):
        ratio = np.diff(places, axis=axis)[..., column] / np.diff(seen, axis=axis)[..., column]
        factors.append(float(np.clip(ratio.max(), 1.0, FINEST)))
    return factors[0], factors[1]


def _frustum(channel: ProjectorChannel, offset: Array) -> Frustum:
    """The frustum of an eye that takes in a channel's screen."""
    assert channel.screen is not None
    points = points_on(channel.screen, screen_grid(channel.screen).reshape(-1, 2))
    try:
        return frustum_of(channel.screen, offset, points)
    except UserError as fault:
        raise UserError(f"channel {channel.name!r}: {fault}", key=channel.key) from fault


def _warp(channel: ProjectorChannel, offsets: Sequence[Array], frusta: Sequence[Frustum]) -> Warp:
    """The mesh of a channel with texture coordinates in each eye's picture."""
    assert channel.screen is not None
    columns, triangles = screen_mesh(channel)
    points = points_on(channel.screen, columns[:, 2:])
    seen = [seen_at(f, offset, points) for f, offset in zip(frusta, offsets, strict=True)]
    return Warp(np.hstack([columns[:, :2], seen[0], seen[-1]]).astype(np.float32), triangles)


def _cube_eyes(channel: ProjectorChannel, rect: Rect, offset: Array) -> tuple[Eye, ...]:
    """The eyes of a channel with a surround projection."""
    display, size = DISPLAY_OF[channel.shape], channel.size
    shown = visible_parts(display, size, channel.surround, float(offset[0]) / channel.distance_cm)
    return cube(rect[:2], face_size(display, size, channel.surround), shown, offset)
