"""Overlays of a presenter on all computers of a dive: black, test pattern, caption."""

from typing import Annotated

import msgspec

from subsea.dive.captions import Caption, faded, shown_s

MAX_CAPTION = 300  # characters, as in a direction
BLANK_S = 0.5  # in which the screens become black

Opacity = Annotated[float, msgspec.Meta(ge=0, le=1)]
Number = Annotated[int, msgspec.Meta(ge=0, le=1000)]


class OverlayFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A fisheye picture over the sea, as each computer finds it."""

    file: Annotated[str, msgspec.Meta(max_length=1000)]
    tilt_deg: Annotated[float, msgspec.Meta(ge=0, le=90)]
    angle_deg: Annotated[float, msgspec.Meta(ge=30, le=360)]
    digest: Annotated[str, msgspec.Meta(max_length=64)] = ""  # of the file; empty: any


class Presented(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The overlays of one picture."""

    blank: Opacity = 0.0  # of black over the whole picture
    pattern: bool = False  # the test pattern instead of the sea
    caption: Annotated[str, msgspec.Meta(max_length=MAX_CAPTION)] = ""  # the presenter's own
    opacity: Opacity = 0.0  # of the caption
    # Number of a channel and of its picture of structured light, instead of the sea.
    light: tuple[Number, Number] | None = None
    overlay: OverlayFile | None = None  # over the sea


NOTHING = Presented()


def with_show(presenter: Presented, shade: float, caption: Caption) -> Presented:
    """The overlays of a presenter over the black and the caption of a show."""
    words, opacity = presenter.caption, presenter.opacity
    if not words:
        words, opacity = caption.words[:MAX_CAPTION], caption.opacity
    blank = max(presenter.blank, shade)
    return msgspec.structs.replace(presenter, blank=blank, caption=words, opacity=opacity)


class Presentation:
    """The wishes of a presenter, faded in and out by the wall clock."""

    def __init__(self) -> None:
        self.blank = self.pattern = False
        self.caption = ""
        self._left_s = self._gone_s = 0.0  # of the caption
        self._shade = 0.0

    def show_caption(self, words: str, for_s: float | None = None) -> None:
        """Show a caption for a time, or the time to read it; no words: end the one before."""
        self.caption, self._gone_s = words, 0.0
        self._left_s = shown_s(words, for_s)

    def update(self, elapsed_s: float) -> Presented:
        """The overlays, `elapsed_s` after the last picture."""
        step = elapsed_s / BLANK_S
        self._shade = min(max(self._shade + (step if self.blank else -step), 0.0), 1.0)
        self._gone_s += elapsed_s
        self._left_s -= elapsed_s
        words, opacity = faded(self.caption, self._gone_s, self._left_s)
        self.caption = words
        return Presented(self._shade, self.pattern, words, opacity if words else 0.0)
