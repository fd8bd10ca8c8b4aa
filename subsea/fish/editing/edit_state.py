"""What is being edited: the drafts so far, the one that a hand still drags, what is chosen."""

from collections.abc import Callable

from subsea.core.undo import History
from subsea.fish.editing.draft import Draft, EditError, Path_


class Editing:
    """The state of the builder's work, without a window."""

    def __init__(self, draft: Draft, new: bool = False) -> None:
        """Begin with a draft; one that is `new` is not saved yet."""
        self.history = History(draft)
        self.history.saved(not new)
        self.chosen: Path_ | None = None  # a point of a view
        self.over: Path_ | None = None  # the one that the pointer is on
        self.refused = ""  # why the last edit was not made
        self._held: Draft | None = None

    @property
    def present(self) -> Draft:
        """The draft that is shown."""
        return self._held or self.history.present

    @property
    def held(self) -> bool:
        """Whether a hand is in the midst of something."""
        return self._held is not None

    def hold(self, edit: Callable[[Draft], Draft]) -> None:
        """A hand drags: the present draft is shown edited, and can still become another one."""
        self._held = self._tried(edit) or self._held

    def settle(self) -> None:
        """The hand has let go: what it made holds, and can be undone at once."""
        if self._held is not None:
            self.history.do(self._held)
        self._held = None

    def do(self, edit: Callable[[Draft], Draft]) -> bool:
        """Make an edit; whether it was made."""
        draft = self._tried(edit)
        if draft is not None:
            self._held = None
            self.history.do(draft)
        return draft is not None

    def undo(self) -> None:
        """Go back by one edit, that in the hand first; a point may be there no more."""
        self.settle()
        self.chosen = None
        self.history.undo()

    def redo(self) -> None:
        """Go forth by one edit."""
        self.settle()
        self.chosen = None
        self.history.redo()

    def _tried(self, edit: Callable[[Draft], Draft]) -> Draft | None:
        try:
            draft = edit(self.present)
        except EditError as why:
            self.refused = str(why)
            return None
        self.refused = ""
        return draft
