"""Statistics of the wait times for a node."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

RECENT = 10_000  # pictures in the 95th percentile


@dataclass
class WaitStatistics:
    """Wait times of one node in seconds, and counts of events."""

    frames: int = 0  # pictures shown in step
    total_s: float = 0.0
    longest_s: float = 0.0
    recent_s: deque[float] = field(default_factory=lambda: deque(maxlen=RECENT))
    late: int = 0  # timeouts
    dropped: int = 0  # lost connections
    rejoined: int = 0  # returns
    diverged: int = 0  # times that its world differed

    def add(self, wait_s: float) -> None:
        """Add the time from the master's picture to the node's."""
        self.frames += 1
        self.total_s += wait_s
        self.longest_s = max(self.longest_s, wait_s)
        self.recent_s.append(wait_s)

    @property
    def mean_s(self) -> float:
        """Mean wait time."""
        return self.total_s / max(self.frames, 1)

    def words(self) -> str:
        """One line with the number of pictures, the wait times and the events."""
        late = float(np.percentile(self.recent_s, 95)) if self.frames else 0.0
        line = (
            f"{self.frames} picture{'s' * (self.frames != 1)}, "
            f"waited for {1e3 * self.mean_s:.1f} ms on average, "
            f"p95 {1e3 * late:.1f} ms, at most {1e3 * self.longest_s:.1f} ms"
        )
        for what in ("late", "dropped", "rejoined", "diverged"):
            count = getattr(self, what)
            line += f"; {what} {'once' if count == 1 else f'{count} times'}" if count else ""
        return line
