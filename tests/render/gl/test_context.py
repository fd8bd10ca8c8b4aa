"""Contexts, and the error messages without OpenGL."""

import ctypes.util
import os
import subprocess
import sys

import moderngl
import pytest

from subsea.core.errors import UserError
from subsea.render import Renderer, headless_context, window_context
from subsea.view.display_rigs import display_rig

DRAW = """
import numpy as np
from subsea.frame.packet import Packet, RenderScene
from subsea.render import Renderer, headless_context
from subsea.scenario.schema import Water
from subsea.fish.species import load_species
from subsea.view.rig import pose_from_angles
from subsea.view.display_rigs import display_rig, views_for

context = headless_context()
scene = RenderScene(
    species=(load_species("fusilier"),), control_points=np.zeros((1, 426, 3), np.float32),
    recorded_length_cm=(20.0,), terrain=np.full((9, 9), -300, np.float32),
    terrain_half_width_cm=500.0,
    water=Water(fog=(0.0, 0.1, 0.2), visibility_cm=900.0),
)
renderer = Renderer(context, scene, display_rig("mono", (64, 36)))
views = views_for("mono", (64, 36), pose_from_angles(np.array([0.0, 0.0, -200.0]), 0.0, 0.0))
empty = np.zeros((0, 16), np.float32)
renderer.draw(Packet(0.0, views, empty, ((),), np.zeros((0, 3), np.float32), 0))
print(context.version_code, renderer.read_pixels().max() > 50)
"""


def run(code, **environment):
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=100,
    )


def test_opengl_3_3_is_enough():
    result = run(DRAW, MESA_GL_VERSION_OVERRIDE="3.3", MESA_GLSL_VERSION_OVERRIDE="330")
    assert result.stdout == "330 True\n", result.stderr


def test_too_old_an_opengl_is_one_line():
    code = "from subsea.render import headless_context\nheadless_context()"
    result = run(code, MESA_GL_VERSION_OVERRIDE="2.1", MESA_GLSL_VERSION_OVERRIDE="120")
    last = result.stderr.strip().splitlines()[-1]
    assert last.startswith("subsea.core.errors.UserError: no OpenGL 3.3"), result.stderr
    assert "apt-get install" in last


@pytest.mark.parametrize("make", [headless_context, lambda: window_context(lambda name: 0)])
def test_no_opengl_at_all_says_what_to_install(monkeypatch, make):
    def fail(*arguments, **settings):
        raise ImportError("libEGL.so not loaded\nsecond line")

    monkeypatch.setattr(moderngl, "create_context", fail)
    with pytest.raises(UserError, match=r"libEGL.so not loaded.*apt-get install") as caught:
        make()
    assert "\n" not in str(caught.value)


def test_drawing_calls_are_counted_and_timed(context, scene, make_packet, fish):
    renderer = Renderer(context, scene, display_rig("mono", (64, 36)))
    for _ in range(2):  # the first picture also makes lazily made objects
        renderer.draw(make_packet([], size=(64, 36)))
    without = renderer.draw_calls
    tally = context.extra.calls
    renderer.draw(make_packet([fish(0, (0, 40, -200))], size=(64, 36)))
    assert context.extra.calls - tally == renderer.draw_calls
    assert without < renderer.draw_calls <= without + 2  # its body and its fins
    assert 0.0 < renderer.draw_s < 10.0
    renderer.release()


def test_a_window_brings_its_own_functions(context):
    egl = ctypes.CDLL(ctypes.util.find_library("EGL"))
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    window = window_context(lambda name: egl.eglGetProcAddress(name.encode()))
    assert window.version_code >= 330
    assert window.info["GL_RENDERER"] == context.info["GL_RENDERER"]
