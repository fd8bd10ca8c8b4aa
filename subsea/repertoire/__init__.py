"""The contract between capture and playback: the repertoire file and its packing."""

from subsea.repertoire.files import read_repertoire, write_repertoire
from subsea.repertoire.schema import SEGMENTS, Repertoire, Segment

__all__ = ["SEGMENTS", "Repertoire", "Segment", "read_repertoire", "write_repertoire"]
