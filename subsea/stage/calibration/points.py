"""Reference points: places of the screen that a technician measured and found in a photograph."""

from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.toml_files import error_at, load_toml
from subsea.stage.calibration.optics import ReferencePoint
from subsea.stage.calibration.surface import LitSurface, within
from subsea.stage.theatre.theatre_file import Angle, Point

FEWEST_POINTS = 4
Pixel = Annotated[float, msgspec.Meta(ge=0, le=1e5)]


class MarkedPoint(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table [[point]]: where it is in the room, and in the photographs."""

    name: str = ""
    at_cm: Point | None = None  # as the theatre file counts
    # azimuth to the right and elevation, as the best seat sees it
    direction_deg: tuple[Angle, Angle] | None = None
    pixel: tuple[Pixel, Pixel] | None = None  # from the upper left corner; None: not in them

    def __post_init__(self) -> None:
        """Require one of the two places."""
        if (self.at_cm is None) == (self.direction_deg is None):
            raise ValueError("expected one of `at_cm` and `direction_deg`")


class PointsFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The points of one camera."""

    point: list[MarkedPoint]


def read_points(path: Path, eye_cm: Array, surfaces: list[LitSurface]) -> list[ReferencePoint]:
    """Read the points that have a pixel; else a UserError.

    A direction becomes the point of the screen that the eye sees there.
    """
    if not path.is_file():
        raise UserError(
            "no such file; expected the reference points of these photographs "
            "(`subsea theatre FILE --patterns DIR` writes a points.toml to fill in)",
            file=path,
        )
    points = []
    for k, marked in enumerate(load_toml(path, PointsFile).point):
        if marked.pixel is None:
            continue
        if marked.at_cm is not None:
            at = np.array(marked.at_cm) - eye_cm
        else:
            assert marked.direction_deg is not None
            ray = direction(*marked.direction_deg)
            found = _seen_along(ray, surfaces)
            if found is None:
                raise error_at(path, f"point[{k}]", "no screen lies in this `direction_deg`")
            at = found
        points.append(ReferencePoint(marked.name or f"point {k + 1}", at, marked.pixel))
    if len(points) < FEWEST_POINTS:
        raise UserError(
            f"{len(points)} points with a `pixel`, expected {FEWEST_POINTS} or more", file=path
        )
    return points


def direction(azimuth_deg: float, elevation_deg: float) -> Array:
    """The direction (3,) of an azimuth to the right and an elevation."""
    turn, rise = np.radians([azimuth_deg, elevation_deg])
    return np.array([np.sin(turn) * np.cos(rise), np.sin(rise), np.cos(turn) * np.cos(rise)])


def points_template(eye_cm: Array, surfaces: list[LitSurface]) -> str:
    """The text of a file of points to fill in: the corners and middles of all screens."""
    lines = [
        "# Reference points for `subsea theatre FILE --calibrate`, one file beside the photographs",
        "# of each camera. Measure each point on the screen as exactly as you can, and mark it.",
        "# Enter where it is in the photographs: pixels from the upper left corner. Leave out what",
        "# the camera does not see, add others: 4 are enough, 8 or more far apart are better.",
    ]
    given: list[Array] = []
    for surface in surfaces:
        for name, place in (
            ("lower left", (0.0, 0.0)), ("lower right", (1.0, 0.0)), ("upper right", (1.0, 1.0)),
            ("upper left", (0.0, 1.0)), ("middle", (0.5, 0.5)),
        ):  # fmt: skip
            at = surface.points(np.array([place]))[0]
            if any(np.linalg.norm(at - other) < 1.0 for other in given):
                continue
            given.append(at)
            lines += ["", "[[point]]", f'name = "{name}"']
            if surface.radius is not None:
                turn = np.degrees(np.arctan2(at[0], at[2]))
                rise = np.degrees(np.arcsin(at[1] / np.linalg.norm(at)))
                lines += [f"direction_deg = [{turn:.2f}, {rise:.2f}]"]
            else:
                lines += [f"at_cm = [{', '.join(f'{x:.1f}' for x in at + eye_cm)}]"]
            lines += ["# pixel = [x, y]"]
    return "\n".join(lines) + "\n"


def _seen_along(ray: Array, surfaces: list[LitSurface]) -> Array | None:
    """The point (3,) of a screen that the eye sees along a ray; None: there is none."""
    for surface in surfaces:
        if within(surface.places(ray[None]), 0.05)[0]:
            return surface.meet(np.zeros(3), ray[None])[0]
    return None
