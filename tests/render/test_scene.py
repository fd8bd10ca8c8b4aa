"""Whole scenarios as they begin: against stored pictures."""

import os

import pytest

from subsea.app.start import start_world
from subsea.frame import make_scene, pack
from subsea.render import Renderer
from subsea.render.quality import PRESETS
from subsea.view.rigs import cockpit, views_for

SIZE = (320, 180)


def sights(world, display="mono", size=SIZE):
    return views_for(display, size, cockpit(world.state.submarine, 1.0))


@pytest.fixture(scope="module")
def bay():
    return start_world("peaceful")


def test_the_context_is_as_old_as_asked(context):
    asked = os.environ.get("MESA_GL_VERSION_OVERRIDE")
    assert context.version_code >= 330
    assert asked is None or context.version_code == round(100 * float(asked))


def test_the_peaceful_bay(context, bay, same_picture):
    packet = pack(bay, sights(bay), 1.0)
    renderer = Renderer(context, make_scene(bay), SIZE)
    for quality in ("low", "high"):
        renderer.adapt(PRESETS[quality])
        renderer.draw(packet)
        same_picture(f"peaceful-{quality}", renderer.read_pixels())
    assert context.error == "GL_NO_ERROR"
    renderer.release()
