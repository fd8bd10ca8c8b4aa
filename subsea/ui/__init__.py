"""Windows, their input, and what they show beside the sea.

The packages glfw and imgui_bundle each bring GLFW libraries, and imgui_bundle does not load after
the library of glfw for Wayland. So this package imports both before any of its modules, in the
order that works, and other packages take `glfw` from here.
"""

import os
from importlib.util import find_spec
from pathlib import Path

# The library of imgui_bundle, which glfw uses too, opens windows by X11 alone.
if os.environ.get("WAYLAND_DISPLAY") and not os.environ.get("DISPLAY"):
    package = find_spec("glfw")
    if package and package.origin:
        library = Path(package.origin).with_name("wayland") / "libglfw.so"
        os.environ.setdefault("PYGLFW_LIBRARY", str(library))

import imgui_bundle  # noqa: F401  # isort: skip
import glfw

__all__ = ["glfw"]
