"""The steps of structured light in a dive: by a key, by the clock, or on a command."""

from collections.abc import Callable, Sequence

from subsea.base.errors import UserError
from subsea.base.progress import say
from subsea.stage.calibration.photographs import LightStep

DARK_S = 3.0  # before the first picture, and after the last one


class StructuredLight:
    """Steps through the structured light of a theatre.

    `every_s` goes on by itself, after DARK_S without light; None: on a key or a command only.
    """

    def __init__(
        self,
        steps: Sequence[LightStep],
        every_s: float | None = None,
        tell: Callable[[str], object] = say,
    ) -> None:
        """Begin with the sea; `tell` takes a line for each step by key."""
        self.number = 0  # of the step that is shown, from 1; 0: the sea
        self._steps, self._every_s, self._tell = steps, every_s, tell
        self._left_s = DARK_S

    @property
    def shown(self) -> tuple[int, int] | None:
        """The channel and the number of its picture, for `Presented.light`; None: the sea."""
        if self.number == 0:
            return None
        step = self._steps[self.number - 1]
        return step.channel, step.number

    @property
    def words(self) -> str:
        """The step that is shown, for people."""
        if self.number == 0:
            return "the screens show the sea"
        return f"{self.number} of {len(self._steps)}: {self._steps[self.number - 1].words}"

    def show(self, number: int) -> str:
        """Show the step of a number from 1; 0: the sea; -1: the next step, after the last the sea.

        Returns what is shown; a UserError for a number beyond the last.
        """
        if number > len(self._steps):
            raise UserError(f"number {number}: expected {len(self._steps)} at most")
        self.number = (self.number + 1) % (len(self._steps) + 1) if number < 0 else number
        return self.words

    def cue(self) -> None:
        """Go on to the next step on a key."""
        self._tell(f"structured light, {self.show(-1)}")

    def update(self, elapsed_s: float) -> None:
        """Go on by the clock, once from the first step to the last."""
        if self._every_s is None:
            return
        self._left_s -= elapsed_s
        while self._left_s <= 0.0:  # in step with the timer of a camera, after a long picture too
            self._left_s += self._every_s
            self.show(-1)
            if self.number == 0:
                self._every_s = None
                self._tell("structured light: all pictures were shown")
                return
