"""Resolve the channels of a theatre file, each with its mesh and mask.

Projectors that light the same part of a screen are blended: at every point of the screen the shares
of all projectors add up to one. A projector's share falls smoothly to zero toward those of its
edges that lie within another one's picture.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.base.errors import UserError, unknown
from subsea.base.files import read_input
from subsea.base.toml_files import error_at
from subsea.stage.theatre import theatre_file
from subsea.stage.theatre.adjusting import patch_adjustment, upright
from subsea.stage.theatre.imported import ImportedTheatre
from subsea.stage.theatre.mesh_formats import read_warp
from subsea.stage.theatre.mpcdi import MpcdiRegion, read_mpcdi
from subsea.stage.theatre.mpcdi import mask as calibrated_mask
from subsea.stage.theatre.pixel_files import MAX_PICTURE, parse_png, stretched
from subsea.stage.theatre.screens import (
    Flat,
    Screen,
    distance_to,
    frustum_of,
    part_of,
    places_on,
    points_on,
    screen_of,
)
from subsea.stage.theatre.warp import continued, cropped, identity, rasterized
from subsea.view.meshes import grid_triangles, subdivided
from subsea.view.rig import Projection, Rect, Warp, overlap
from subsea.view.surround import ALL_ROUND, Surround

COARSER = 4  # pixels of a projector a side for one of its blending mask
PIECE = math.radians(1.0)  # of a curved screen, which counts as flat within it
TALL = 8  # pieces of its height
WITHIN = 1e-6  # of a screen: tolerance at its edges
LEAST = 1e-4  # of a screen: least distance from the edges where one projector shines alone
EDGE = np.linspace(0.02, 0.98, 49)  # places along an edge to test for other projectors


@dataclass(frozen=True)
class ProjectorChannel:
    """A usable channel; lengths in centimetres of the sea."""

    name: str
    window: int  # number of its window in the theatre
    place: Rect  # in its window, origin lower left
    distance_cm: float  # of its screen, or of the plane in which that lies, from the eyes
    adjustment: theatre_file.Adjustment
    screen: Screen | None = None  # None for panoramas, domes and the like
    shape: Projection = Projection.FLAT
    surround: Surround = ALL_ROUND  # angle of a panorama, tilt of a dome
    warp: Warp | None = None  # from the picture to the screen
    own_mask: Array | None = None  # (h, w, 4) of its files, as `rig.DisplayPatch` has it
    own_gamma: float | None = None  # the gamma that it was made for; None: it is for any
    mask: Array | None = None  # with the blend
    blend: bool = False
    eye: str | None = None  # "left" or "right" of a projector for one eye
    key: str = ""  # of its table in the theatre file, such as channel[0]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of its picture in pixels, before it is turned."""
        return upright(self.adjustment, self.place[2:])


def usable_channels(
    theatre: theatre_file.Theatre, path: Path
) -> tuple[tuple[ProjectorChannel, ...], tuple[UserError, ...]]:
    """The channels that work, and an error for each fault in the file `path`.

    Raises the first error if no channel works.
    """
    usable: list[ProjectorChannel] = []
    faults: list[UserError] = []
    for k, channel in enumerate(theatre.channel):
        key = f"channel[{k}]"
        try:
            usable.append(_check_free(_file_channel(theatre, channel, path.parent, key), usable))
        except UserError as fault:
            faults.append(error_at(path, key, f"channel {channel.name!r}: {fault}"))
    for k, archive in enumerate(theatre.mpcdi):
        key = f"mpcdi[{k}]"
        try:
            read = read_mpcdi(path.parent / archive.file)
        except UserError as fault:
            faults.append(error_at(path, key, f"{fault}"))
            continue
        faults += [error_at(path, key, fault) for fault in read.faults]
        for region in read.regions:
            if archive.buffer not in (None, region.buffer):
                continue
            try:
                usable.append(_check_free(_mpcdi_channel(theatre, archive, region, key), usable))
            except UserError as fault:
                where = f"{archive.file}: region {region.name!r}"
                faults.append(error_at(path, key, f"{where}: {fault}"))
    if not usable:
        raise faults[0] if faults else UserError("no channel is left", file=path)
    return blended(usable), tuple(faults)


def screen_mesh(lighted: ProjectorChannel) -> tuple[Array, Ints]:
    """Vertices (n, 4), x and y in the picture and s and t on the screen, and triangles."""
    assert lighted.screen is not None  # a surround projection has no mesh
    grid = screen_grid(lighted.screen)
    up, across = grid.shape[0] - 1, grid.shape[1] - 1
    if lighted.warp is not None:
        warp = subdivided(lighted.warp, across, up)
        return warp.vertices[:, :4].astype(np.float64), warp.triangles
    places = grid.reshape(-1, 2)
    return np.hstack([places, places]), grid_triangles(across + 1, up + 1).astype(np.int32)


def screen_grid(screen: Screen) -> Array:
    """Places (rows, columns, 2) on a screen, between which it is almost flat."""
    across, up = 1, 1
    if not isinstance(screen, Flat):
        across, up = math.ceil((screen.right - screen.left) / PIECE), TALL
    x, y = np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, 1, up + 1))
    return np.stack([x, y], axis=-1)


def _check_free(new: ProjectorChannel, usable: Sequence[ProjectorChannel]) -> ProjectorChannel:
    """Return the new channel; a UserError if it overlaps another in its window."""
    for other in usable:
        if other.window == new.window and overlap(other.place, new.place):
            raise UserError(f"lies on {other.name!r} in its window; expected places side by side")
    return new


def _file_channel(
    theatre: theatre_file.Theatre, channel: theatre_file.Channel, folder: Path, key: str
) -> ProjectorChannel:
    names = [window.name for window in theatre.window]
    number = names.index(channel.window)
    window = theatre.window[number]
    x, y, width, height = theatre_file.viewport(channel, window)
    place = x, y, width, height
    lighted = _channel_on(theatre, channel, channel.name, number, place, channel.part)
    for word in ("blend", "eye"):
        if getattr(channel, word) and lighted.screen is None:
            kind = lighted.shape.name.lower()
            raise UserError(f"`{word}` is of a `plane`, `cylinder` or `angles`, not of a {kind}")
    lighted = replace(lighted, blend=channel.blend, eye=channel.eye, key=key)
    if channel.warp is not None:
        made = theatre.meshes.get(channel.warp) if isinstance(theatre, ImportedTheatre) else None
        warp, mask = made[:2] if made else read_warp(folder / channel.warp, lighted.size)
        lighted = replace(lighted, warp=warp, own_mask=mask)
    if channel.part is not None and lighted.screen is None:
        lighted = replace(lighted, warp=cropped(lighted.warp or identity(), channel.part))
    if channel.mask is not None:
        picture = _mask_picture(folder / channel.mask, lighted.size)
        lighted = replace(lighted, own_mask=_masked(lighted.own_mask, picture))
    return lighted


def _mask_picture(path: Path, most: tuple[int, int]) -> Array:
    """The factors (h, w, 3) of a PNG picture, of at most `most` pixels."""
    picture = parse_png(read_input(path, MAX_PICTURE), str(path))
    height, width, _ = picture.shape
    return stretched(picture, min(width, most[0]), min(height, most[1]))


def _masked(mask: Array | None, picture: Array) -> Array:
    """A mask (h, w, 4) times the factors (h, w, 3) of a picture."""
    factors = np.zeros((*picture.shape[:2], 4), np.float32)
    factors[..., :3] = picture
    if mask is not None:
        height, width = picture.shape[:2]
        factors[..., :3] *= stretched(np.asarray(mask[..., :3], np.float32), width, height)
    return factors


def _mpcdi_channel(
    theatre: theatre_file.Theatre, archive: theatre_file.Archive, region: MpcdiRegion, key: str
) -> ProjectorChannel:
    """A region of an archive: the part of the screen that is its place in the buffer.

    One with a frustum shows that instead, at the distance of the screen.
    """
    shown = region.name if archive.windows is None else archive.windows.get(region.name)
    names = [window.name for window in theatre.window]
    if shown is None:
        raise UserError("`windows` gives it none, so it is left out")
    if shown not in names:
        raise unknown("window", shown, names)
    number = names.index(shown)
    place = 0, 0, *theatre.window[number].size
    adjustment = archive.adjust.get(region.name, theatre_file.adjustment_of(archive))
    if region.frustum is not None:
        view = theatre_file.Angles(**region.frustum._asdict())
        if (far := _screen_distance(theatre, archive)) is not None:
            view = msgspec.structs.replace(view, distance_cm=far)
        lit = theatre_file.ScreenTable(angles=view)
        lighted = _channel_on(theatre, lit, region.name, number, place, None)
    elif not any(getattr(archive, kind) for kind in theatre_file.SCREENS):
        raise UserError(
            f"has no frustum of its own, expected one of {', '.join(theatre_file.SCREENS[:3])}"
        )
    else:
        lighted = _channel_on(theatre, archive, region.name, number, place, region.place)
    warp = region.warp
    if lighted.shape == Projection.PANORAMA:
        raise UserError("`panorama` is for uncalibrated screens, expected a `cylinder`")
    if lighted.screen is None:
        warp = cropped(warp or identity(), region.place)
    patch_adjustment(adjustment, upright(adjustment, place[2:]))  # raises a UserError if it folds
    lighted = replace(lighted, adjustment=adjustment, warp=warp, key=key)
    own_mask = calibrated_mask(region, adjustment.gamma, lighted.size)
    return replace(lighted, own_mask=own_mask, own_gamma=adjustment.gamma)


def _screen_distance(theatre: theatre_file.Theatre, archive: theatre_file.Archive) -> float | None:
    """Distance of an archive's screen in real centimetres, None if it has none."""
    wide = archive.panorama or archive.dome or archive.equirectangular
    if wide is not None:
        return wide.distance_cm
    flat = archive.plane or archive.cylinder or archive.angles
    return None if flat is None else distance_to(screen_of(flat, np.array(theatre.eye_cm), 1.0))


def _channel_on(
    theatre: theatre_file.Theatre,
    lit: theatre_file.ScreenTable,
    name: str,
    number: int,
    place: Rect,
    part: tuple[float, float, float, float] | None,
) -> ProjectorChannel:
    """The channel on the screen `lit`; `place` counts from the window's upper left corner."""
    x, y, width, height = place
    window: theatre_file.Window = theatre.window[number]
    adjustment = theatre_file.adjustment_of(lit)
    patch_adjustment(adjustment, upright(adjustment, (width, height)))  # raises if it folds
    corner = x, window.size[1] - y - height
    common = ProjectorChannel(name, number, (*corner, width, height), 1.0, adjustment)
    if (wide := lit.panorama or lit.dome or lit.equirectangular) is not None:
        shape, surround = Projection.EQUIRECTANGULAR, ALL_ROUND
        if isinstance(wide, theatre_file.Panorama):
            shape, surround = Projection.PANORAMA, Surround(angle_deg=wide.angle_deg)
        elif isinstance(wide, theatre_file.Dome):
            surround = Surround(tilt_deg=wide.tilt_deg, dome_deg=wide.angle_deg)
            shape = Projection.DOME
        far = theatre.scale * wide.distance_cm
        return replace(common, distance_cm=far, shape=shape, surround=surround)
    flat = lit.plane or lit.cylinder or lit.angles
    assert flat is not None  # one of six, as `ScreenTable` has checked
    screen = screen_of(flat, np.array(theatre.eye_cm), theatre.scale)
    screen = screen if part is None else part_of(screen, part)
    # Raises a UserError if no view takes it in.
    frustum_of(screen, np.zeros(3), points_on(screen, screen_grid(screen).reshape(-1, 2)))
    return replace(common, screen=screen, distance_cm=distance_to(screen))


def blended(channels: Sequence[ProjectorChannel]) -> tuple[ProjectorChannel, ...]:
    """Give channels the masks of their files, and those to blend their shares of the light, too."""
    lamps = {}
    for k, one in enumerate(channels):
        if one.blend and one.screen is not None:
            light = one.adjustment
            lamps[k] = Projector(one.screen, light.gamma, light.black, light.blend_width)
    found = []
    for k, channel in enumerate(channels):
        mask = _own_mask(channel)
        if k in lamps and len(lamps) > 1:
            mask = _blend(channel, list(lamps.values()), list(lamps).index(k))
        found.append(replace(channel, mask=mask))
    return tuple(found)


def _blend(channel: ProjectorChannel, lamps: Sequence["Projector"], number: int) -> Array:
    """The mask (h, w, 4) of a channel that is the projector `number` of those that blend."""
    size = max(channel.size[0] // COARSER, 1), max(channel.size[1] // COARSER, 1)
    x, y = (np.arange(n) + 0.5 for n in size)
    places = np.stack(np.meshgrid(x / size[0], 1.0 - y / size[1]), axis=-1).reshape(-1, 2)
    if channel.warp is not None:
        count = len(channel.warp.vertices)
        columns = *channel.warp.vertices[:, 2:4].T.astype(np.float64), np.ones(count)
        drawn = np.stack([rasterized(channel.warp, column, size) for column in columns], axis=2)
        places = continued(drawn[..., :2], drawn[..., 2] > 0).reshape(-1, 2).clip(0.0, 1.0)
    mask = blend_mask(lamps, number, places).reshape(size[1], size[0], 4)
    own_mask = _own_mask(channel)
    if own_mask is not None:  # the mesh's own brightness
        mask = mask * _resized(own_mask, size)
    return np.asarray(mask.astype(np.float32))


def _own_mask(channel: ProjectorChannel) -> Array | None:
    """The mask (h, w, 4) of a channel's files, for the gamma that the channel has now."""
    mask, gamma = channel.own_mask, channel.adjustment.gamma
    if mask is None or channel.own_gamma in (None, gamma):
        return mask
    lit = np.array(mask)
    lit[..., :3] **= (channel.own_gamma or gamma) / gamma
    return lit


def _resized(mask: Array, size: tuple[int, int]) -> Array:
    """A mask at another size, by its nearest values; the last column becomes 1."""
    rows = (np.arange(size[1]) * mask.shape[0]) // size[1]
    columns = (np.arange(size[0]) * mask.shape[1]) // size[0]
    resized = mask[rows][:, columns].copy()
    resized[..., 3] = 1.0
    return resized


class Projector(NamedTuple):
    """A projector: its screen and its light."""

    screen: Screen
    gamma: float
    black: float  # share of its white that it shines when dark
    width: float = 1.0  # of its fades, over the usual width


def light_shares(projectors: Sequence[Projector], number: int, places: Array) -> Array:
    """The share (n,) of the light that projector `number` gives to places (n, 2) of its screen."""
    points = points_on(projectors[number].screen, places)
    seen = [places_on(projector.screen, points) for projector in projectors]
    seen[number] = places
    weights = np.stack(
        [_blend_weight(projectors, k, places_there) for k, places_there in enumerate(seen)]
    )
    total = weights.sum(axis=0)
    return np.where(total > 0.0, weights[number] / np.where(total > 0.0, total, 1.0), 1.0)


def overlap_count(projectors: Sequence[Projector], number: int, places: Array) -> Ints:
    """The number (n,) of projectors that light places (n, 2) of projector `number`'s screen."""
    points = points_on(projectors[number].screen, places)
    return np.sum(
        [_within(places_on(projector.screen, points)) for projector in projectors],
        axis=0,
        dtype=np.int_,
    )


def blend_mask(projectors: Sequence[Projector], number: int, places: Array) -> Array:
    """Factors on values and offsets of light (n, 4) at places (n, 2) of projector `number`.

    See `rig.DisplayPatch.mask`. Where fewer projectors shine than elsewhere, their black is raised
    to that of the places where most do. White is dimmed for that alike everywhere.
    """
    projector = projectors[number]
    light = light_shares(projectors, number, places)
    here = overlap_count(projectors, number, places)
    steps = np.stack(np.meshgrid(EDGE, EDGE), axis=-1).reshape(-1, 2)
    counts = [overlap_count(projectors, k, steps) for k in range(len(projectors))]
    most = max(int(np.max(counts)), int(here.max(initial=1)))
    lifted = projector.black * (most - here) / np.maximum(here, 1)
    white = 1.0 - max(other.black for other in projectors) * (most - 1)
    factor = (light * white) ** (1.0 / projector.gamma)
    return np.column_stack([factor, factor, factor, lifted])


def _blend_weight(projectors: Sequence[Projector], number: int, places: Array) -> Array:
    """The weight of a projector at places (n, 2) of its screen; 0 beyond its edges."""
    s, t = places.T
    weight = _within(places).astype(np.float64)
    edges = _blended_edges(projectors, number)
    for blended, inside in zip(edges, (s, 1 - s, t, 1 - t), strict=True):
        if blended:
            # The steeper the weights, the narrower the fade from one projector to the next.
            weight *= np.clip(np.nan_to_num(inside), LEAST, 1.0) ** (2.0 / projectors[number].width)
    return weight


def _blended_edges(projectors: Sequence[Projector], number: int) -> tuple[bool, ...]:
    """True for each edge (left, right, lower, upper) that lies within another's picture."""
    screen = projectors[number].screen
    zero, whole = np.zeros_like(EDGE), np.ones_like(EDGE)
    edges = (zero, EDGE), (whole, EDGE), (EDGE, zero), (EDGE, whole)
    others = [other.screen for k, other in enumerate(projectors) if k != number]
    points = [points_on(screen, np.column_stack(edge)) for edge in edges]
    return tuple(
        any(bool(_within(places_on(other, edge_points), -1e-3).any()) for other in others)
        for edge_points in points
    )


def _within(places: Array, beyond: float = WITHIN) -> Bools:
    with np.errstate(invalid="ignore"):
        return np.asarray(((places >= -beyond) & (places <= 1.0 + beyond)).all(axis=1))
