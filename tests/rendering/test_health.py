"""A long dive leaves no OpenGL error and no leaked object, also with OpenGL 3.3."""

import ctypes
import ctypes.util
import gc
import os
import subprocess
import sys
import weakref
from pathlib import Path

import pytest

from subsea.dive.start import start_world
from subsea.dive.tour import Tour
from subsea.frame.packet import make_scene, pack
from subsea.rendering.output.quality import LADDER, PRESETS
from subsea.rendering.renderer import Renderer
from subsea.view.display_rigs import cockpit, display_rig, views_for
from subsea.view.levels import empty_lod_state
from subsea.world.step import step

KINDS = (
    "Buffer", "Framebuffer", "Program", "Query", "Renderbuffer", "Sampler", "Shader", "Texture",
    "VertexArray",
)  # fmt: skip
NAMES = 3000  # drivers count names from 1 and reuse freed ones
SIZES = ((96, 54), (64, 64), (120, 40))


@pytest.fixture(scope="module")
def context(own_context):
    return own_context


@pytest.fixture(scope="module")
def world():
    return start_world("peaceful", fish=40)


@pytest.fixture(scope="module")
def living(context):
    """Counts the existing OpenGL objects of each kind, by testing every name."""
    library = ctypes.CDLL(ctypes.util.find_library("EGL"))
    library.eglGetProcAddress.restype = ctypes.c_void_p

    def function(name, result):
        address = library.eglGetProcAddress(name.encode())
        return ctypes.CFUNCTYPE(result, ctypes.c_uint)(address)

    questions = {name: function(f"glIs{name}", ctypes.c_ubyte) for name in KINDS}
    use_program = function("glUseProgram", None)

    def count():
        use_program(0)  # a program in use outlives its release
        return {name: sum(map(asked, range(1, NAMES))) for name, asked in questions.items()}

    return count


def test_the_count_sees_what_is_made_and_freed(context, living):
    before = living()
    texture, buffer = context.texture((2, 2), 4), context.buffer(reserve=4)
    array = context.vertex_array(
        context.program(vertex_shader="#version 330\nvoid main() { gl_Position = vec4(0.0); }"), []
    )
    made = {name: number - before[name] for name, number in living().items() if number}
    assert made["Texture"] == made["Buffer"] == made["VertexArray"] == made["Program"] == 1
    for held in (texture, buffer, array.program, array):
        held.release()
    assert living() == before


@pytest.mark.nightly
def test_a_scenario_that_was_left_is_freed(context):
    world = start_world("peaceful", fish=4)
    renderer = Renderer(context, make_scene(world), display_rig("mono", SIZES[0]), PRESETS["low"])
    renderer.draw(
        pack(world, views_for("mono", SIZES[0], cockpit(world.state.submarine, 1.0)), 1.0)
    )
    fishes, sea = world.state.fishes.position, world.state.sea.heights
    left = [weakref.ref(part) for part in (world, renderer, fishes, sea)]
    renderer.release()
    del world, renderer, fishes, sea
    gc.collect()
    assert [part() for part in left] == [None] * 4


@pytest.mark.nightly
def test_three_sizes_and_all_qualities_leak_nothing(context, living, world):
    before, tour = living(), Tour()
    renderer = Renderer(context, make_scene(world), display_rig("mono", SIZES[0]), PRESETS["low"])
    memory, settled = empty_lod_state(len(world.state.fishes.species)), None
    for k in range(96):
        if k % 5 == 0:
            step(world, tour.steer(world))
        if k % 20 == 19:
            renderer.arrange(display_rig("mono", SIZES[k // 20 % len(SIZES)]))
        if k % 4 == 0:
            renderer.adapt(LADDER[k // 4 % len(LADDER)])
        quality = renderer.quality
        renderer.draw(
            pack(
                world, sight(world, renderer), k % 5 / 5.0, options=quality.packing, memory=memory,
            )
        )  # fmt: skip
        if k % 16 == 15:
            assert context.error == "GL_NO_ERROR"
        if k == 68:  # all qualities were drawn: lazily made objects exist by now
            renderer.adapt(PRESETS["low"])
            settled = living()
    renderer.adapt(PRESETS["low"])
    assert living() == settled
    renderer.release()
    assert living() == before
    assert context.error == "GL_NO_ERROR"


def sight(world, renderer):
    return views_for("mono", renderer.size, cockpit(world.state.submarine, 1.0))


@pytest.mark.nightly
def test_the_pictures_are_the_same_at_opengl_3_3():
    """Draw all stored pictures again with a driver limited to OpenGL 3.3."""
    older = {"MESA_GL_VERSION_OVERRIDE": "3.3", "MESA_GLSL_VERSION_OVERRIDE": "330"}
    pictures = [Path(__file__).with_name(name) for name in ("test_pictures.py", "test_scene.py")]
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-p",
            "no:cacheprovider",
            "-k",
            "not calls",
            *pictures,
        ],
        env=os.environ | older,
        capture_output=True,
        text=True,
        timeout=250,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-3000:]
    assert "passed" in done.stdout
    assert "skipped" not in done.stdout
