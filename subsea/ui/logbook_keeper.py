"""Enter into the logbook what the visitor sees, with a picture of it."""

from typing import TYPE_CHECKING

from subsea.base.arrays import Bytes
from subsea.base.errors import UserError
from subsea.base.language import marked, translated
from subsea.dive.logbook import Logbook, framed, logbook_folder, title_of
from subsea.dive.sightings import Sighting, sightings

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

LOOK_S = 0.5  # between two looks
LOOKS = 2  # in which a subject is seen before it is entered


class LogbookKeeper:
    """Looks at each picture of the sea, before text is drawn over it."""

    def __init__(self, dive: "Dive", wanted: bool, kiosk: bool) -> None:
        """Read the user's logbook; that of a `kiosk` lasts for a visit. Unless `wanted`, rest."""
        self._dive, self.wanted = dive, wanted
        self.book = Logbook(logbook_folder() if wanted and not kiosk else None)
        self._seen: dict[str, int] = {}  # looks in a row in which a subject was seen
        self._since_s = 0.0
        self.fault = self.book.read()

    def look(self, elapsed_s: float) -> None:
        """Look at the picture drawn `elapsed_s` after the last, if it is time."""
        dive = self._dive
        self._since_s += elapsed_s
        if self._since_s < LOOK_S or not self.wanted or not self._at_the_window:
            return
        self._since_s = 0.0
        front = dive.picture.front_view
        if front is None:
            return
        seen = list(sightings(dive.world, front, dive.picture.alpha))
        self._seen = {one.subject: self._seen.get(one.subject, 0) + 1 for one in seen}
        for one in seen:
            if one.subject in self.book.visit or self._seen[one.subject] < LOOKS:
                continue
            if dive.picture.fish_at(one.x, one.y) is None:
                continue  # something hides it
            self._enter(one)
            return  # the next one at the next look: a picture takes time

    def photographed(self, pixels: Bytes) -> None:
        """Keep a picture that the visitor takes, for the subjects in it that are known."""
        front = self._dive.picture.front_view
        if not self.wanted or front is None or not self._at_the_window:
            return
        for seen in sightings(self._dive.world, front, self._dive.picture.alpha):
            try:
                self.book.keep_picture(seen.subject, framed(pixels, seen.x, seen.y, seen.size))
            except UserError as fault:
                self._dive.note_fault(str(fault))
                return

    def _enter(self, seen: Sighting) -> None:
        """Enter a subject, and say so if it is new."""
        dive, subject, pixels = self._dive, seen.subject, None
        new = subject not in self.book.entries
        if new and self.book.folder is not None:
            pixels = framed(dive.window_set.picture(), seen.x, seen.y, seen.size)
        try:
            self.book.note(subject, dive.scenario.title, pixels)
        except UserError as fault:
            self.book.folder = None  # the rest of the dive goes on without the disk
            dive.note_fault(str(fault))
        if new:
            words = translated(marked("new in your logbook: {subject}"))
            dive.overlay.note(words.format(subject=title_of(subject)))

    @property
    def _at_the_window(self) -> bool:
        """True if somebody at the helm or on a fish looks at the sea."""
        dive = self._dive
        busy = dive.menu.open or dive.picture.pattern or dive.tours.timer.touring
        return dive.tick_source.has_pilot and not busy
