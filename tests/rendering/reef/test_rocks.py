"""Drawn pillars and rocks: visible in every display, free of cost out of sight."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.frame.packet import BITE_CM
from subsea.rendering.gl.id_buffer import KINDS
from subsea.rendering.reef.rocks import SKY, overgrown
from subsea.state import Reef

PILLARS = np.array([(-45.0, 190.0, 38.0, -150.0)])
ROCKS = np.array([(60.0, 150.0, -285.0, 40.0, 30.0, 28.0, 0.5), (20.0, 200, -290, 26, 32, 20, 2)])


def test_stone_is_darker_where_corals_grow_on_it():
    sand = np.full((2, 2), -300.0, np.float32), 900.0
    one = Reef(
        kind=np.zeros(1, np.uint8),
        place=np.array([[60.0, 150.0, -258.0]], np.float32),
        axis=np.array([[0.0, 0.0, 1.0]], np.float32),
        turn=np.zeros(1, np.float32),
        radius=np.full(1, 15.0, np.float32),
        own=np.zeros(1, np.float32),
        light=np.ones(1, np.float32),
        hue=np.zeros(1, np.float32),
        on_rock=np.ones(1, np.bool_),
    )
    bare, grown = (
        np.concatenate([
            levels[0].vertices for levels in overgrown(*sand, PILLARS[:0], ROCKS[:1], 12.0, reef)
        ])
        for reef in (one.taken(slice(0)), one)
    )  # fmt: skip
    away = np.linalg.norm(bare[:, :3] - one.place[0], axis=1)
    share = grown[:, SKY] / np.maximum(bare[:, SKY], 1e-6)
    assert share[away < 8.0].max() < 0.6
    np.testing.assert_array_equal(share[away > 40.0], 1.0)
    np.testing.assert_array_equal(grown[:, :6], bare[:, :6])


@pytest.fixture(scope="module")
def stony(scene):
    return replace(scene, pillars=PILLARS, rocks=ROCKS)


def test_a_pillar_and_rocks(drawn, stony, make_packet, fish, same_picture):
    packet = make_packet([fish(1, (10, 110, -225), level=0)], eye=(0, 0, -215), pitch=-0.1)
    same_picture("solids", drawn(packet, scene=stony))


@pytest.mark.parametrize("display", ["side-by-side", "panorama"])
def test_they_stand_in_every_view(drawn, stony, make_packet, display):
    packet = make_packet([], display=display, eye=(0, 0, -215))
    bare, full = drawn(packet, display=display), drawn(packet, display=display, scene=stony)
    changed = np.abs(bare - full).max(axis=2) > 12
    assert changed.mean() > 0.02
    if display == "side-by-side":
        assert changed[:, :160].mean() == pytest.approx(changed[:, 160:].mean(), rel=0.3)


def test_they_are_where_the_fishes_think_they_are(drawn, stony, make_packet):
    """Expected width of a pillar 76 cm wide and 190 cm ahead, left of the middle."""
    packet = make_packet([], eye=(0, 0, -215))
    bare, full = drawn(packet), drawn(packet, scene=stony)
    row = np.flatnonzero(np.abs(bare - full).max(axis=2)[80] > 12)
    scale = 90.0 / np.tan(np.radians(27.5))
    left, right = (160 + scale * x / 190.0 for x in (-45.0 - 38.0, -45.0 + 38.0))
    # The drawn stack is worn: it stays inside what fishes avoid, in places half as wide.
    assert left - 2 <= row.min() < left + 20
    assert right - 20 < row.max() <= right + 2


def test_stone_out_of_sight_costs_nothing(counted, stony, make_packet):
    ahead, behind = (make_packet([], eye=(0, 0, -215), heading=h) for h in (1.57, -1.57))
    added = [counted(p, scene=stony)[1] - counted(p)[1] for p in (ahead, behind)]
    assert added[0] > 500
    assert added[1] == 0


def test_far_ones_are_coarser(counted, stony, make_packet):
    size = (960, 540)
    near, far = (make_packet([], eye=(0, y, -215), size=size) for y in (0.0, -600.0))
    added = [counted(p, scene=stony)[1] - counted(p)[1] for p in (near, far)]
    assert added[1] < 0.7 * added[0]


def test_a_bite_shows_on_the_stone_that_it_is_on_for_one_more_call(
    make_renderer, stony, make_packet
):
    packet, renderer = make_packet([], eye=(0, 0, -215)), make_renderer(scene=stony)
    renderer.draw(packet)  # the first picture draws the map of the sun, too
    maps = renderer.id_maps(packet)
    row = 80
    column = int(np.flatnonzero(maps.kind[row] == KINDS.index("pillar")).mean())
    view, depth = packet.views[0], maps.depth[row, column]
    across = 2.0 * (column + 0.5) / 320.0 - 1.0, 1.0 - 2.0 * (row + 0.5) / 180.0
    aside = depth * np.array(across) / np.diag(view.projection)[:2]
    place = np.linalg.inv(view.view.astype(float)) @ np.array([*aside, -depth, 1.0])
    found = []
    for bites in ([], [(0.0, 80.0, -215.0, 1.0)], [(*place[:3], 1.0)]):
        renderer.draw(replace(packet, bites=np.array(bites, np.float32).reshape(-1, 4)))
        found.append((renderer.read_pixels().astype(int), renderer.draw_calls))
    (bare, calls), (beside, as_many), (bitten, more) = found
    np.testing.assert_array_equal(beside, bare)
    assert (as_many, more) == (calls, calls + 1)
    rows, columns = np.nonzero(np.abs(bitten - bare).max(axis=2) > 1)
    assert len(rows) > 20
    reach = 90.0 * view.projection[1, 1] * BITE_CM / depth
    assert (np.hypot(rows - row, columns - column) < 1.5 * reach).all()
