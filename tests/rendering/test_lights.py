"""The submarine's headlights: lit and unlit places, and pictures with lights off."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.dive.start import start_world
from subsea.frame.packet import lamps_of, make_scene, pack
from subsea.rendering.renderer import Renderer
from subsea.view.display_rigs import cockpit, display_rig, views_for
from subsea.view.levels import LEVELS
from subsea.view.rig import pose_from_angles
from tests.support.daily import only

SIZE = (320, 180)
DEEP_CM = 900.0  # below the sea of other tests
AT = np.array([0.0, 0.0, -1100.0]), np.pi / 2


@pytest.fixture(scope="module")
def dark(drawn, scene):
    """As `drawn`, in a deep sea."""
    deep = replace(scene, terrain=scene.terrain - np.float32(DEEP_CM))
    return lambda packet: drawn(packet, scene=deep)


@pytest.fixture
def sight(make_packet):
    """Fishes → a packet with an eye that looks ahead there."""
    return lambda fishes=(), **options: make_packet(list(fishes), eye=tuple(AT[0]), **options)


@pytest.fixture
def both(dark):
    """Pictures with the lights off and on, of a pilot's packet."""

    def both(packet, pitch=0.0):
        lamps = lamps_of(pose_from_angles(*AT, pitch))
        return dark(packet), dark(replace(packet, lamps=lamps))

    return both


def test_a_warm_beam_lies_on_the_sand_ahead_and_the_rest_stays_dark(both, sight):
    off, on = both(sight(pitch=-0.7), pitch=-0.7)
    gained = on - off
    middle, corner = gained[80:100, 140:180].mean(axis=(0, 1)), gained[:12, :20].mean(axis=(0, 1))
    assert middle[0] > 24  # daylight has no red left there
    assert middle[0] > middle[2] + 14
    assert np.abs(corner).max() < 8
    # Its edge is soft: from the middle outward there is no step.
    across = gained[90, 160:, 0]
    assert np.diff(across).min() > -30
    assert across[0] > 12 > 8 > across[-1]


def test_off_is_as_it_was(dark, both, sight, fish):
    packet = sight([fish(0, (0, 60, -1100))], pitch=-0.2)
    before = dark(packet)
    off, on = both(packet, -0.2)
    assert np.array_equal(before, off)
    assert not np.array_equal(on, off)
    assert np.array_equal(dark(packet), off)


@pytest.mark.parametrize("level", range(len(LEVELS)))
@pytest.mark.parametrize("fade", only([0.0], [0.0, 0.99]))
def test_fishes_of_every_level_are_lit_the_near_ones_more(dark, both, sight, fish, level, fade):
    gains = []
    for away, high in ((190, -1104), (320, -1104), (110, -1053)):
        packet = sight([fish(0, (0, away, high), level=level, fade=fade)])
        bare = dark(sight())
        off, on = both(packet)
        body = np.abs(off - bare).max(axis=2) > 15  # a fish is dim in the deep
        if high > -1100:
            assert not body[60:].any()  # above both beams
        assert body.sum() > 8
        gains.append((on - off)[body].mean())
    near, far, above = gains
    assert near > far > 1.5
    assert near > 3 * max(above, 1.0)


def test_specks_light_up_and_beams_can_be_seen_in_the_water(both, sight):
    rng = np.random.default_rng(2)
    specks = rng.uniform((-40, 140, -1050), (40, 300, -990), (60, 3)).astype(np.float32)
    up = 0.5  # only water ahead
    clear, beams = both(sight(pitch=up), up)
    glow = (beams - clear)[60:120]
    assert glow.mean() > 1.0
    assert glow[:, 100:220].mean() > 2 * max(glow[:, :30].mean(), glow[:, -30:].mean())
    off, on = both(sight(plankton=specks, pitch=up), up)
    assert (on - beams).clip(0).sum() > 2 * (off - clear).clip(0).sum()


def test_lamps_are_left_and_right_of_the_pilot_and_shine_ahead():
    lamps = lamps_of(pose_from_angles(np.array([10.0, 20.0, -300.0]), 0.3, 0.2))
    other = pose_from_angles(np.array([10.0, 20.0, -300.0]), 0.3, 0.2)
    right = np.cross(other.forward, other.up)
    aside = (lamps.places - other.eye) @ right
    assert aside[0] == pytest.approx(-aside[1])
    assert aside[1] > 40.0
    assert ((lamps.places - other.eye) @ other.up < 0.0).all()
    assert np.linalg.norm(lamps.ways, axis=1) == pytest.approx([1.0, 1.0])
    assert (lamps.ways @ other.forward > 0.98).all()
    ends = lamps.places + 900.0 * lamps.ways
    assert np.linalg.norm(ends[0] - ends[1]) < np.ptp(aside)  # they come together


@pytest.mark.nightly
def test_the_bay_by_its_lights(context, same_picture):
    world = start_world("peaceful")
    submarine = world.state.submarine
    submarine.position[:] = submarine.previous_position[:] = -250.0, -330.0, -500.0
    submarine.angles[:] = submarine.previous_angles[:] = np.radians((65.0, -5.0))
    seen = views_for("mono", SIZE, cockpit(submarine, 1.0))
    renderer = Renderer(context, make_scene(world), display_rig("mono", SIZE))
    assert pack(world, seen, 1.0).lamps is None
    submarine.lights[:] = True
    renderer.draw(pack(world, seen, 1.0))
    same_picture("lights", renderer.read_pixels())
    assert context.error == "GL_NO_ERROR"
    renderer.release()
