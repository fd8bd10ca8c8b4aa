"""Keep the logbook of a visitor: species met, behaviors seen, and a picture of each.

It lies in the user's own data folder and is sent nowhere. A damaged file is set aside.
"""

import base64
import html
from collections.abc import Collection, Mapping
from datetime import date
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from subsea.base.arrays import Bytes
from subsea.base.errors import UserError
from subsea.base.files import check_file, read_input, replacing
from subsea.base.language import language, marked, translated
from subsea.base.system import own_path
from subsea.dive.sightings import BEHAVIORS
from subsea.fish.species import load_species, shipped_species

FILE = "logbook.json"
SIDE_PX = 640  # longest side of a kept picture
ROOM, LEAST_CUT = 2.5, 0.25  # height of a picture: over the length of its fish; share at least
LONGEST = 1 << 20  # bytes of the file, and of a picture
SPECIES, SEEN = marked("Species met"), marked("Behaviors seen")

Text = Annotated[str, Meta(max_length=200)]


class LogEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The first time that a subject was seen."""

    day: date
    place: Text  # title of the scenario
    picture: Annotated[str, Meta(pattern=r"^[\w -]{0,80}$")] = ""  # name of its file, no suffix
    visits: int = 1  # in which it was seen


class _File(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    version: int = 1
    entries: dict[Text, LogEntry] = {}


class Logbook:
    """The entries by subject: a name of a species, or a key of `sightings.BEHAVIORS`."""

    def __init__(self, folder: Path | None = None) -> None:
        """Start empty. Nothing is kept without a `folder`."""
        self.folder, self.entries = folder, dict[str, LogEntry]()
        self.visit: dict[str, bool] = {}  # subjects of this visit; True: seen for the first time

    def read(self) -> str:
        """Read the file; returns a line about a damaged one, which is set aside, else ""."""
        if self.folder is None or not (path := self.folder / FILE).exists():
            return ""
        try:
            self.entries = msgspec.json.decode(read_input(path, LONGEST), type=_File).entries
        except (msgspec.DecodeError, UserError, OSError, ValueError):
            aside = _unused(path.with_name("logbook-damaged.json"))
            try:
                path.rename(aside)
            except OSError as fault:
                self.folder = None  # nothing is replaced
                return f"{path}: the logbook is damaged, and stays: {fault.strerror}"
            return f"{path}: the logbook was damaged; it is now {aside.name}, and a new one begins"
        return ""

    def note(self, subject: str, place: str, pixels: Bytes | None = None) -> bool:
        """Note a subject that is seen now, once a visit; True if it is new in the logbook.

        `pixels` (h, w, 3) is the picture of a new one. UserError if it cannot be written; then
        the entry is kept until the end of the dive.
        """
        if subject in self.visit:
            return False
        before = self.entries.get(subject)
        self.visit[subject] = before is None
        if before is not None:
            self.entries[subject] = msgspec.structs.replace(before, visits=before.visits + 1)
            self._write()
            return False
        self.entries[subject] = LogEntry(date.today(), place[:200])
        if pixels is None:
            self._write()
        else:
            self.keep_picture(subject, pixels)
        return True

    def keep_picture(self, subject: str, pixels: Bytes) -> None:
        """Replace the picture of a subject by one that the visitor took; UserError as `note`."""
        if self.folder is None or subject not in self.entries:
            return
        name = _file_name(subject)
        write_jpeg(self.folder / f"{name}.jpg", pixels)
        self.entries[subject] = msgspec.structs.replace(self.entries[subject], picture=name)
        self._write()

    def picture(self, subject: str) -> Path | None:
        """The picture of a subject; None without one."""
        entry = self.entries.get(subject)
        if self.folder is None or entry is None or not entry.picture:
            return None
        return self.folder / f"{entry.picture}.jpg"

    def forget_visit(self) -> None:
        """Begin another visit."""
        self.visit.clear()
        if self.folder is None:
            self.entries.clear()

    def _write(self) -> None:
        if self.folder is None:
            return
        path = self.folder / FILE
        check_file(path)
        with replacing(path) as part:
            part.write_bytes(msgspec.json.format(msgspec.json.encode(_File(1, self.entries))))


def logbook_folder() -> Path:
    """The folder of the user's logbook, which may be missing."""
    return own_path("logbook")


def _file_name(subject: str) -> str:
    return "".join(letter if letter.isalnum() else "-" for letter in subject)[:80]


def framed(pixels: Bytes, x: float, y: float, size: float) -> Bytes:
    """Cut the part of a picture (h, w, 3) around a fish at (x, y) of a `size`, as `Sighting`."""
    height, width = pixels.shape[:2]
    high = min(max(round(ROOM * size * height), round(LEAST_CUT * height)), height)
    wide = min(round(16 / 9 * high), width)
    left = min(max(round(x * width - wide / 2), 0), width - wide)
    top = min(max(round(y * height - high / 2), 0), height - high)
    return pixels[top : top + high, left : left + wide]


def write_jpeg(path: Path, pixels: Bytes) -> None:
    """Write a picture (h, w, 3), scaled to at most SIDE_PX, whole or not at all."""
    from PIL import Image

    image = Image.fromarray(pixels)
    image.thumbnail((SIDE_PX, SIDE_PX))
    check_file(path)
    with replacing(path) as part:
        image.save(part, "JPEG", quality=88)


def title_of(subject: str) -> str:
    """The title of a subject, in the language of visitors."""
    return translated(BEHAVIORS[subject].title if subject in BEHAVIORS else subject)


def hint_of(subject: str) -> str:
    """A hint where to look for a behavior, in the language of visitors; "" for a species."""
    return translated(BEHAVIORS[subject].hint) if subject in BEHAVIORS else ""


def subjects(entries: Collection[str]) -> tuple[list[str], list[str]]:
    """The species, and the behaviors, of a logbook: all that are shipped or in its `entries`."""
    shipped = [load_species(name).name for name in shipped_species()]
    own = [name for name in entries if name not in BEHAVIORS and name not in shipped]
    return shipped + sorted(own), list(BEHAVIORS)


STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem;
  color: #10303c; background: #f6fafb }
h1 { font-weight: 300; font-size: 2.4rem; margin: 0 } h2 { font-weight: 400; margin-top: 2.2rem }
.all { display: grid; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); gap: 1.2rem }
figure { margin: 0; break-inside: avoid } img { width: 100%; border-radius: .4rem; display: block }
figcaption { font-size: .9rem; padding-top: .3rem } figcaption b { font-size: 1rem }
.not { border: 1px dashed #9db8c0; border-radius: .4rem; padding: .8rem; color: #47646d }
@media print { body { margin: 0; background: none } .not { display: none } }
"""


def page_of(book: Logbook, visit: Mapping[str, bool] | None = None) -> str:
    """The logbook, or one `visit`, as a page that can be printed, with its pictures inside."""
    species, behaviors = subjects(book.entries)
    heading = translated(marked("Logbook") if visit is None else marked("My visit under water"))
    parts = [
        f'<!doctype html><html lang="{language()}"><meta charset="utf-8">'
        f"<title>{html.escape(heading)}</title><style>{STYLE}</style><h1>{html.escape(heading)}"
        f"</h1><p>{date.today():%Y-%m-%d}</p>"
    ]
    for title, those in ((SPECIES, species), (SEEN, behaviors)):
        seen = [one for one in those if one in book.entries and (visit is None or one in visit)]
        counted = f"{translated(title)}: {len(seen)} / {len(those)}"
        parts.append(f'<h2>{html.escape(counted)}</h2><div class="all">')
        parts += [_figure(book, one) for one in seen]
        if visit is None:
            parts += [
                f'<div class="not"><b>{html.escape(title_of(one))}</b><br>'
                f"{html.escape(hint_of(one))}</div>"
                for one in those
                if one not in book.entries
            ]
        parts.append("</div>")
    return "\n".join(parts) + "\n"


def _figure(book: Logbook, subject: str) -> str:
    entry, path = book.entries[subject], book.picture(subject)
    picture = ""
    if path is not None and path.is_file():
        data = base64.b64encode(read_input(path, LONGEST)).decode()
        picture = f'<img alt="" src="data:image/jpeg;base64,{data}">'
    about = f"{translated(entry.place)}, {entry.day:%Y-%m-%d}"
    return (
        f"<figure>{picture}<figcaption><b>{html.escape(title_of(subject))}</b><br>"
        f"{html.escape(about)}</figcaption></figure>"
    )


def write_page(book: Logbook, folder: Path, visit: Mapping[str, bool] | None = None) -> Path:
    """Write `page_of` into a folder; returns the path of the page."""
    name = "subsea-logbook" if visit is None else "subsea-visit"
    path = _unused(folder / f"{name}-{date.today():%Y-%m-%d}.html")
    check_file(path)
    with replacing(path) as part:
        part.write_text(page_of(book, visit), encoding="utf-8")
    return path


def _unused(path: Path) -> Path:
    number, free = 1, path
    while free.exists():
        number += 1
        free = path.with_name(f"{path.stem}-{number}{path.suffix}")
    return free
