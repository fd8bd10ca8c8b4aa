"""Undo history."""

from typing import Generic, TypeVar

State = TypeVar("State")


class History(Generic[State]):
    """Immutable states with undo and redo; `present` is the current one.

    States are compared by ``==``, so a state with arrays should only equal itself.
    """

    def __init__(self, state: State) -> None:
        """Begin with a state that counts as saved."""
        self._all = [state]
        self._at = 0
        self._saved: State | None = state

    @property
    def present(self) -> State:
        """The current state."""
        return self._all[self._at]

    @property
    def may_undo(self) -> bool:
        """True if there is an earlier state."""
        return self._at > 0

    @property
    def may_redo(self) -> bool:
        """True if a state was undone."""
        return self._at < len(self._all) - 1

    @property
    def unsaved(self) -> bool:
        """True if the current state differs from the one saved last."""
        return self._saved is None or self.present != self._saved

    def saved(self, really: bool = True) -> None:
        """Mark the current state as saved, or as unsaved if not `really`."""
        self._saved = self.present if really else None

    def do(self, state: State) -> None:
        """Make this the current state and discard undone states."""
        if state != self.present:
            self._all[self._at + 1 :] = [state]
            self._at += 1

    def undo(self) -> State:
        """Go back to the previous state, if any."""
        self._at = max(self._at - 1, 0)
        return self.present

    def redo(self) -> State:
        """Go forward to the state undone last, if any."""
        self._at = min(self._at + 1, len(self._all) - 1)
        return self.present
