"""The processors of this computer."""

import os


def cores() -> int:
    """Number of processor cores that this process may use."""
    here = getattr(os, "sched_getaffinity", None)
    return len(here(0)) if here else os.cpu_count() or 1
