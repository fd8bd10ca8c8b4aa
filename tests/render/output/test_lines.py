"""Lines over the sea: look, occlusion, and every kind of picture."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.dive.start import start_world
from subsea.frame.diagrams import DIAGRAMS, DiagramBuilder
from subsea.frame.lines import Lines
from subsea.frame.packet import make_scene, pack
from subsea.render import Renderer
from subsea.submarine.helm import HANDS_OFF
from subsea.view.display_rigs import cockpit, display_rig
from subsea.view.rig import pose_from_angles, views
from subsea.world.step import step

SIZE = (320, 180)
EYE = np.array([0.0, 0.0, -200.0])


@pytest.fixture(scope="module")
def renderer(context, scene):
    renderer = Renderer(context, scene, display_rig("mono", SIZE))
    yield renderer
    renderer.release()


def drawn(renderer, packet, *lines, lift=0.0):
    """The picture, as whole numbers, with lines of (from, to, colour)."""
    if lines:
        ends = np.array([(a, b) for a, b, _ in lines], np.float32)
        colours = np.array([[*colour, 1.0][:4] for _, _, colour in lines], np.float32)
        lifts = np.full(len(lines), lift, np.float32)
        packet = replace(packet, lines=Lines(ends, colours, lifts))
    renderer.draw(packet)
    return renderer.read_pixels().astype(int)


@pytest.mark.parametrize(
    "colour", [(0.95, 0.30, 0.20), (0.35, 0.90, 0.30), (0.2, 0.2, 0.2), (0.95, 0.90, 0.72)]
)
def test_a_line_has_its_colour_whatever_lies_behind(renderer, make_packet, colour):
    packet = make_packet([])
    a, b = (-40, 100, -200.2), (40, 100, -200.2)
    picture = drawn(renderer, packet, (a, b, colour))
    bare = drawn(renderer, packet)
    changed = np.abs(picture - bare).max(axis=2) > 6
    rows, columns = np.nonzero(changed)
    assert np.ptp(rows) <= 3  # thin
    # 80 cm seen from 100 cm.
    assert np.ptp(columns) == pytest.approx(0.8 * 90 / np.tan(np.radians(27.5)), abs=4)
    nearest = np.abs(picture[changed] - 255 * np.array(colour)).max(axis=1).min()
    assert nearest <= 8


def test_a_faint_line_is_about_its_share_of_what_it_would_be(renderer, make_packet):
    packet = make_packet([])
    a, b, colour = (-40, 100, -201), (40, 100, -201), np.array([0.95, 0.80, 0.30])
    bare = drawn(renderer, packet)
    full = drawn(renderer, packet, (a, b, colour))
    faint = drawn(renderer, packet, (a, b, (*colour, 0.35)))
    place = np.unravel_index(np.abs(full - bare).sum(axis=2).argmax(), bare.shape[:2])
    between = 255 * (0.35 * (full[place] / 255) ** 2.2 + 0.65 * (bare[place] / 255) ** 2.2) ** 0.45
    assert np.abs(faint[place] - between).max() < 30
    assert (faint[place][0] > faint[place][2]) == (colour[0] > colour[2])


def test_fishes_hide_what_is_behind_them_and_show_what_is_within(renderer, make_packet, fish):
    packet = make_packet([fish(0, (0, 60, -200), level=0)])
    red = (0.95, 0.1, 0.1)
    bare = drawn(renderer, packet)
    hole = (slice(86, 95), slice(150, 170))  # the fish's middle

    def shows(y, lift=0.0):
        picture = drawn(renderer, packet, ((-60, y, -200.4), (60, y, -200.4), red), lift=lift)
        assert np.abs(picture - bare).max() > 40
        return np.abs(picture - bare)[hole].max() > 40

    assert shows(50.0)
    assert not shows(70.0)
    assert not shows(60.0)
    assert shows(60.0, lift=4.0)
    assert not shows(70.0, lift=4.0)


def test_lines_past_the_eye_are_cut_off_and_nothing_else_changes(renderer, make_packet):
    packet = make_packet([])
    bare = drawn(renderer, packet)
    past = drawn(renderer, packet, ((3, -50, -210), (3, 90, -210), (0.9, 0.9, 0.9)))
    rows, columns = np.nonzero(np.abs(past - bare).max(axis=2) > 8)
    assert columns.min() > 155
    assert columns.max() < 200
    assert rows.max() == 179  # it goes out of the picture, below
    behind = drawn(renderer, packet, ((3, -50, -210), (3, -2, -210), (0.9, 0.9, 0.9)))
    assert np.array_equal(behind, bare)
    point = drawn(renderer, packet, ((3, 50, -210), (3, 50, -210), (0.9, 0.9, 0.9)))
    assert np.abs(point - bare).max() < 256


def test_views_that_are_to_show_none_show_none(context, scene, make_packet):
    rig = display_rig("side-by-side", (128, 64))
    renderer = Renderer(context, scene, rig)
    packet = make_packet([], views=views(rig, pose_from_angles(EYE, np.pi / 2, 0.0)))
    line = ((-60, 100, -190), (60, 100, -170), (0.95, 0.9, 0.3))
    packet = replace(packet, lined=1)
    change = np.abs(drawn(renderer, packet, line) - drawn(renderer, packet)).max(axis=2) > 40
    renderer.release()
    assert change[:, :64].any()
    assert not change[:, 64:].any()


@pytest.mark.parametrize("display", ["side-by-side", "anaglyph", "checkerboard", "dome"])
def test_every_kind_of_picture_shows_them(context, scene, make_packet, display):
    rig = display_rig(display, (128, 128))
    renderer = Renderer(context, scene, rig)
    packet = make_packet([], views=views(rig, pose_from_angles(EYE, np.pi / 2, 0.0)))
    line = ((-60, 100, -190), (60, 100, -170), (0.95, 0.9, 0.3))
    change = np.abs(drawn(renderer, packet, line) - drawn(renderer, packet)).max(axis=2) > 40
    renderer.release()
    halves = change[:, :64], change[:, 64:]
    assert all(half.sum() > 10 for half in halves)
    assert change.sum() < 1500


def test_wireframe_draws_edges_and_the_water_behind_them(renderer, make_packet, fish):
    packet = make_packet([fish(0, (0, 40, -200), level=1)], pitch=-0.2)
    full = drawn(renderer, packet)
    renderer.wireframe = True
    edges = drawn(renderer, packet)
    renderer.wireframe = False
    assert np.array_equal(drawn(renderer, packet), full)
    water = drawn(renderer, replace(packet, instances=packet.instances[:0], batches=((),)))
    sand = full[150:, :, :]
    share = (np.abs(edges[150:] - sand).max(axis=2) > 12).mean()
    assert 0.3 < share < 0.98  # transparent between the edges
    assert np.abs(edges[60:130, 100:220] - water[60:130, 100:220]).max() > 40  # of the fish


def test_all_diagrams_of_the_bay(context, same_picture):
    world = start_world("peaceful")
    sketcher = DiagramBuilder(world)
    for _ in range(15):
        step(world, HANDS_OFF)
        sketcher.follow()
    rig = display_rig("mono", SIZE)
    seen = views(rig, cockpit(world.state.submarine, 1.0))
    fish = int(sketcher.draw(["indices"], seen, 1.0).labels[0].text)
    drawing = sketcher.draw(DIAGRAMS, seen, 1.0, fish)
    renderer = Renderer(context, make_scene(world), rig)
    renderer.draw(pack(world, seen, 1.0, lines=drawing.lines))
    same_picture("diagrams", renderer.read_pixels())
    renderer.wireframe = True
    renderer.draw(pack(world, seen, 1.0))
    same_picture("wireframe", renderer.read_pixels())
    assert context.error == "GL_NO_ERROR"
    renderer.release()
