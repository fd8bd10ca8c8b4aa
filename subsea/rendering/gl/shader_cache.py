"""The shader cache of the graphics driver."""

import os
import shutil
from contextlib import suppress
from pathlib import Path

MIN_FREE_BYTES = 256 << 20


def avoid_full_disk() -> None:
    """Turn Mesa's shader cache off on an almost full disk; call this before a context is made.

    Mesa maps the index of its cache into memory. If the disk has no room left when it writes there,
    the system ends the process (SIGBUS).
    """
    folder = Path(
        os.environ.get("MESA_SHADER_CACHE_DIR")
        or os.environ.get("XDG_CACHE_HOME")
        or Path.home() / ".cache"
    ).absolute()
    with suppress(OSError):
        there = next(place for place in (folder, *folder.parents) if place.exists())
        if shutil.disk_usage(there).free < MIN_FREE_BYTES:
            os.environ.setdefault("MESA_SHADER_CACHE_DISABLE", "true")
