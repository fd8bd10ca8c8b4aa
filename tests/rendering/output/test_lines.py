"""Lines over the sea: look, occlusion, and every kind of picture."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.dive.start import start_world
from subsea.frame.diagrams import DIAGRAMS, DiagramBuilder, Lines
from subsea.frame.packet import make_scene, pack
from subsea.rendering.renderer import Renderer
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import cockpit, display_rig
from subsea.view.rig import views
from subsea.world.step import step

SIZE = (320, 180)
SLANTED = (-60, 100, -190), (60, 100, -170), (0.95, 0.9, 0.3)


@pytest.fixture
def lined(drawn):
    """The picture of a packet with a line of (from, to, colour)."""

    def lined(packet, line=None, lift=0.0, **options):
        if line:
            a, b, colour = line
            lines = [[a, b]], [[*colour, 1.0][:4]], [lift]
            packet = replace(packet, lines=Lines(*(np.array(part, np.float32) for part in lines)))
        return drawn(packet, **options)

    return lined


@pytest.mark.parametrize(
    "colour", [(0.95, 0.30, 0.20), (0.35, 0.90, 0.30), (0.2, 0.2, 0.2), (0.95, 0.90, 0.72)]
)
def test_a_line_has_its_colour_whatever_lies_behind(lined, make_packet, colour):
    packet = make_packet([])
    a, b = (-40, 100, -200.2), (40, 100, -200.2)
    picture = lined(packet, (a, b, colour))
    bare = lined(packet)
    changed = np.abs(picture - bare).max(axis=2) > 6
    rows, columns = np.nonzero(changed)
    assert np.ptp(rows) <= 3  # thin
    # 80 cm seen from 100 cm.
    assert np.ptp(columns) == pytest.approx(0.8 * 90 / np.tan(np.radians(27.5)), abs=4)
    nearest = np.abs(picture[changed] - 255 * np.array(colour)).max(axis=1).min()
    assert nearest <= 8


def test_a_faint_line_has_about_its_share_of_the_full_colour(lined, make_packet):
    packet = make_packet([])
    a, b, colour = (-40, 100, -201), (40, 100, -201), np.array([0.95, 0.80, 0.30])
    bare = lined(packet)
    full = lined(packet, (a, b, colour))
    faint = lined(packet, (a, b, (*colour, 0.35)))
    place = np.unravel_index(np.abs(full - bare).sum(axis=2).argmax(), bare.shape[:2])
    between = 255 * (0.35 * (full[place] / 255) ** 2.2 + 0.65 * (bare[place] / 255) ** 2.2) ** 0.45
    assert np.abs(faint[place] - between).max() < 30
    assert (faint[place][0] > faint[place][2]) == (colour[0] > colour[2])


def test_fishes_hide_what_is_behind_them_and_show_what_is_within(lined, make_packet, fish):
    packet = make_packet([fish(0, (0, 60, -200), level=0)])
    red = (0.95, 0.1, 0.1)
    bare = lined(packet)
    hole = (slice(86, 95), slice(150, 170))  # the fish's middle

    def shows(y, lift=0.0):
        picture = lined(packet, ((-60, y, -200.4), (60, y, -200.4), red), lift=lift)
        assert np.abs(picture - bare).max() > 40
        return np.abs(picture - bare)[hole].max() > 40

    assert shows(50.0)
    assert not shows(70.0)
    assert not shows(60.0)
    assert shows(60.0, lift=4.0)
    assert not shows(70.0, lift=4.0)


def test_lines_past_the_eye_are_cut_off_and_nothing_else_changes(lined, make_packet):
    packet = make_packet([])
    bare = lined(packet)
    past = lined(packet, ((3, -50, -210), (3, 90, -210), (0.9, 0.9, 0.9)))
    rows, columns = np.nonzero(np.abs(past - bare).max(axis=2) > 8)
    assert columns.min() > 155
    assert columns.max() < 200
    assert rows.max() == 179  # it goes out of the picture, below
    behind = lined(packet, ((3, -50, -210), (3, -2, -210), (0.9, 0.9, 0.9)))
    assert np.array_equal(behind, bare)
    point = lined(packet, ((3, 50, -210), (3, 50, -210), (0.9, 0.9, 0.9)))
    assert np.abs(point - bare).max() < 256


def test_views_that_are_to_show_none_show_none(lined, make_packet):
    packet = replace(make_packet([], size=(128, 64), display="side-by-side"), lined=1)
    shown = {"size": (128, 64), "display": "side-by-side"}
    change = np.abs(lined(packet, SLANTED, **shown) - lined(packet, **shown)).max(axis=2) > 40
    assert change[:, :64].any()
    assert not change[:, 64:].any()


@pytest.mark.parametrize("display", ["side-by-side", "anaglyph", "checkerboard", "dome"])
def test_every_kind_of_picture_shows_them(lined, make_packet, display):
    shown = {"size": (128, 128), "display": display}
    packet = make_packet([], **shown)
    change = np.abs(lined(packet, SLANTED, **shown) - lined(packet, **shown)).max(axis=2) > 40
    halves = change[:, :64], change[:, 64:]
    assert all(half.sum() > 10 for half in halves)
    assert change.sum() < 1500


def test_wireframe_draws_edges_and_the_water_behind_them(lined, make_renderer, make_packet, fish):
    packet = make_packet([fish(0, (0, 40, -200), level=1)], pitch=-0.2)
    full = lined(packet)
    make_renderer().wireframe = True
    edges = lined(packet)
    make_renderer().wireframe = False
    assert np.array_equal(lined(packet), full)
    water = lined(replace(packet, instances=packet.instances[:0], batches=((),)))
    sand = full[150:, :, :]
    share = (np.abs(edges[150:] - sand).max(axis=2) > 12).mean()
    assert 0.3 < share < 0.98  # transparent between the edges
    assert np.abs(edges[60:130, 100:220] - water[60:130, 100:220]).max() > 40  # of the fish


@pytest.mark.nightly
def test_all_diagrams_of_the_bay(context, same_picture):
    world = start_world("peaceful")
    builder = DiagramBuilder(world)
    for _ in range(15):
        step(world, NEUTRAL)
        builder.follow()
    rig = display_rig("mono", SIZE)
    seen = views(rig, cockpit(world.state.submarine, 1.0))
    fish = int(builder.draw(["indices"], seen, 1.0).labels[0].text)
    drawing = builder.draw(DIAGRAMS, seen, 1.0, fish)
    renderer = Renderer(context, make_scene(world), rig)
    renderer.draw(pack(world, seen, 1.0, lines=drawing.lines))
    same_picture("diagrams", renderer.read_pixels())
    renderer.wireframe = True
    renderer.draw(pack(world, seen, 1.0))
    same_picture("wireframe", renderer.read_pixels())
    assert context.error == "GL_NO_ERROR"
    renderer.release()
