"""Record of one node that the master keeps."""

import math
from collections import deque
from dataclasses import dataclass, field

from subsea.stage.cluster.gate import Connection
from subsea.stage.cluster.waits import WaitStatistics

SOON_S = 60.0  # a node that diverges twice within this time is refused
MAX_REFUSALS = 5  # reported of a node within SOON_S
MAX_ASKED = 20  # requests of a node whose times are kept


@dataclass
class NodeRecord:
    """The state of a node as the master sees it."""

    name: str
    route: bytes | None = None  # its connection; None: not connected
    connection: Connection | None = None  # the same for the gate
    tick: int = 0  # of its world when it came, if that is of a dive
    asks: bool = False  # True if it needs the state
    sent_s: float = -math.inf  # when the state was sent
    asked_s: deque[float] = field(default_factory=lambda: deque(maxlen=MAX_ASKED))
    out_until_s: float = 0.0  # end of the time for which it was put out
    in_step: bool = False  # True if the master waits for it
    drawn: int = 0  # number of its last picture ...
    drawn_s: float = 0.0  # ... and when it was drawn
    not_before_s: float = 0.0  # the master does not wait for it before
    diverged_s: float = -SOON_S
    came: bool = False  # True if it has been in step before
    refusal: str = ""  # why a node of its name was refused ...
    refused_s: deque[float] = field(  # ... and when that was reported
        default_factory=lambda: deque([-math.inf] * MAX_REFUSALS, MAX_REFUSALS)
    )
    waits: WaitStatistics = field(default_factory=WaitStatistics)
