"""Every OpenGL call."""

from subsea.render.context import headless_context, page_switch, window_context
from subsea.render.presenter import Presenter
from subsea.render.renderer import Renderer

__all__ = ["Presenter", "Renderer", "headless_context", "page_switch", "window_context"]
