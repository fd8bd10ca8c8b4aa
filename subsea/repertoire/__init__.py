"""The contract between capture and playback: the repertoire file and its packing."""

from typing import TYPE_CHECKING, Any

from subsea.repertoire.schema import BASIC_SEGMENTS, SEGMENTS, Repertoire, Segment

if TYPE_CHECKING:
    from subsea.repertoire.files import read_repertoire, write_repertoire

__all__ = [
    "BASIC_SEGMENTS",
    "SEGMENTS",
    "Repertoire",
    "Segment",
    "read_repertoire",
    "write_repertoire",
]


def __getattr__(name: str) -> Any:
    """Import the modules that open files on first use: a dive reads cached data."""
    if name not in ("read_repertoire", "write_repertoire"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from subsea.repertoire import files

    return getattr(files, name)
