"""A small room with a flat wall and two projectors, photographed once."""

from types import SimpleNamespace

import numpy as np
import pytest

from subsea.stage.calibration.optics import ORDINARY
from tests.support.lit_room import look, planned_room, write_points

WALL_POINTS = [(x, y, 400.0) for x in (-290, -100, 100, 290) for y in (-80, 85)]


@pytest.fixture(scope="session")
def wall(tmp_path_factory):
    """The theatre file, the room, the camera and the folder of photographs."""
    folder = tmp_path_factory.mktemp("wall")
    path, room = planned_room("wall", (160, 96), folder, projectors=2, width=600, distance=400)
    gains = (1.0, 1.0, 1.0), (0.7, 0.8, 0.75)
    room.lamps = [
        lamp.turned((0, 0, 0), gain=gain, black=black, gamma=gamma)
        for lamp, gain, black, gamma in zip(
            room.lamps, gains, (0.004, 0.006), (2.2, 2.4), strict=True
        )
    ]
    camera = look((60, 30, -100), (0, 0, 400), (420, 240), ORDINARY, 290, (-0.1, 0.02), (3, -2))
    photographs = folder / "photographs"
    paths = room.photograph(camera, photographs)
    write_points(photographs / "points.toml", camera, WALL_POINTS)
    return SimpleNamespace(path=path, room=room, camera=camera, folder=photographs, paths=paths)


@pytest.fixture
def grid():
    """Pixels (n, 2) all over a picture of a size, within a share of its edge."""

    def grid(size, count=15, edge=0.02):
        x, y = (np.linspace(edge * side, (1 - edge) * side, count) for side in size)
        return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)

    return grid
