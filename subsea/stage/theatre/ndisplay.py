"""Read nDisplay configurations of Unreal Engine, ``.ndisplay``.

JSON: ``nDisplay.scene`` has ``xforms``, ``cameras`` and ``screens``, each with the ``parentId`` of
another and its place on it; ``nDisplay.cluster.nodes`` the computers with a window and viewports,
each with a camera, a region in pixels from the upper left corner and a projection policy. Lengths
are centimetres, x ahead, y right, z up, left-handed; yaw to the right, pitch up, roll clockwise.
(Unreal Engine: nDisplay Configuration File Reference; DisplayClusterConfigurationJsonTypes_500.h.)
"""

from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.validation import convert
from subsea.stage.theatre.imported import HERE, ImportedTheatre, TheatreBuilder
from subsea.stage.theatre.theatre_file import MAIN, Coordinate, Window
from subsea.view.camera import axes_of

MAX_DEPTH = 64  # of parents
QUIET = frozenset({"version", "assetPath", "customParameters", "diagnostics", "sync", "network"})
Angle = Annotated[float, msgspec.Meta(ge=-3600, le=3600)]


class NdisplayPoint(msgspec.Struct, frozen=True):
    """A place on its parent."""

    x: Coordinate = 0.0
    y: Coordinate = 0.0
    z: Coordinate = 0.0


class NdisplayTurn(msgspec.Struct, frozen=True):
    """A turn on its parent."""

    pitch: Angle = 0.0
    yaw: Angle = 0.0
    roll: Angle = 0.0


class NdisplayExtent(msgspec.Struct, frozen=True):
    """The size of a screen."""

    width: Coordinate
    height: Coordinate


class NdisplayPart(msgspec.Struct, frozen=True, rename={"parent": "parentId", "eyes_cm":
                   "interpupillaryDistance", "eye": "stereoOffset"}):  # fmt: skip
    """A transform, camera or screen of the scene."""

    parent: str = ""
    location: NdisplayPoint = NdisplayPoint()
    rotation: NdisplayTurn = NdisplayTurn()
    size: NdisplayExtent | None = None  # of a screen
    eyes_cm: float | None = None  # of a camera
    eye: str = "none"


class NdisplayScene(msgspec.Struct, frozen=True):
    """The parts of the scene by name."""

    xforms: dict[str, NdisplayPart] = {}
    cameras: dict[str, NdisplayPart] = {}
    screens: dict[str, NdisplayPart] = {}


class NdisplayRect(msgspec.Struct, frozen=True):
    """Pixels from the upper left."""

    x: Coordinate = 0.0
    y: Coordinate = 0.0
    w: Coordinate = 0.0
    h: Coordinate = 0.0


class NdisplayPolicy(msgspec.Struct, frozen=True):
    """A projection policy."""

    type: str
    parameters: dict[str, Any] = {}


class NdisplayViewport(msgspec.Struct, frozen=True, rename={"policy": "projectionPolicy"}):
    """A part of a window."""

    region: NdisplayRect
    policy: NdisplayPolicy
    camera: str = ""


class NdisplayNode(msgspec.Struct, frozen=True, rename={"full": "fullScreen"}):
    """A computer, or a program on it."""

    host: str = ""
    window: NdisplayRect = NdisplayRect()
    full: bool = False
    viewports: dict[str, NdisplayViewport] = {}


class NdisplayCluster(msgspec.Struct, frozen=True, rename={"primary": "primaryNode",
                      "master": "masterNode"}):  # fmt: skip
    """The nodes by name."""

    nodes: dict[str, NdisplayNode]
    primary: dict[str, str] | None = None  # with the `id` of the first node
    master: dict[str, str] | None = None  # as `primary` was called until version 4.27


class NdisplayConfig(msgspec.Struct, frozen=True):
    """A configuration."""

    scene: NdisplayScene
    cluster: NdisplayCluster
    description: str = ""


def read_ndisplay(path: Path, content: Any) -> ImportedTheatre:
    """Build the theatre of a configuration's content; a UserError if nothing can be shown."""
    try:
        config = convert(content, NdisplayConfig)
    except UserError as fault:
        raise UserError(fault.message, file=path, key=fault.key) from fault
    reader = _NdisplayReader(path, config)
    reader.builder.leave_out_keys(content, NdisplayConfig, QUIET)
    return reader.theatre()


class _NdisplayReader:
    """Collects the theatre of a configuration."""

    def __init__(self, path: Path, config: NdisplayConfig) -> None:
        self.config, self.nodes = config, config.cluster.nodes
        self.builder = TheatreBuilder(path, config.description or path.stem)
        scene = config.scene
        self.parts = {**scene.xforms, **scene.cameras, **scene.screens}
        used = Counter(
            viewport.camera for node in self.nodes.values() for viewport in node.viewports.values()
        )
        eyes: dict[str, Array] = {}
        for name in scene.cameras:
            with suppress(UserError):
                eyes[name] = self._pose(name)[1]
        screens = []
        for name in scene.screens:
            with suppress(UserError):
                screens.append(self._pose(name))

        def seen(name: str) -> int:
            """The number of screens that a camera has before it."""
            return sum(bool((at - eyes[name]) @ turn[2] > 1.0) for turn, at in screens)

        self.camera = max(eyes, key=lambda name: (seen(name), used[name]), default="")
        self.eye = eyes.get(self.camera, np.zeros(3))
        self.names: dict[str, str] = {}

    def theatre(self) -> ImportedTheatre:
        """Build the theatre of all nodes."""
        camera = self.config.scene.cameras.get(self.camera)
        self.builder.keys = {"eye_cm": tuple(_rounded(self.eye))}
        if camera is not None and camera.eyes_cm is not None and 0 <= camera.eyes_cm <= 20:
            self.builder.keys["eye_distance_cm"] = round(camera.eyes_cm, 3)
        self.builder.leave_out(
            "tracking, which this format does not hold: the eye stays at camera "
            f"{self.camera!r}, from which most screens are seen"
        )
        for name, node in self.nodes.items():
            self._node(name, node)
        nodes = [window.node for window in self.builder.windows]
        if len(set(nodes)) > 1:
            cluster = self.config.cluster
            first = (cluster.primary or cluster.master or {}).get("id", "")
            host = self.nodes[first].host if first in self.nodes else HERE
            self.builder.lead(self.names.get(first, nodes[0]), host)
        return self.builder.build()

    def _node(self, name: str, node: NdisplayNode) -> None:
        """Add the window of a node and its viewports."""
        regions = [viewport.region for viewport in node.viewports.values()]
        size = [round(node.window.w), round(node.window.h)]
        if min(size) < 1 and regions:  # a full screen of its monitor's size
            size = [round(max(region.x + region.w for region in regions)),
                    round(max(region.y + region.h for region in regions))]  # fmt: skip
        computer = self.builder.name(name, "node") if len(self.nodes) > 1 else MAIN
        keys: dict[str, Any] = {"size": tuple(size), "node": computer}
        if node.full:
            keys["monitor"] = 1
        else:
            keys["position"] = (round(node.window.x), round(node.window.y))
        window = self.builder.window(name, **keys)
        if window is None:
            return
        self.names[name] = window.node
        left_out: set[str] = set()
        for words, viewport in node.viewports.items():
            if words in left_out:
                continue
            other = self._other_eye(words, node)
            if other is not None:
                left_out.add(other)
                self.builder.leave_out(
                    f"viewport {other!r}: its place is that of the other eye, so "
                    f"{words!r} is for both; start with a stereo --display"
                )
                viewport = msgspec.structs.replace(viewport, camera=self.camera)
            try:
                self._viewport(words, viewport, window)
            except UserError as fault:
                self.builder.refuse(f"viewport {words!r} of {name!r}: {fault}")

    def _viewport(self, words: str, viewport: NdisplayViewport, window: Window) -> None:
        if viewport.policy.type.lower() != "simple":
            raise UserError(f"projection policy {viewport.policy.type!r}, expected 'simple'")
        given = viewport.policy.parameters
        named = str(given.get("screen", given.get("screen_id")))
        screen = self.config.scene.screens.get(named)
        if screen is None or screen.size is None:
            raise UserError(f"screen {named!r} is not there")
        turn, middle = self._pose(named)
        half = np.array([[-1, -1], [1, -1], [-1, 1]]) / 2 * [screen.size.width, screen.size.height]
        corners = middle + half[:, :1] * turn[0] + half[:, 1:] * turn[1]
        names = ("lower_left", "lower_right", "upper_left")
        plane = {key: _rounded(corner) for key, corner in zip(names, corners, strict=True)}
        keys: dict[str, Any] = {"plane": plane}
        if (eye := self._side(viewport.camera or self.camera)) is not None:
            keys["eye"] = eye
        region = viewport.region
        rect = (round(region.x), round(region.y), round(region.w), round(region.h))
        if rect != (0, 0, *window.size):
            keys["viewport"] = rect
        self.builder.channel(words, window, **keys)

    def _side(self, camera: str) -> str | None:
        """The eye that a camera is for, "left" or "right"."""
        part = self.config.scene.cameras.get(camera)
        return part.eye if part is not None and part.eye in ("left", "right") else None

    def _other_eye(self, words: str, node: NdisplayNode) -> str | None:
        """The viewport that shows the same screen at the same place to the other eye."""
        viewport = node.viewports[words]
        for name, other in node.viewports.items():
            if (
                {self._side(viewport.camera), self._side(other.camera)} == {"left", "right"}
                and other.region == viewport.region
                and other.policy.parameters == viewport.policy.parameters
            ):
                return name
        return None

    def _pose(self, name: str) -> tuple[Array, Array]:
        """Axes right, up, ahead (3, 3) of a part, and its place (3,), both in our axes."""
        turn, place = np.eye(3), np.zeros(3)
        for _ in range(MAX_DEPTH):
            part = self.parts.get(name)
            if part is None:
                if name:
                    raise UserError(f"parent {name!r} is not there")
                return turn, place
            axes = axes_of(
                *np.radians([part.rotation.yaw, part.rotation.pitch, part.rotation.roll])
            )
            at = part.location
            place = np.array([at.y, at.z, at.x]) + place @ axes
            turn = turn @ axes
            name = part.parent
        raise UserError(f"more than {MAX_DEPTH} parents, or a circle of them")


def _rounded(point: Array) -> list[float]:
    return [round(float(x), 4) + 0.0 for x in point]
