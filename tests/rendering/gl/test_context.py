"""Contexts, and the error messages without OpenGL."""

import ctypes.util
import os

import moderngl
import pytest

from subsea.base.errors import UserError
from subsea.rendering.gl.context import (
    DRIVER_SETTINGS,
    headless_context,
    opengl_remedy,
    window_context,
)


@pytest.fixture(scope="module")
def context(own_context):
    return own_context


@pytest.mark.parametrize("make", [headless_context, lambda: window_context(lambda name: 0)])
def test_missing_opengl_names_the_packages_to_install(monkeypatch, make):
    def fail(*arguments, **settings):
        raise ImportError("libEGL.so not loaded\nsecond line")

    monkeypatch.setattr(moderngl, "create_context", fail)
    with pytest.raises(UserError, match=r"libEGL.so not loaded.*apt-get install") as caught:
        make()
    assert "\n" not in str(caught.value)


def test_variables_that_select_drivers_are_named(monkeypatch):
    for name in [*os.environ]:
        if name.startswith(DRIVER_SETTINGS):
            monkeypatch.delenv(name)
    assert opengl_remedy("apt") == "on Debian or Ubuntu: apt"
    monkeypatch.setenv("LIBGL_DRIVERS_PATH", "/nowhere")
    monkeypatch.setenv("MESA_GL_VERSION_OVERRIDE", "1.0")
    assert opengl_remedy("apt") == (
        "try without LIBGL_DRIVERS_PATH=/nowhere MESA_GL_VERSION_OVERRIDE=1.0, "
        "or on Debian or Ubuntu: apt"
    )


def test_drawing_calls_are_counted_and_timed(context, make_renderer, make_packet, fish):
    renderer = make_renderer((64, 36))
    for _ in range(2):  # the first picture also makes lazily made objects
        renderer.draw(make_packet([], size=(64, 36)))
    without = renderer.draw_calls
    tally = context.extra.calls
    renderer.draw(make_packet([fish(0, (0, 40, -200))], size=(64, 36)))
    assert context.extra.calls - tally == renderer.draw_calls
    assert without < renderer.draw_calls <= without + 2  # its body and its fins
    assert 0.0 < renderer.draw_s < 10.0


def test_a_window_brings_its_own_functions(context):
    egl = ctypes.CDLL(ctypes.util.find_library("EGL"))
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    window = window_context(lambda name: egl.eglGetProcAddress(name.encode()))
    assert window.version_code >= 330
    assert window.info["GL_RENDERER"] == context.info["GL_RENDERER"]


def test_what_a_released_context_leaves_frees_nothing_of_the_next_one(context):
    old = headless_context()
    with old:
        left = [old.texture((4, 4), 4) for _ in range(50)]
        left.append(
            old.program(vertex_shader="#version 330\nvoid main() { gl_Position = vec4(0.0); }")
        )
    old.release()
    with context:
        texture = context.texture((4, 4), 4, data=b"\x07" * 64)
        assert texture.glo in [one.glo for one in left]
        left.clear()
        assert context.error == "GL_NO_ERROR"
        assert texture.read() == b"\x07" * 64
