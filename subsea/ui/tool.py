"""The interface of a tool to its window."""

from typing import Protocol


class Tool(Protocol):
    """An editor inside a `ToolWindow`."""

    @property
    def unsaved(self) -> bool:
        """Whether closing the window now would lose changes."""

    @property
    def may_undo(self) -> bool:
        """Whether there is something to undo."""

    @property
    def may_redo(self) -> bool:
        """Whether there is something to redo."""

    def draw(self, elapsed_s: float) -> float:
        """Draw everything, `elapsed_s` after the last frame.

        Return the seconds until it changes by itself: 0 while it moves, inf if never.
        """

    def draw_menu(self) -> None:
        """Add entries to the menu bar by ``imgui.menu_item``."""

    def save(self) -> bool:
        """Save; return whether that succeeded. The window shows a UserError."""

    def undo(self) -> None:
        """Go back by one edit."""

    def redo(self) -> None:
        """Go forward by one edit."""

    def close(self) -> None:
        """Release all resources; the OpenGL context is still current."""
