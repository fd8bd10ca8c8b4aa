"""Membership of schools, which perception and behavior share."""

from subsea.kernels import kernel
from subsea.state.groups import Minds


@kernel
def known_by(minds: Minds, i: int) -> int:
    """Return the fish by which the school of fish i is known, or i itself without a school."""
    return int(minds.leader[i]) if minds.leader[i] >= 0 else i
