"""A headset without a runtime: a test moves its head and hands, and ends it."""

from collections.abc import Callable
from typing import Any

import numpy as np

from subsea.stage.headset.controllers import Hand, HeadsetFrame, HeadsetLostError
from subsea.stage.headset.head import HeadEye, Pose

NOT_TURNED = np.array([0.0, 0.0, 0.0, 1.0])
# As of real headsets: more to the outside than to the nose, more down than up.
OUT, IN, UP, DOWN = np.radians([50.0, 42.0, 43.0, 47.0]).tolist()
APART_M = 0.063


def turned(degrees: float, axis: tuple[float, float, float]) -> Any:
    """The quaternion x, y, z, w of a turn about an axis, anticlockwise seen from its tip."""
    half = np.radians(degrees) / 2.0
    return np.array([*(np.sin(half) * np.array(axis)), np.cos(half)])


class FakeHeadset:
    """The interface of `OpenXrHeadset`, with textures of the `context`."""

    def __init__(self, context: Any, size: tuple[int, int] = (120, 128)) -> None:
        self.name = "a headset of the tests"
        self.sizes = (size, size)
        self.rest()
        self.recentred = False
        self.lost_in = ""  # the call that raises
        self.calls: list[str] = []
        self.shown: Callable[[], None] = lambda: None  # called when a frame ends
        self.textures = [context.texture(size, 4) for _ in self.sizes]
        self._framebuffers = [context.framebuffer([one]) for one in self.textures]
        self._made = [*self.textures, *self._framebuffers]

    def rest(self) -> None:
        """Put head and hands back to where they were."""
        self.hands = (Hand(), Hand())
        self.worn = self.focused = self.visible = self.tracked = self.running = True
        self.position, self.orientation = np.zeros(3), NOT_TURNED

    def poll(self) -> None:
        """Note the call."""
        self._note("poll")

    def begin(self) -> HeadsetFrame | None:
        """The eyes of the head where the test put it."""
        self._note("begin")
        if not self.running:
            return None
        names = tuple(one.glo for one in self.textures)
        return HeadsetFrame(self.eyes, self.tracked, self.visible, names)

    @property
    def eyes(self) -> tuple[HeadEye, ...]:
        """Left and right."""
        from subsea.stage.headset.head import rotation_of

        right = rotation_of(self.orientation)[:, 0]
        poses = [
            Pose(self.position + side * 0.5 * APART_M * right, self.orientation)
            for side in (-1.0, 1.0)
        ]
        return HeadEye(poses[0], -OUT, IN, UP, -DOWN), HeadEye(poses[1], -IN, OUT, UP, -DOWN)

    def end(self) -> None:
        """Show the frame."""
        self._note("end")
        self.shown()

    def pulse(self, hand: int, strength: float, seconds: float) -> None:
        """Note the call."""
        self._note(f"pulse {hand}")

    def close(self) -> None:
        """Release the textures."""
        self.calls.append("close")
        while self._made:
            self._made.pop().release()

    def pictures(self) -> Any:
        """The pictures of both eyes: (2, h, w, 3), top row first."""
        width, height = self.sizes[0]
        read = [np.frombuffer(one.read(components=3, alignment=1), np.uint8)
                for one in self._framebuffers]  # fmt: skip
        return np.stack([one.reshape(height, width, 3)[::-1] for one in read]).astype(int)

    def _note(self, call: str) -> None:
        self.calls.append(call)
        if call == self.lost_in:
            raise HeadsetLostError("the headset's runtime ended")
