"""Every OpenGL call."""

from subsea.render.context import headless_context, window_context
from subsea.render.renderer import Renderer

__all__ = ["Renderer", "headless_context", "window_context"]
