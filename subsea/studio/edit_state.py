"""The state of the fish builder: undo history, the edit in progress, the selection."""

from collections.abc import Callable

from subsea.studio.draft import EditError, KeyPath, SpeciesDraft
from subsea.ui.undo import History


class EditState:
    """Drafts with undo, and a drag in progress."""

    def __init__(self, draft: SpeciesDraft, new: bool = False) -> None:
        """Begin with a draft; a `new` one counts as unsaved."""
        self.history = History(draft)
        self.history.saved(not new)
        self.selected: KeyPath | None = None  # a point of a view
        self.hovered: KeyPath | None = None  # the point under the pointer
        self.refused = ""  # why the last edit was refused
        self._dragged: SpeciesDraft | None = None

    @property
    def present(self) -> SpeciesDraft:
        """The draft that is shown."""
        return self._dragged or self.history.present

    @property
    def dragging(self) -> bool:
        """True if a drag is in progress."""
        return self._dragged is not None

    def drag(self, edit: Callable[[SpeciesDraft], SpeciesDraft]) -> None:
        """Show an edit of the present draft that `commit` will put into the history."""
        self._dragged = self._tried(edit) or self._dragged

    def commit(self) -> None:
        """End the drag: its result can be undone."""
        if self._dragged is not None:
            self.history.do(self._dragged)
        self._dragged = None

    def do(self, edit: Callable[[SpeciesDraft], SpeciesDraft]) -> bool:
        """Make an edit; return False if it is refused."""
        draft = self._tried(edit)
        if draft is not None:
            self._dragged = None
            self.history.do(draft)
        return draft is not None

    def undo(self) -> None:
        """Go back by one edit, a drag in progress first."""
        self._deselect()
        self.history.undo()

    def redo(self) -> None:
        """Go forward by one edit."""
        self._deselect()
        self.history.redo()

    def _deselect(self) -> None:
        self.commit()
        self.selected = None  # the point may not exist in the other draft

    def _tried(self, edit: Callable[[SpeciesDraft], SpeciesDraft]) -> SpeciesDraft | None:
        try:
            draft = edit(self.present)
        except EditError as fault:
            self.refused = str(fault)
            return None
        self.refused = ""
        return draft
