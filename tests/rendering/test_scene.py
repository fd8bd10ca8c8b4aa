"""Whole scenarios at tick 0: compared with stored pictures, in few drawing calls."""

import os

import msgspec
import numpy as np
import pytest

from subsea.dive.start import start_world
from subsea.dive.tour import Tour
from subsea.fish.species import species_names
from subsea.frame.packet import KIND, make_scene, pack
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.scenario.schema import Shoal
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import cockpit, display_rig, views_for
from subsea.view.rig import pose_from_angles
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.daily import only

SIZE = (320, 180)
MOST_CALLS = 40


def sights(world, display="mono", size=SIZE):
    return views_for(display, size, cockpit(world.state.submarine, 1.0))


@pytest.fixture(scope="module")
def bay():
    return start_world("peaceful")


def test_the_context_is_as_old_as_asked(context):
    asked = os.environ.get("MESA_GL_VERSION_OVERRIDE")
    assert context.version_code >= 330
    assert asked is None or context.version_code == round(100 * float(asked))


@pytest.fixture(scope="module")
def crowd(bay):
    """A thousand fishes of every species in the same bay."""
    kinds = species_names()
    assert len(kinds) >= 10
    shoals = [Shoal(species=name, number=1000 // len(kinds)) for name in kinds]
    world = create_world(msgspec.structs.replace(bay.scenario, fish=shoals))
    assert len(world.state.fishes.species) == 1000
    step(world, NEUTRAL)
    return world


def test_the_peaceful_bay(context, bay, same_picture):
    packet = pack(bay, sights(bay), 1.0)
    renderer = Renderer(context, make_scene(bay), display_rig("mono", SIZE))
    for quality in ("low", "high"):
        renderer.adapt(PRESETS[quality])
        renderer.draw(packet)
        same_picture(f"peaceful-{quality}", renderer.read_pixels())
    assert context.error == "GL_NO_ERROR"
    renderer.release()


@pytest.mark.nightly
@pytest.mark.parametrize(("sea", "species"), only([("bay", 5)], [("bay", 5), ("crowd", 10)]))
def test_a_frame_takes_few_drawing_calls(context, request, sea, species):
    world, tour = request.getfixturevalue(sea), Tour()
    renderer = Renderer(context, make_scene(world), display_rig("mono", (96, 54)))
    kinds, most = set(), 0
    for k in range(15):
        step(world, tour.steer(world))
        if k % 5 == 0:
            renderer.adapt(list(PRESETS.values())[k // 5])
            packet = pack(world, sights(world, size=(96, 54)), 1.0)
            renderer.draw(packet)
            most = max(most, renderer.draw_calls)
            kinds |= set(packet.instances[:, KIND])
    renderer.release()
    assert len(kinds) >= species  # many were in sight
    assert 8 < most <= MOST_CALLS


def test_slivers_of_triangles_do_not_shine(context, bay):
    """With several samples a pixel, their numbers lie far outside those of their corners."""
    renderer = Renderer(context, make_scene(bay), display_rig("mono", SIZE), PRESETS["high"])
    rng = np.random.default_rng(5)
    places = bay.state.fishes.position[rng.integers(60, size=12)] + rng.normal(0, 25, (12, 3))
    for place, heading in zip(places, rng.uniform(0, 2 * np.pi, 12), strict=True):
        downward = pose_from_angles(place, heading, -0.6)  # no view of the sun
        renderer.draw(pack(bay, views_for("mono", SIZE, downward), 1.0))
        assert renderer.light().min() >= 0.0
        assert renderer.light().max() < 20.0
    renderer.release()
