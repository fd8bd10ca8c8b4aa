"""States one after another, to go back and forth between: what was done, undone and saved."""

from typing import Generic, TypeVar

State = TypeVar("State")


class History(Generic[State]):
    """Immutable states one after another; `present` is the one that holds.

    States are compared by ``==``: one that holds arrays should be equal to nothing but itself.
    """

    def __init__(self, state: State) -> None:
        """Begin with this one, which is saved: there is nothing to undo."""
        self._all = [state]
        self._at = 0
        self._saved: State | None = state

    @property
    def present(self) -> State:
        """The state that holds now."""
        return self._all[self._at]

    @property
    def may_undo(self) -> bool:
        """Whether there is an earlier one."""
        return self._at > 0

    @property
    def may_redo(self) -> bool:
        """Whether one was undone."""
        return self._at < len(self._all) - 1

    @property
    def unsaved(self) -> bool:
        """Whether the present state is another than the one that was saved last."""
        return self._saved is None or self.present != self._saved

    def saved(self, really: bool = True) -> None:
        """The present state is saved; or nothing of it `really` is, as of what is new."""
        self._saved = self.present if really else None

    def do(self, state: State) -> None:
        """From now on this one holds; what was undone is forgotten."""
        if state != self.present:
            self._all[self._at + 1 :] = [state]
            self._at += 1

    def undo(self) -> State:
        """Back to the one before, if there is one."""
        self._at = max(self._at - 1, 0)
        return self.present

    def redo(self) -> State:
        """Forth to the one that was undone last, if there is one."""
        self._at = min(self._at + 1, len(self._all) - 1)
        return self.present
