"""Wants that perception and behavior share: of food from the submarine, and to be cleaned."""

from subsea.kernels import kernel
from subsea.state.codes import HUNGER, PREDATOR
from subsea.state.groups import Minds, Nature, Sea

TEMPTING = 0.4  # share of `keen` above which a fish is hungry enough for food from the submarine
ITCH_BEGINS, ITCH_ENDS = 0.6, 0.3  # itch at which it goes to a cleaner, and at which it leaves


@kernel
def takes_scattered(minds: Minds, i: int, nature: Nature) -> bool:
    """Return True if fish i is hungry enough for food from the submarine."""
    return bool(minds.mental[i, HUNGER] > TEMPTING * nature.keen)


@kernel
def is_tempted(minds: Minds, i: int, sea: Sea, nature: Nature) -> bool:
    """Return True if the food of fish i is from the submarine, and it is hungry enough for it."""
    k = minds.food[i]
    tempts = k >= 0 and sea.absent[k] < 0.0 and minds.kind[i] != PREDATOR
    return bool(tempts and takes_scattered(minds, i, nature))
