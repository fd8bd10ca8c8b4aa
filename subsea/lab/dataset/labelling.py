"""`subsea.labels`: the truth about every pixel, fish and keypoint of a picture of any camera."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Bools, Ints
from subsea.base.errors import UserError
from subsea.dive.ride import FIRST, VALUES, values_of
from subsea.frame.packet import FISH as NUMBER
from subsea.frame.packet import KIND, instances_of, lamps_of, pack
from subsea.geometry.solids import height_at
from subsea.geometry.vector import vector
from subsea.habitat.contact import is_free
from subsea.habitat.reef import KINDS as GROWTHS
from subsea.lab.dataset.boxes import whole_boxes
from subsea.lab.dataset.keypoints import NAMES, KeypointsIn, keypoint_shape, keypoints_at
from subsea.library import World, check_fish, checked_size, drawing
from subsea.media.flow import (
    NEAR_CM,
    Bodies,
    FlowMoment,
    SeenMaps,
    body_flow,
    carried,
    empty_coverage,
    enter_bodies,
)
from subsea.rendering.fish.bodies import Shapes, Vertices, levels_of
from subsea.rendering.fish.fishes import FishShape
from subsea.rendering.gl.id_buffer import (
    BUBBLES,
    CORAL,
    FISH,
    HOOK,
    KINDS,
    NUMBERED,
    SEAWEED,
    SURFACE,
    IdMaps,
)
from subsea.rendering.reef.coral import LOOKS
from subsea.view.camera import View, look, off_axis
from subsea.view.display_rigs import cockpit
from subsea.view.follow import follow_fish
from subsea.view.optics import (
    STRAIGHT,
    CameraLens,
    Canvas,
    FlatPort,
    Optics,
    canvas_of,
    sources,
    take_between,
    take_nearest,
)
from subsea.view.rig import CameraPose, CameraRig, DisplayPatch, Eye
from subsea.world.world import World as State

Poses = Callable[[World, float], CameraPose]
Camera = CameraPose | int | Poses | None
ABSENT, OUTSIDE, HIDDEN, VISIBLE = -1, 0, 1, 2  # states of a keypoint
NOTHING = -1  # in place of an identity
OF_THINGS = tuple(kind for kind in KINDS if kind != "fish")
CLOSE_L, CLOSE_PX = 0.03, 1.5  # tolerance of a keypoint's depth: body lengths, pixels
FIELD_DEG = 70.0


class FishLabels(NamedTuple):
    """The n fishes that reach into the picture, hidden or not, the nearest first.

    Boxes are x, y, width, height in pixels from the upper left corner of the picture. Keypoints are
    x, y with the middle of the upper left pixel at (0, 0). The k keypoints are those of
    `subsea.lab.dataset.keypoints.NAMES`.
    """

    number: Ints  # (n,) index of the fish in the world
    species: Ints  # (n,) index into `World.species`
    box: Array  # (n, 4) of what is visible, NaN if nothing is
    whole: Array  # (n, 4) of the whole body, cut at the picture's edge
    pixels: Ints  # (n,) visible ones
    share: Array  # (n,) visible pixels over those that the whole body covers in the picture
    distance: Array  # (n,) cm, depth of the middle of the body
    keypoints: Array  # (n, k, 2) pixels, NaN if absent or behind the camera
    depth: Array  # (n, k) cm, of keypoints
    state: Ints  # (n, k) -1 the species has none, 0 out of the picture, 1 hidden, 2 visible
    # (n, k) identity of what hides a keypoint, also the fish itself. Else -1, also for hidden ones
    # on skin that is too translucent, or seen too much edge-on, to show in the pixels around.
    hidden_by: Ints


@dataclass(frozen=True)
class Labels:
    """A picture (h, w) and the truth about it. Axes of the camera: x right, y down, z ahead."""

    picture: NDArray[np.uint8]  # (h, w, 3) red, green, blue
    identity: Ints  # (h, w) what each pixel shows: docs/reference/labelled-frames.md
    depth: Array  # (h, w) cm along the optical axis, infinite in open water
    normal: Array  # (h, w, 3) unit, of the drawn triangles; NaN in open water
    # (h, w, 2) pixels from this tick to the next, and to the one before; NaN where it is not known
    flow_forward: Array
    flow_backward: Array
    fishes: FishLabels
    optics: Optics
    matrix: Array  # (4, 4) from the world, cm, to the axes of the camera
    tick: int
    species: tuple[str, ...]  # names
    kinds: Ints  # (f,) index into `species` of all fishes of the world

    @property
    def intrinsics(self) -> Array:
        """The matrix K (3, 3) of OpenCV, to which `distortion` belongs."""
        return self.optics.intrinsics

    @property
    def distortion(self) -> Array:
        """The coefficients (5,) of OpenCV: k1, k2, p1, p2, k3."""
        return np.array(self.optics.lens)

    @property
    def classes(self) -> tuple[str, ...]:
        """The names of the values of `category`: kinds of things, then species."""
        return OF_THINGS + self.species

    @cached_property
    def category(self) -> NDArray[np.uint8]:
        """The class (h, w) of each pixel, an index into `classes`."""
        fish = self.identity >= VALUES["fish"]
        order = np.argsort(FIRST[: len(OF_THINGS)])
        kind = order[np.searchsorted(FIRST[order], self.identity, side="right") - 1]
        number = np.where(fish, self.identity - VALUES["fish"], 0)
        return np.where(fish, len(OF_THINGS) + self.kinds[number], kind).astype(np.uint8)

    def name(self, identity: int) -> str:
        """Name a value of `identity`, such as "rock 3"."""
        kind = max((value, kind) for kind, value in VALUES.items() if value <= identity)
        numbered = kind[1] in NUMBERED
        return f"{kind[1]} {identity - kind[0]}" if numbered else kind[1]


@dataclass(frozen=True)
class Drawing:
    """Options of drawing, beside the camera."""

    quality: str = "medium"
    flow: bool = True
    lamps: bool | None = None  # at the camera; None: those of the submarine
    advance: Callable[[World], None] = lambda world: world.step(1)  # to the next tick, for flow


def labels(
    world: World,
    camera: Camera | Sequence[Camera] = None,
    *,
    size: tuple[int, int] = (640, 480),
    field_deg: float = FIELD_DEG,
    lens: CameraLens | Sequence[float] = STRAIGHT,
    port: FlatPort | None = None,
    quality: str = "medium",
    flow: bool = True,
) -> Any:
    """Draw a picture of a world, and label each pixel, fish and keypoint.

    Args:
        world: The world at its current tick, which stays as it is.
        camera: A pose as of `subsea.camera`; the number of a fish, which is followed; None: the
            submarine's pilot; or a function `camera(world, share)` that returns the pose at a share
            from 0, the tick before, to 1, this one. A list of these is a rig: one of labels each.
        size: Width and height, pixels.
        field_deg: Angle from left to right that the lens has in air, without distortion.
        lens: Distortion k1, k2, p1, p2, k3 as OpenCV has it.
        port: A flat window before the lens: `subsea.FlatPort(gap_cm, glass_cm)`.
        quality: "low", "medium" or "high".
        flow: False leaves out the optical flow, which needs the next tick.

    Returns:
        `Labels`, or a list of them for a list of cameras.

    Raises:
        UserError: No OpenGL 3.3, an unknown quality, or a camera in stone or sand.
        ValueError: An unknown fish, a size that is not two numbers from 1 to 8192, or a lens that
            does not fit its field of view.
    """
    optics = Optics(checked_size(size), field_deg, CameraLens(*lens), port)
    drawn = Drawing(quality, flow)
    if isinstance(camera, Sequence) and not isinstance(camera, CameraPose):
        return labels_of(world, camera, optics, drawn)
    return labels_of(world, [camera], optics, drawn)[0]


def labels_of(
    world: World, cameras: Sequence[Any], optics: Optics, drawn: Drawing = Drawing()
) -> list[Labels]:
    """Draw labels of several cameras with the same optics."""
    poses = [poses_of(world, camera) for camera in cameras]
    now = [_checked(world, pose(world, 1.0)) for pose in poses]
    made = [_Making(world, pose, optics, drawn) for pose in now]
    if drawn.flow:
        for one, pose in zip(made, poses, strict=True):
            one.look(0, pose(world, 0.0), 0.0)
        kept = world.snapshot()
        try:
            drawn.advance(world)
            for one, pose in zip(made, poses, strict=True):
                one.look(1, pose(world, 1.0), 1.0)
        finally:
            world.restore(kept)
    return [one.finish() for one in made]


def poses_of(world: World, camera: Camera) -> Poses:
    """Return the pose of a camera as a function of the world and the share of the last tick."""
    if camera is None:
        return lambda world, share: cockpit(world.internal.state.submarine, share)
    if isinstance(camera, CameraPose):
        return lambda world, share: camera
    if callable(camera):
        return camera
    check_fish(world, camera)
    fish = int(camera)
    return lambda world, share: follow_fish(world.internal, fish, share, None)[1]


def _checked(world: World, pose: CameraPose) -> CameraPose:
    """Return a pose that stands free; a UserError for one in stone or sand."""
    if not isinstance(pose, CameraPose):
        raise TypeError(f"camera: expected what subsea.camera returns, got {pose!r}")
    fault = inside(world.internal, pose.eye)
    if fault:
        place = ", ".join(f"{x:.0f}" for x in pose.eye)
        raise UserError(f"the camera at ({place}) cm is inside {fault}; move it into free water")
    return pose


def inside(state: State, place: Array) -> str:
    """Name the solid that holds a place (3,), "" in free water."""
    sea, at = state.state.sea, vector(np.asarray(place, np.float64))
    if not is_free(sea.pillars, sea.rocks, at):
        return "a stone"
    if at[2] < height_at(sea.heights, sea.half_width, at[0], at[1]):
        return "the seabed"
    return ""


class _Shapes(NamedTuple):
    bodies: Shapes
    keypoints: FishShape


_shapes: list[tuple[Any, _Shapes]] = []  # of the last worlds, by what they depend on
KEPT = 4


def _shapes_of(world: World) -> _Shapes:
    state = world.internal
    lengths = tuple(float(x) for x in state.library.recorded_length)
    key = state.species, lengths
    for known, shapes in _shapes:
        if known == key:
            return shapes
    bodies = Shapes(*key)
    made = _Shapes(bodies, keypoint_shape(*key, bodies.skins))
    _shapes.append((key, made))
    del _shapes[:-KEPT]
    return made


def _rig(canvas: Canvas) -> CameraRig:
    """The rig of one pinhole."""
    width, height = canvas.size
    right, top = (NEAR_CM * 0.5 * side / canvas.focal_px for side in canvas.size)
    place = (0, 0, width, height)
    eye = Eye(place, np.zeros(3), np.eye(3), off_axis(-right, right, -top, top, NEAR_CM))
    return CameraRig(canvas.size, (canvas.size,), (eye,), (DisplayPatch(place, place, place),))


class _Maps(NamedTuple):
    """The picture and maps of the renderer, seen through the lens."""

    picture: NDArray[np.uint8]
    kind: Ints
    identity: Ints
    depth: Array
    normal: Array


class _Making:
    """Labels of one camera, to which the flow is added tick by tick."""

    def __init__(self, world: World, pose: CameraPose, optics: Optics, drawn: Drawing) -> None:
        """Draw the picture and the maps."""
        self._world, self._optics = world, optics
        self._shapes = _shapes_of(world)
        self._tick, self._flow = world.tick, drawn.flow
        canvas = canvas_of(optics)
        rig = _rig(canvas)
        self._matrix = _matrix(pose)
        eye = pose.eye + canvas.ahead_cm * pose.forward
        view = View((0, 0, *canvas.size), look(eye, *pose[1:]), rig.eyes[0].projection, eye)
        state = world.internal
        with drawing(world, rig, drawn.quality) as renderer:
            packet = pack(state, (view,), 1.0, options=renderer.quality.packing)
            if drawn.lamps is not None:
                packet = replace(packet, lamps=lamps_of(pose) if drawn.lamps else None)
            renderer.draw(packet)
            picture = renderer.read_pixels()
            seen = renderer.id_maps(packet)
        self._maps = _through(optics, canvas, picture, seen)
        self._instances = packet.instances
        self._levels = levels_of(packet)
        self._kinds = packet.instances[:, KIND].astype(np.int64)
        self._who = packet.instances[:, NUMBER].astype(np.int64)
        points = state.library.control_points
        self._bodies = self._vertices(packet.instances)
        self._keypoints = keypoints_at(self._shapes.keypoints, self._kinds, self._instances, points)
        self._others: list[Any] = [None, None]  # bodies before and after
        now = FlowMoment(self._matrix, packet.instances, points)
        self._moments = [now, now, now]  # before, after, now

    def look(self, which: int, pose: CameraPose, share: float) -> None:
        """Look at the bodies at another tick: the one before (0) or after (1)."""
        state = self._world.internal
        instances = instances_of(state, self._who, share)
        self._others[which] = self._vertices(instances)
        points = state.library.control_points
        self._moments[which] = FlowMoment(_matrix(pose), instances, points)

    def finish(self) -> Labels:
        """Compute what is not drawn."""
        optics, maps, state = self._optics, self._maps, self._world.internal
        coverage, hidden, whole = self._cover()
        flows = [np.full((*maps.depth.shape, 2), np.nan, np.float32)] * 2
        if self._flow:
            flows = self._flows(coverage.moved)
        return Labels(
            picture=maps.picture,
            identity=maps.identity,
            depth=maps.depth,
            normal=maps.normal,
            flow_forward=flows[1],
            flow_backward=flows[0],
            fishes=self._fishes(hidden, whole),
            optics=optics,
            matrix=self._matrix,
            tick=self._tick,
            species=self._world.species,
            kinds=state.state.fishes.species.astype(np.int64),
        )

    @property
    def _seen(self) -> SeenMaps:
        maps = self._maps
        return SeenMaps(self._optics, self._matrix, maps.identity, maps.depth)

    def _vertices(self, instances: Array) -> dict[int, Vertices]:
        """Vertices of all bodies by level of detail."""
        state = self._world.internal
        bodies, points = self._shapes.bodies, state.library.control_points
        return {
            int(level): bodies.at(int(level), instances[self._levels == level], points)
            for level in np.unique(self._levels)
        }

    def _cover(self) -> tuple[Any, Ints, Array]:
        """Find the pixels of all bodies; returns the coverage, hidden pixels and whole boxes."""
        n = len(self._who)
        coverage = empty_coverage(self._optics.size)
        hidden, whole = np.zeros(n, np.int64), np.full((n, 4), np.nan)
        mark = 1
        values = VALUES["fish"] + self._who
        for level, (places, opacity) in self._bodies.items():
            rows = np.flatnonzero(self._levels == level)
            triangles = self._shapes.bodies.triangles[level]
            points = carried(self._matrix, places)
            whole[rows] = whole_boxes(self._optics, points, opacity, triangles)
            near = ~np.isnan(whole[rows, 0])
            rows = rows[near]
            before, after = ((b or self._bodies)[level].places[near] for b in self._others)
            vertices = Vertices(places[near], opacity[near])
            bodies = Bodies(vertices, (before, after), triangles, values[rows])
            hidden[rows] = enter_bodies(self._seen, bodies, coverage, mark)
            mark += len(rows)
        return coverage, hidden, whole

    def _flows(self, moved: Array) -> list[Array]:
        """Optical flow (h, w, 2) to the tick before and the one after."""
        maps, (*others, now) = self._maps, self._moments
        flows = body_flow(self._seen, moved, now, self._who, others)
        unknown = np.isin(maps.kind, (SURFACE, SEAWEED, BUBBLES, HOOK)) | self._sways()
        for flow in flows:
            flow[unknown] = np.nan
        return flows

    def _sways(self) -> Bools:
        """Pixels (h, w) of corals that bend with the swell."""
        maps, reef = self._maps, self._world.internal.state.reef
        sways = np.array(
            [LOOKS[name].sway_cm > 0.0 for name in GROWTHS if name in LOOKS] or [False]
        )
        if not len(reef.kind):
            return np.zeros(maps.kind.shape, np.bool_)
        number = np.where(maps.kind == CORAL, maps.identity - VALUES["coral"], 0)
        return (maps.kind == CORAL) & sways[reef.kind][number]

    def _fishes(self, hidden: Ints, whole: Array) -> FishLabels:
        maps = self._maps
        fish = maps.kind == FISH
        number = np.where(fish, maps.identity - VALUES["fish"], 0)
        total = int(max(self._who.max(initial=0), number.max(initial=0))) + 1
        pixels = np.bincount(number[fish], minlength=total)[self._who]
        points = carried(self._matrix, self._instances[:, :3].astype(np.float64))
        distance = points[:, 2]
        shown = (pixels > 0) | ((hidden > 0) & ~np.isnan(whole[:, 0]))
        rows = np.flatnonzero(shown)
        rows = rows[np.argsort(distance[rows], kind="stable")]
        box = _boxes(number, fish, total)[self._who[rows]]
        states = self._states(rows)
        # A spine of a fin may reach a little farther than its skin.
        edges = np.concatenate(
            [
                np.fmin(whole[rows, :2], box[:, :2] - 0.5),
                np.fmax(whole[rows, 2:], box[:, :2] + box[:, 2:] - 0.5),
            ],
            axis=1,
        )
        return FishLabels(
            number=self._who[rows],
            species=self._kinds[rows],
            box=box,
            whole=np.concatenate([edges[:, :2] + 0.5, edges[:, 2:] - edges[:, :2]], axis=1),
            pixels=pixels[rows],
            share=pixels[rows] / np.maximum(pixels[rows] + hidden[rows], 1),
            distance=distance[rows],
            keypoints=states[0],
            depth=states[1],
            state=states[2],
            hidden_by=states[3],
        )

    def _states(self, rows: Ints) -> tuple[Array, Array, Ints, Ints]:
        """Keypoints of some fishes: places, depths, states and what hides them."""
        found = KeypointsIn._make(one[rows] for one in self._keypoints)
        points = carried(self._matrix, found.places)
        pixels = self._optics.project(points)
        pixels[~found.present] = np.nan
        z = np.where(found.present, points[..., 2], np.nan)
        width, height = self._optics.size
        inside = (pixels > -0.5).all(axis=-1) & (pixels < (width - 0.5, height - 0.5)).all(axis=-1)
        state = np.where(found.present, np.where(inside, VISIBLE, OUTSIDE), ABSENT)
        hidden_by = np.full(state.shape, NOTHING)
        length = self._world.internal.state.fishes.length[self._who[rows]].astype(np.float64)
        eye = np.linalg.inv(self._matrix)[:3, 3]
        away = ((found.places - eye) * found.normals).sum(axis=-1) > 0.0
        own = VALUES["fish"] + self._who[rows]
        identity, depth = self._maps.identity, self._maps.depth
        for i, k in zip(*np.nonzero(state == VISIBLE), strict=True):
            close = CLOSE_L * length[i] + CLOSE_PX * z[i, k] / self._optics.focal_px
            close += found.apart_cm[i, k] / 2
            x, y = (int(value) for value in np.rint(pixels[i, k]))
            around = slice(max(y - 1, 0), y + 2), slice(max(x - 1, 0), x + 2)
            skin = (identity[around] == own[i]) & (np.abs(depth[around] - z[i, k]) < close)
            if skin.any():
                if not (away[i, k] and NAMES[k] in FACING):
                    continue
                hidden_by[i, k] = own[i]
            elif depth[y, x] < z[i, k] - close:
                hidden_by[i, k] = identity[y, x]
            state[i, k] = HIDDEN
        return pixels, z, state, hidden_by


FACING = ("left_eye", "right_eye")  # places on a flank that the flank itself may hide


def _matrix(pose: CameraPose) -> Array:
    """The matrix (4, 4) from the world to the axes of a camera."""
    right = np.cross(pose.forward, pose.up)
    axes = np.stack([right, -np.asarray(pose.up), pose.forward]).astype(np.float64)
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = axes, -axes @ pose.eye
    return out


def _through(optics: Optics, canvas: Canvas, picture: NDArray[np.uint8], seen: IdMaps) -> _Maps:
    """See a picture and its maps, drawn on a canvas, through a lens and a port."""
    identity, depth = values_of(seen), seen.depth
    normal = seen.normals(canvas.focal_px)
    if optics.straight:
        return _Maps(picture, seen.kind, identity, depth, normal)
    place = sources(optics, canvas, depth)
    return _Maps(
        take_between(picture, place),
        take_nearest(seen.kind, place),
        take_nearest(identity, place),
        take_nearest(depth, place) + np.float32(canvas.ahead_cm),
        take_nearest(normal, place),
    )


def _boxes(number: Ints, fish: Bools, total: int) -> Array:
    """Boxes (total, 4) of the visible pixels of each fish."""
    row, column = np.nonzero(fish)
    who = number[fish]
    low, high = np.full((total, 2), np.inf), np.full((total, 2), -np.inf)
    for axis, place in enumerate((column, row)):
        np.minimum.at(low[:, axis], who, place)
        np.maximum.at(high[:, axis], who, place)
    box = np.concatenate([low, high - low + 1.0], axis=1)
    box[~np.isfinite(low[:, 0])] = np.nan
    return box
