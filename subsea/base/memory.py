"""Memory of this process: how much of it is resident, and what is free goes back to the system."""

import ctypes
import gc
from contextlib import suppress
from pathlib import Path

STATUS = Path("/proc/self/status")


def give_back_memory() -> None:
    """Free objects that only hold each other, and return free memory to the system.

    glibc keeps what is freed between blocks that are in use. A world with its picture leaves half
    a gigabyte of such gaps when it is made. Call this when one has been made or left.
    """
    gc.collect()
    trim()


def trim() -> None:
    """Return free memory of the allocator to the system; without effect unless it is glibc."""
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)


def resident_mb() -> list[float]:
    """Read the resident memory of this process, MB, in a list; empty without a figure."""
    try:
        status = STATUS.read_text(encoding="ascii")
    except OSError:
        return []
    line = next(line for line in status.splitlines() if line.startswith("VmRSS"))
    return [int(line.split()[1]) / 1024]
