"""The picture beside a headset: steady, level and exact."""

import numpy as np
import pytest

from subsea.dive.picking import canvas_place
from subsea.stage.headset.head import (
    STEADY_S,
    HeadEye,
    Pose,
    head_eyes,
    headset_rig,
    mirror_of,
    mirror_patch,
    mirror_view,
)
from subsea.view.rig import pose_from_angles, views
from tests.support.headset import DOWN, IN, NOT_TURNED, OUT, UP, turned

SIZE = (160, 90)
OBSERVER = pose_from_angles(np.array([50.0, -70.0, -300.0]), 0.9, 0.0)


def eye(orientation=NOT_TURNED):
    head = HeadEye(Pose(np.array([0.1, 0.05, -0.2]), orientation), -OUT, IN, UP, -DOWN)
    return head_eyes([head], [(0, 0, 400, 420)])[0]


def ahead(mirror):
    return np.degrees(np.arctan2(mirror.axes[2, 0], mirror.axes[2, 2]))


def test_it_follows_a_turned_head_smoothly():
    mirror = mirror_of(eye(), SIZE, None, 0.0)
    assert ahead(mirror) == pytest.approx(0.0, abs=1e-9)
    aside = eye(turned(-20.0, (0.0, 1.0, 0.0)))  # to the right
    soon = mirror_of(aside, SIZE, mirror, 0.05)
    assert 1.0 < ahead(soon) < 5.0
    late = soon
    for _ in range(40):
        late = mirror_of(aside, SIZE, late, 0.05)
    assert ahead(late) == pytest.approx(20.0, abs=0.1)
    half = mirror_of(aside, SIZE, mirror, STEADY_S * np.log(2.0))
    assert ahead(half) == pytest.approx(10.0, abs=0.3)


def test_its_horizon_is_level_when_the_head_tilts():
    mirror = mirror_of(eye(turned(35.0, (0.0, 0.0, 1.0))), SIZE, None, 0.0)
    np.testing.assert_allclose(mirror.axes, np.eye(3), atol=1e-9)


@pytest.mark.parametrize("degrees", [0.0, 12.0, -9.0])
def test_the_window_shows_what_a_camera_there_would_see(degrees):
    """A point of the sea is at the pixel of the eye's picture that the window shows for it."""
    looking = eye(turned(degrees, (0.6, 0.8, 0.0)))
    straight = mirror_of(eye(), SIZE, None, 0.0)  # it has not followed yet
    base = headset_rig([(400, 420)], [HeadEye(Pose(np.zeros(3), NOT_TURNED), -1, 1, 1, -1)], SIZE)
    patch = mirror_patch(straight, looking, SIZE)
    rig = base._replace(eyes=(looking,), patches=(patch, *base.patches[1:]))
    (seen,) = views(rig, OBSERVER)
    camera = mirror_view(straight, looking, OBSERVER, SIZE)
    for x, y in ((0.5, 0.5), (0.3, 0.7), (0.65, 0.2)):
        p = camera.projection.astype(float)
        way = np.array([(2 * x - 1) / p[0, 0], (1 - 2 * y) / p[1, 1], -1.0])
        point = camera.eye + 250.0 * (way @ camera.view[:3, :3])
        clip = seen.projection.astype(float) @ seen.view.astype(float) @ [*point, 1.0]
        pixel = (0.5 + 0.5 * clip[:2] / clip[3]) * seen.viewport[2:]
        np.testing.assert_allclose(canvas_place(rig, x, y), pixel, atol=0.6)


def test_straight_up_it_is_the_eyes_own_picture():
    up = eye(turned(90.0, (1.0, 0.0, 0.0)))
    np.testing.assert_allclose(mirror_of(up, SIZE, None, 0.0).axes, up.axes, atol=1e-9)
