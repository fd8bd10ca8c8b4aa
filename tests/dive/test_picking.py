"""The fish under the pointer is the one that the picture shows there."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.dive.picking import canvas_place, pick
from subsea.dive.ride import Ride, with_insets
from subsea.frame.packet import make_scene, pack
from subsea.rendering.gl.context import headless_context
from subsea.rendering.gl.id_buffer import FISH, SEABED, WATER
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.scenario.load import load_scenario
from subsea.stage.setup import set_up_theatre
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import display_rig
from subsea.view.rig import front, pose_from_angles, seen_part, views
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.daily import only

SIZE = (400, 240)
EYE = np.array([0.0, 0.0, -200.0])
# Ahead is +y. The second is half hidden by the first, the third all but hidden.
PLACES = [(0.0, 150.0, -200.0), (9.0, 190.0, -203.0), (0.0, 230.0, -200.0), (-70.0, 170.0, -170.0),
          (60.0, 120.0, -220.0), (40.0, 260.0, -190.0)]  # fmt: skip


@pytest.fixture(scope="module")
def world():
    world = create_world(load_scenario("mating")[0])
    step(world, NEUTRAL)
    fishes = world.state.fishes
    fishes.alive[len(PLACES) :] = False
    for fish, place in enumerate(PLACES):
        fishes.position[fish] = fishes.previous_position[fish] = place
        flank = np.sqrt([0.5, 0.5, 0.0, 0.0])  # upright, along +x: its side faces the eye
        fishes.orientation[fish] = fishes.previous_orientation[fish] = flank
    return world


@pytest.fixture(scope="module")
def renderer(world):
    context = headless_context()
    with context:
        made = Renderer(context, make_scene(world), display_rig("mono", SIZE), PRESETS["low"])
        yield made
        made.release()
    context.release()


def rig_of(name):
    if name in ("three-projectors", "wide"):
        return set_up_theatre(name, shrink=4).rig
    return display_rig(name, SIZE)


def drawn(renderer, world, rig, without=None, ahead=np.pi / 2):
    """The packet, and its picture on the pilot's screen (h, w, 3)."""
    renderer.arrange(rig)
    seen = views(rig, pose_from_angles(EYE, ahead, 0.0))
    if without is not None:
        seen = tuple(replace(view, without=without) for view in seen)
    packet = pack(world, seen, 1.0)
    renderer.draw(packet)
    return packet, renderer.read_pixels(front(rig).output).astype(int)


def shown(renderer, world, rig):
    """Visible pixels (k, 2), row and column, of each fish on the screen."""
    _, whole = drawn(renderer, world, rig)
    found = []
    for fish in range(len(PLACES)):
        _, lacking = drawn(renderer, world, rig, fish)
        found.append(np.argwhere(np.abs(whole - lacking).max(axis=2) > 12))
    return found


def share(rig, pixel):
    """The place on the screen ahead of an output pixel (row, column); None outside it."""
    patch = front(rig)
    left, bottom, width, height = seen_part(patch)
    row, column = pixel
    x = (column + 0.5 - left) / width
    y = 1.0 - (rig.outputs[patch.output][1] - row - 0.5 - bottom) / height
    return (x, y) if 0.0 <= x < 1.0 and 0.0 <= y < 1.0 else None


@pytest.mark.parametrize(
    "name",
    only(
        ["mono", "anaglyph", "three-projectors"],
        ["mono", "side-by-side", "anaglyph", "interlaced", "panorama", "dome", "three-projectors",
         "wide"],
    ),
)  # fmt: skip
def test_the_visible_fish_is_picked(renderer, world, name):
    rig = rig_of(name)
    pixels = shown(renderer, world, rig)
    packet, _ = drawn(renderer, world, rig)
    rng = np.random.default_rng(1)
    right = []
    for fish, own in enumerate(pixels):
        for pixel in own[rng.permutation(len(own))[:12]]:
            at = share(rig, pixel)
            if at is None:
                continue  # in the part of the other eye or of another projector
            picked = pick(renderer, packet, *at)
            if picked.kind != FISH:
                continue
            right.append((picked.number == fish, fish))
            if picked.number == fish:
                away = np.linalg.norm(picked.place - PLACES[fish])
                assert away < 0.8 * world.state.fishes.length[fish]
    # One projector of three shows only a part.
    assert {fish for found, fish in right if found} >= (
        {0, 1} if name in ("three-projectors", "wide") else {0, 1, 3, 4, 5}
    )
    # If two eyes share all pixels, the right one shows fishes elsewhere.
    assert np.mean([found for found, _ in right]) > (
        0.75 if name in ("anaglyph", "interlaced") else 0.95
    )


def test_the_front_fish_is_picked_and_none_in_open_water(renderer, world):
    packet, _ = drawn(renderer, world, display_rig("mono", SIZE))
    middle = pick(renderer, packet, 0.5, 0.5)
    assert (middle.kind, middle.number) == (FISH, 0)
    assert middle.place[1] == pytest.approx(150.0, abs=6.0)
    beside = pick(renderer, packet, 0.02, 0.1)
    assert beside.kind != FISH
    ground = pick(renderer, packet, 0.5, 0.999)
    assert ground.kind in (SEABED, WATER)
    assert np.isinf(pick(renderer, packet, 0.9, 0.3).place).all() or beside.kind != WATER


def test_a_fish_within_a_few_pixels_is_picked(renderer, world):
    rig = display_rig("mono", SIZE)
    own = shown(renderer, world, rig)[4]
    packet, _ = drawn(renderer, world, rig)
    row, column = own[np.argmax(own[:, 1])]  # its foremost pixel
    for off, met in ((2, True), (12, False)):
        picked = pick(renderer, packet, *share(rig, (row, column + off)))
        assert ((picked.kind, picked.number) == (FISH, 4)) == met


def test_picking_in_an_inset_uses_its_eye(renderer, world):
    rig, insets = with_insets(display_rig("mono", SIZE))
    picture = rig.patches[2]
    x = (picture.place[0] + picture.place[2] / 2) / SIZE[0]
    y = 1.0 - (picture.place[1] + picture.place[3] / 2) / SIZE[1]
    at = canvas_place(rig, x, y)
    np.testing.assert_allclose(at, np.array(insets[0][:2]) + np.array(insets[0][2:]) / 2)
    renderer.arrange(rig)
    ride = Ride(world, 3)
    packet = pack(world, ride.views(world, rig._replace(eyes=rig.eyes), insets, 1.0), 1.0)
    renderer.draw(packet)
    assert pick(renderer, packet, x, y).number != 3


def test_the_screen_beside_a_dome_is_dark(renderer, world):
    rig = display_rig("dome", SIZE)
    assert canvas_place(rig._replace(patches=(rig.patches[0],)), -0.5, 0.5) is None


@pytest.mark.parametrize("name", ["mono", "panorama", "dome", "three-projectors", "wide"])
def test_canvas_places_match_the_picture(renderer, name):
    rig = rig_of(name)
    renderer.arrange(rig)
    width, height = rig.canvas
    canvas = np.full((height, width, 3), 255, np.uint8)  # its places, in shares of blue
    canvas[..., 0] = np.linspace(0, 255, width)
    canvas[..., 1] = np.linspace(255, 0, height)[:, None]
    renderer.show(canvas)
    ahead = front(rig)
    picture = renderer.read_pixels(ahead.output).astype(float)
    left, bottom, across, up = seen_part(ahead)
    off = []
    for column, row in np.random.default_rng(4).uniform(0.02, 0.98, (80, 2)) * (across, up):
        there = picture[picture.shape[0] - 1 - int(bottom + row), int(left + column)]
        if there[2] < 150.0:
            continue  # lit by others
        x, y = (int(column) + 0.5) / across, 1.0 - (int(row) + 0.5) / up
        off.append(np.array(canvas_place(rig, x, y)) / rig.canvas - there[:2] / there[2])
    assert len(off) > 30
    assert np.quantile(np.abs(off), 0.9) < 0.012
