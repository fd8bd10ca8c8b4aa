"""The vessel around an observer in a headset, as its eyes see it."""

import numpy as np
import pytest

from subsea.rendering.output.vessel import clip_matrix
from subsea.stage.headset.cabin import FLOOR_CM, RADIUS_CM, RAIL_CM, Cabin, vessel
from subsea.stage.headset.head import HeadEye, Pose, head_eyes, headset_rig
from subsea.view.rig import CameraPose, views
from subsea.view.theatre_vessel import PANEL
from tests.support.headset import NOT_TURNED, turned

SIZE = 96
LIGHT = np.array([0.4, 0.5, 0.6])


def eye(orientation=NOT_TURNED):
    half = np.radians(45.0)
    head = HeadEye(Pose(np.zeros(3), orientation), -half, half, half, -half)
    return head_eyes([head], [(0, 0, SIZE, SIZE)])[0]


@pytest.fixture
def drawn(context):
    """Draw over black; returns the picture (h, w, 3), top row first."""
    cabin = Cabin(context)
    texture = context.texture((SIZE, SIZE), 4)

    def draw(which, vignette=0.0, dark=0.0, colour=0.0):
        target = cabin.eye(texture.glo, (SIZE, SIZE))
        target.clear(colour, colour, colour, 1.0)
        cabin.draw_over(target, which, LIGHT, vignette, dark)
        data = np.frombuffer(target.read(components=3), np.uint8)
        return data.reshape(SIZE, SIZE, 3)[::-1].astype(int)

    draw.cabin = cabin
    yield draw
    cabin.release()
    texture.release()


def test_its_matrix_is_that_of_the_views():
    """A point on the observer and the same point in the sea are one pixel."""
    which = eye(turned(25.0, (0.6, 0.8, 0.0)))
    rig = headset_rig([(SIZE, SIZE)], [HeadEye(Pose(np.zeros(3), NOT_TURNED), -1, 1, 1, -1)],
                      (64, 64))._replace(level=False, eyes=(which,))  # fmt: skip
    observer = CameraPose(np.array([10.0, 20.0, -30.0]), np.array([0.0, 1.0, 0.0]),
                          np.array([0.0, 0.0, 1.0]))  # fmt: skip
    (view,) = views(rig, observer)
    place = np.array([13.0, -40.0, 120.0])  # right, up, ahead
    axes = np.stack([np.cross(observer.forward, observer.up), observer.up, observer.forward])
    sea = observer.eye + place @ axes
    own = clip_matrix(which) @ [*place, 1.0]
    np.testing.assert_allclose(
        own / own[3], (both := view.projection @ view.view @ [*sea, 1.0]) / both[3], atol=1e-5
    )


def test_all_of_it_is_around_a_seated_observer():
    place = vessel()[:, :3]
    assert np.linalg.norm(place, axis=1).min() > 70.0
    assert place[:, 1].min() == pytest.approx(-FLOOR_CM)
    assert np.hypot(place[:, 0], place[:, 2]).max() < RADIUS_CM + 5.0


def test_the_rail_is_below_ahead_and_lit_from_above(drawn):
    picture = drawn(eye())
    rows = np.flatnonzero(picture[:, SIZE // 2].sum(axis=1) > 0)
    down = np.degrees(np.arctan((rows - SIZE / 2) / (SIZE / 2)))
    expected = np.degrees(np.arctan2(RAIL_CM, RADIUS_CM))
    assert abs(down.mean() - expected) < 2.0 and 1 < len(rows) < 8
    column = picture[rows, SIZE // 2].sum(axis=1)
    assert column[0] > 1.5 * column[-1]
    assert picture.max() <= 255 * LIGHT.max() + 1


def test_the_floor_is_below_and_nothing_is_straight_above(drawn):
    assert drawn(eye(turned(-80.0, (1.0, 0.0, 0.0))))[SIZE // 2, SIZE // 2].sum() > 20
    above = drawn(eye(turned(60.0, (1.0, 0.0, 0.0))))
    assert above[SIZE // 2 :, SIZE // 2].sum() == 0


def test_a_rim_and_a_shade_darken_the_sea_alone(drawn):
    plain = drawn(eye(), colour=0.8)
    rim = drawn(eye(), vignette=1.0, colour=0.8)
    assert rim[0, 0].sum() < 0.1 * plain[0, 0].sum()
    np.testing.assert_array_equal(rim[SIZE // 2, SIZE // 2], plain[SIZE // 2, SIZE // 2])
    shade = drawn(eye(), dark=1.0, colour=0.8)
    assert shade[SIZE // 2, SIZE // 2].sum() < 20
    rail = drawn(eye()).sum(axis=2) > 60
    np.testing.assert_array_equal(shade[rail], drawn(eye())[rail])


def test_the_panel_shows_its_picture_where_it_hangs(drawn):
    drawn.cabin.resize((64, 32))
    drawn.cabin.panel.clear(0.0, 0.0, 0.0, 0.0)
    drawn.cabin.panel.scissor = (0, 16, 32, 16)  # its upper left quarter
    drawn.cabin.panel.clear(1.0, 0.0, 0.0, 1.0)
    drawn.cabin.panel.scissor = None
    red = drawn(eye())[..., 0] > 200
    rows, columns = np.nonzero(red)
    (corner, middle) = PANEL.places(np.array([0.0, 0.5]), np.array([0.0, 0.5]))
    for place, across, down in ((corner, columns.min(), rows.min()),
                                (middle, columns.max() + 1, rows.max() + 1)):  # fmt: skip
        x, y = place[0] / place[2], place[1] / place[2]
        assert abs(SIZE / 2 * (1 + x) - across) < 1.6
        assert abs(SIZE / 2 * (1 - y) - down) < 1.6


def test_pictures_of_the_runtime_are_not_released_with_it(context):
    texture = context.texture((8, 8), 4)
    cabin = Cabin(context)
    cabin.eye(texture.glo, (8, 8)).clear(1.0, 1.0, 1.0, 1.0)
    cabin.release()
    assert set(texture.read()) == {255}
    texture.release()
