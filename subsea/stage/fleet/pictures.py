"""Small pictures of nodes: bounded JPEGs, cut into parts that fit a message and joined again."""

from collections.abc import Iterator
from io import BytesIO

from subsea.base.arrays import Bytes
from subsea.stage.cluster.messages import PART
from subsea.stage.fleet.messages import MOST_PICTURE, PicturePart

QUALITIES = 70, 50, 30, 10
BEGINS, ENDS = b"\xff\xd8\xff", b"\xff\xd9"  # of a JPEG


def bounded_jpeg(pixels: Bytes) -> bytes:
    """Make a JPEG of pixels (h, w, 3 or more) of at most MOST_PICTURE bytes, smaller if need be."""
    from PIL import Image

    image = Image.fromarray(pixels[..., :3])
    while True:
        for quality in QUALITIES:
            out = BytesIO()
            image.save(out, "JPEG", quality=quality)
            if out.tell() <= MOST_PICTURE:
                return out.getvalue()
        image = image.reduce(2)


def parts_of(jpeg: bytes) -> Iterator[PicturePart]:
    """Cut a JPEG into messages."""
    for offset in range(0, len(jpeg), PART):
        yield PicturePart(len(jpeg), offset, jpeg[offset : offset + PART])


class PictureJoin:
    """Joins the parts of one node's pictures."""

    def __init__(self) -> None:
        self._data, self._size = bytearray(), 0

    def add(self, part: PicturePart) -> bytes | None:
        """Add a part; returns the whole JPEG with the last one. Parts out of order are dropped."""
        if part.offset == 0:
            self._data, self._size = bytearray(), part.size
        if part.offset != len(self._data) or part.size != self._size:
            self._data.clear()
            return None
        self._data += part.data
        if len(self._data) < self._size:
            return None
        jpeg = bytes(self._data)
        self._data.clear()
        fits = len(jpeg) == self._size and jpeg.startswith(BEGINS) and jpeg.endswith(ENDS)
        return jpeg if fits else None
