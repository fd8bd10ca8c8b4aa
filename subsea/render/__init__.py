"""Every OpenGL call."""

from typing import TYPE_CHECKING, Any

from subsea.render.gl.context import count_objects, headless_context, page_switch, window_context
from subsea.render.output.presenter import Presenter

if TYPE_CHECKING:
    from subsea.render.renderer import Renderer

__all__ = [
    "Presenter",
    "Renderer",
    "count_objects",
    "headless_context",
    "page_switch",
    "window_context",
]


def __getattr__(name: str) -> Any:
    """Import the renderer when first needed: a window opens long before."""
    if name != "Renderer":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from subsea.render.renderer import Renderer

    return Renderer
