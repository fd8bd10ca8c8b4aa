"""How long the others waited for a node."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

RECENT = 10_000  # pictures of which the 95th percentile is taken


@dataclass
class WaitStatistics:
    """Of one node, in seconds; `late` and the like count events."""

    frames: int = 0  # pictures that it showed together with the others
    total_s: float = 0.0
    longest_s: float = 0.0
    recent_s: deque[float] = field(default_factory=lambda: deque(maxlen=RECENT))
    late: int = 0  # times that the others went on without it
    dropped: int = 0  # connections that were lost
    rejoined: int = 0  # times that it came back
    diverged: int = 0  # times that its world was another

    def add(self, wait_s: float) -> None:
        """One picture, for which all waited so long after the master had drawn its own."""
        self.frames += 1
        self.total_s += wait_s
        self.longest_s = max(self.longest_s, wait_s)
        self.recent_s.append(wait_s)

    def words(self) -> str:
        """One line: pictures; mean, 95th percentile and longest wait; what went wrong."""
        mean, late = (0.0, 0.0)
        if self.frames:
            mean, late = self.total_s / self.frames, float(np.percentile(self.recent_s, 95))
        line = (
            f"{self.frames} picture{'s' * (self.frames != 1)}, "
            f"waited for {1e3 * mean:.1f} ms on average, "
            f"p95 {1e3 * late:.1f} ms, at most {1e3 * self.longest_s:.1f} ms"
        )
        for count, what in (
            (self.late, "late"),
            (self.dropped, "dropped"),
            (self.rejoined, "rejoined"),
            (self.diverged, "diverged"),
        ):
            line += f"; {what} {'once' if count == 1 else f'{count} times'}" if count else ""
        return line
