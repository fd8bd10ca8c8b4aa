"""Vision, against closed forms for angles and distances and against sampled rays."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.rotation import matrix
from subsea.geometry.solids import height_at
from subsea.perception.vision import (
    BODY_SHARES,
    along_body,
    eye_of,
    hidden,
    in_view,
    sees_box,
    sees_fish,
    sees_pillar,
    sees_point,
    sight,
)

AHEAD = (1.0, 0.0, 0.0)


def _view(t):
    """Bodies and surroundings of a tank, as vision reads them."""
    return t.fishes, t.sea


def _sees(t, i, j):
    bodies, scene = _view(t)
    return sees_fish(bodies, i, j, scene, t.nature)


def _hides(t, share):
    """True if a point of fish 1 is hidden from fish 0."""
    bodies, scene = _view(t)
    return hidden(scene, eye_of(bodies, 0), along_body(bodies, 1, share))


@pytest.mark.parametrize(
    ("angle", "seen"), [(0, True), (90, True), (149.9, True), (150.1, False), (180, False)]
)
def test_the_field_of_view_is_300_degrees_around(angle, seen):
    for around in np.linspace(0, 2 * np.pi, 7):
        a = np.radians(angle)
        p = 50.0 * np.array([np.cos(a), np.sin(a) * np.cos(around), np.sin(a) * np.sin(around)])
        assert in_view((0.0, 0.0, 0.0), AHEAD, tuple(p), 51.0) == seen
        assert not in_view((0.0, 0.0, 0.0), AHEAD, tuple(p), 49.0)


def test_the_centre_line_goes_from_the_eye_to_the_tail(tank):
    t = tank()
    t.fishes.orientation[0] = np.array([0.5, 0.5, 0.5, 0.5])  # upright, heading along y
    assert eye_of(t.fishes, 0) == pytest.approx((0.0, 7.0, -300.0), abs=1e-5)
    assert along_body(t.fishes, 0, 1.0) == pytest.approx((0.0, -13.0, -300.0), abs=1e-5)
    x = matrix(t.fishes.orientation[0].astype(float))[:, 0]
    np.testing.assert_allclose(x, [0, 1, 0], atol=1e-6)


def test_a_large_fish_is_seen_from_farther(tank):
    t = tank(2)
    assert sight(20.0, t.nature) == t.nature.vision_cm
    assert sight(500.0, t.nature) == 3.0 * t.nature.vision_cm
    for length, seen in ((20.0, False), (40.0, True)):
        t.fishes.length[1] = length
        t.fishes.position[1] = 7.0 + 1.5 * t.nature.vision_cm, 0.0, -300.0
        assert _sees(t, 0, 1) == seen


def _scene(tank, seed):
    """Random solids over a random seabed, and two fishes in free water."""
    rng = np.random.default_rng(seed)
    t = tank(
        2,
        pillars=np.column_stack(
            [rng.uniform(-150, 150, (3, 2)), rng.uniform(10, 40, 3), rng.uniform(-350, -200, 3)]
        ),
        rocks=np.column_stack(
            [rng.uniform(-150, 150, (3, 2)), rng.uniform(-380, -250, 3),
             rng.uniform(10, 60, (3, 3)), rng.uniform(0, 6, 3)]
        ),
    )  # fmt: skip
    heights = rng.uniform(-400, -260, (9, 9)).astype(np.float32)
    t = t._replace(sea=t.sea._replace(heights=heights, half_width=200.0))
    t.fishes.position[:] = rng.uniform((-150, -150, -330), (150, 150, -230), (2, 3))
    turn = rng.normal(size=(2, 4))
    t.fishes.orientation[:] = turn / np.linalg.norm(turn, axis=1)[:, None]
    return t


def _depth(sea, p):
    """Depth of each point (n, 3) in any solid, relative to the solid; above 0 inside."""
    deep = np.array([height_at(sea.heights, sea.half_width, x, y) - z for x, y, z in p]) / 100
    for x, y, radius, top in sea.pillars:
        side = radius - np.hypot(p[:, 0] - x, p[:, 1] - y)
        deep = np.maximum(deep, np.minimum(side, top - p[:, 2]) / 100)
    for x, y, z, a, b, c, yaw in sea.rocks:
        u, v, w = (p - (x, y, z)).T
        along, across = np.cos(yaw) * u + np.sin(yaw) * v, np.cos(yaw) * v - np.sin(yaw) * u
        deep = np.maximum(deep, 1 - (along / a) ** 2 - (across / b) ** 2 - (w / c) ** 2)
    return deep


def _is_hidden(sea, eye, p):
    """True if any sampled point of the ray is inside, by brute force; None if that is close."""
    eye, p = np.array(eye), np.array(p)
    most = _depth(sea, eye + np.linspace(0, 1, 1500)[:, None] * (p - eye)).max()
    return None if abs(most) < 2e-3 else most > 0


@given(st.integers(0, 2**32 - 1))
def test_occlusion_of_points_and_fishes_against_brute_force(tank, seed):
    t = _scene(tank, seed)
    bodies, scene = _view(t)
    eye, x = eye_of(bodies, 0), matrix(t.fishes.orientation[0].astype(float))[:, 0]

    def in_field(p):
        ray = np.subtract(p, eye)
        return x @ ray > np.cos(np.radians(150)) * np.linalg.norm(ray)

    verdicts = []
    for share in BODY_SHARES:
        p = along_body(bodies, 1, share)
        verdict = _is_hidden(scene, eye, p)
        verdicts.append(verdict)
        if verdict is not None:
            assert hidden(scene, eye, p) == verdict
            seen = sees_point(bodies, 0, scene, tuple(map(float, p)), 1e3)
            assert seen == (in_field(p) and not verdict)
    if None not in verdicts:
        assert _sees(t, 0, 1) == (in_field(t.fishes.position[1]) and not all(verdicts))


def test_random_scenes_hide_some_and_not_others(tank):
    assert 10 < sum(_hides(_scene(tank, seed), 0.0) for seed in range(60)) < 50


def test_a_fish_is_seen_by_any_part_of_it(tank):
    """A pillar hides all but the tail (Tu fig. 6.6)."""
    t = tank(2, pillars=[(60.0, 20.0, 20.0, -100.0)])
    t.fishes.length[1], t.fishes.snout[1] = 100.0, 35.0
    t.fishes.orientation[1] = 0.5, 0.5, 0.5, 0.5  # heading along y
    t.fishes.position[1] = 100.0, 40.0, -300.0
    assert _hides(t, 0.3)
    assert _sees(t, 0, 1)
    t.fishes.length[1], t.fishes.snout[1] = 30.0, 10.0
    t.fishes.position[1] = 100.0, 20.0, -300.0
    assert not _sees(t, 0, 1)


def test_fishes_hide_nobody(tank):
    t = tank(3)
    t.fishes.position[1:] = (40.0, 0.0, -300.0), (90.0, 0.0, -300.0)
    t.fishes.length[1] = 150.0
    assert _sees(t, 0, 2)


def test_a_pillar_is_seen_by_its_nearest_side(tank):
    reach = tank().nature.vision_cm
    for x, seen in ((7.0 + reach + 29.0, True), (7.0 + reach + 31.0, False)):
        t = tank(pillars=[(x, 0.0, 30.0, -100.0)])
        assert sees_pillar(t.fishes, 0, t.sea.pillars[0], t.nature) == seen
    # For a pillar that is lower than the eye: its top.
    t = tank(pillars=[(7.0, 0.0, 30.0, -300.0 - reach - 31.0)])
    assert not sees_pillar(t.fishes, 0, t.sea.pillars[0], t.nature)


def test_a_box_is_seen_by_any_corner(tank):
    t = tank(pillars=[(100.0, 0.0, 40.0, -320.0)])
    box = np.array([200.0, -10.0, -500.0, 220.0, 10.0, -400.0], np.float32)

    def seen():
        return sees_box(t.fishes, 0, t.sea, box, t.nature.vision_cm)

    assert not seen()
    box[4] = 200.0  # reaches out from behind the pillar
    assert seen()
    box[:] = -120.0, -10.0, -310.0, -100.0, 10.0, -290.0  # astern
    assert not seen()
