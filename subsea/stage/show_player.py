"""Play a show in a dive: its items and cues, black screens, captions, and its saved state.

What a power cut must not erase, the state of a show and the number of dives of each day, is written
whole, to the disk, and renamed.
"""

import os
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from datetime import date, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import msgspec

from subsea.base.errors import UserError
from subsea.base.files import MIB, read_input, remove_abandoned, replacing, text_of
from subsea.base.progress import count_noun, print_line, say
from subsea.base.system import state_folder
from subsea.dive.captions import Caption, faded, shown_s
from subsea.dive.part import DivePart
from subsea.dive.presented import OverlayFile, Presented, with_show
from subsea.frame.diagrams import chosen_diagrams
from subsea.scenario.schema import AUTOPILOT, Scenario
from subsea.scenario.shoals import find_fish
from subsea.stage import opening_hours, show_file
from subsea.stage.overlays import WITHOUT, overlay_faults, read_overlay
from subsea.view.fisheye import Fisheye
from subsea.view.retina import Gaze
from subsea.world import snapshot
from subsea.world.world import World

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

Tell = Callable[[str], object]

MOST_BYTES = 64 * MIB  # of a state
HEAD = "date,dives"


class SavedShow(msgspec.Struct, frozen=True, kw_only=True):
    """A show at a moment, with the sea of its item."""

    form: Literal[1] = 1
    show: str  # digest of its file
    progress: show_file.Progress
    shown: int  # the item that the sea is of
    sea: bytes  # a snapshot


def write_whole(path: Path, data: bytes) -> None:
    """Write a file that a power cut leaves old or new; a UserError if the disk is full."""
    with replacing(path) as part, part.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def once(tell: Tell) -> Tell:
    """Make a function that tells only the first line: a disk that is full stays full."""
    told: list[str] = []

    def first(line: str) -> None:
        if not told:
            told.append(line)
            tell(line)

    return first


class ShowStore:
    """Saves the state of a show in the background."""

    def __init__(self, show: str, tell: Tell) -> None:
        """For the show of that digest; `tell` reports that the disk is full, once."""
        self._path, self._tell = state_folder() / "show.state", tell
        self.show = show
        self._tell_full = once(tell)
        self._pool = ThreadPoolExecutor(1)
        self._writing: Future[None] | None = None

    def load(self) -> SavedShow | None:
        """Read the saved state of this show; None without one."""
        remove_abandoned(self._path.parent, self._path.name)
        try:
            data = read_input(self._path, MOST_BYTES)
            saved = msgspec.msgpack.decode(data, type=SavedShow)
        except UserError as fault:
            if not isinstance(fault.__cause__, FileNotFoundError):
                self._tell(f"{fault}; the show begins again")
            return None
        except (msgspec.DecodeError, RecursionError):
            self._tell(f"{self._path}: not the state of a show; the show begins again")
            return None
        return saved if saved.show == self.show else None

    def save(self, progress: show_file.Progress, shown: int, sea: Callable[[], bytes]) -> None:
        """Save a state, unless the last one is still being written."""
        if self._writing is not None and not self._writing.done():
            return
        self.close()
        saved = SavedShow(show=self.show, progress=progress, shown=shown, sea=sea())
        data = msgspec.msgpack.encode(saved)
        self._writing = self._pool.submit(write_whole, self._path, data)

    def forget(self) -> None:
        """Remove the saved state."""
        with suppress(OSError):
            self._path.unlink()

    def close(self) -> None:
        """Wait until the state is written, and report a fault."""
        if self._writing is not None and (fault := self._writing.exception()):
            self._tell_full(f"{fault}; after a power cut the show would begin earlier")


class DiveCount:
    """Counts visitors' dives by day, in a table that a spreadsheet opens."""

    def __init__(self, tell: Tell) -> None:
        """`tell` reports once that the table cannot be read or written."""
        self._path, self._tell = state_folder() / "dives.csv", once(tell)
        self.days: dict[str, int] = {}
        remove_abandoned(self._path.parent, self._path.name)
        try:
            self.days = _counts(text_of(read_input(self._path), self._path, foreign=True))
        except UserError as fault:
            if not isinstance(fault.__cause__, FileNotFoundError):
                self._tell(str(fault))
        except ValueError:
            aside = self._path.with_name(f"{self._path.name}.damaged")
            self._tell(f"{self._path}: not a table of dives; it is kept as {aside.name}")
            with suppress(OSError):
                self._path.replace(aside)

    def add(self, day: date) -> None:
        """Count a dive of a day."""
        name = day.isoformat()
        self.days[name] = self.days.get(name, 0) + 1
        rows = "".join(f"{day},{number}\n" for day, number in sorted(self.days.items()))
        try:
            write_whole(self._path, f"{HEAD}\n{rows}".encode())
        except UserError as fault:
            self._tell(f"{fault}; dives are counted until this one ends")

    def of(self, day: date) -> int:
        """Count the dives of a day."""
        return self.days.get(day.isoformat(), 0)


def _counts(text: str) -> dict[str, int]:
    """The dives by day; a ValueError for a table of something else."""
    head, *rows = text.splitlines() or [""]
    if head != HEAD:
        raise ValueError(head)
    pairs = (row.split(",", 1) for row in rows)
    return {date.fromisoformat(day).isoformat(): int(number) for day, number in pairs}


def describe_show(path: Path) -> int:
    """Print the timetable of today and what is missing; 1 if anything is.

    At night that of the evening before, while its hours last.
    """
    show, today = show_file.load_show(path), show_file.clock_now().local.date()
    day = opening_hours.day_of(show.calendar, show_file.clock_now().local)
    items = count_noun(len(show.item), "item", "items")
    named = "today" if day == today else "yesterday"
    hours = opening_hours.hours_text(show.calendar, day)
    print_line(f"{show.title or path.name}: {items}, {hours} {named}")
    for start, number in show_file.timetable(show, day):
        print_line(f"{number + 1:>4}  {start:<14}{_described(show.item[number])}")
    if show.repeat:
        print_line("      then from the beginning")
    print_line(f"dives of visitors today: {DiveCount(say).of(today)}")
    missing = [fault for _, fault in show_file.faults(show, path)]
    missing += overlay_faults(show, path)
    for fault in missing:
        say(str(fault))
    return 1 if missing else 0


def _described(item: show_file.ShowItem) -> str:
    parts = [item.scenario or "the same sea", f"tour {item.tour}" if item.tour else "steered"]
    if item.for_s is not None:
        parts.append(f"{item.for_s:g} s")
    if words := item.caption_in("en"):
        parts.append(f"“{words}”")
    return ", ".join(parts)


LOOK_AHEAD_DAYS = 60  # for the next opening
STEP_S = 0.25  # longest step of a fade: a sea was loaded since the last picture


class ShowPlayer:
    """The state of a running show. A console calls `next_cue` and `state`."""

    def __init__(
        self,
        show: show_file.Show,
        tell: Callable[[str], object],
        saved: show_file.Progress | None = None,
        clock: Callable[[], show_file.ShowClock] = show_file.clock_now,
    ) -> None:
        """Begin, or resume what was `saved`; `tell` gets a line on each jump of the clock."""
        self.show, self._tell, self._clock = show, tell, clock
        now = clock()
        self.progress = (
            show_file.begin(show, now) if saved is None else show_file.resume(show, saved, now)
        )
        self.open = opening_hours.is_open(show.calendar, now.local)
        self.shown: int | None = None  # the item whose sea is on the screens
        self.shade = 1.0  # of the screens
        self._cue, self._loaded = False, False
        # An item, and the second in it: that of a presenter, and that of a timecode.
        self._wanted: tuple[int, float] | None = None
        self._chased: tuple[int, float] | None = None
        self._timecode: tuple[int | None, int] = None, 0  # the last item by timecode; its jumps
        self._caption_s = 0.0  # since the shown item became visible

    def next_cue(self) -> None:
        """Go on to the next item now, whatever it waits for."""
        self._cue = True

    def go_to(self, item: int, elapsed_s: float = 0.0) -> None:
        """Go to an item now, as if it had begun `elapsed_s` ago."""
        self._wanted = item, elapsed_s

    def follow(self, time_s: float | None, jumps: int) -> None:
        """Follow a timecode that has jumped `jumps` times; None: it has stopped.

        It starts an item when it passes its time, or has jumped. An item that a cue has begun
        stays until then.
        """
        if time_s is None:
            return
        day = opening_hours.day_of(self.show.calendar, self._clock().local)
        place = show_file.place_at(self.show, time_s, day)
        item = None if place is None else place[0]
        if place is not None and ((item, jumps) != self._timecode or item == self.progress.item):
            self._chased = place
        self._timecode = item, jumps

    def take(self, show: show_file.Show) -> None:
        """Go on with a changed show of as many items."""
        self.show = show

    def state(self) -> dict[str, Any]:
        """The state, for a presenter: docs/reference/console-interface.md."""
        return {
            "title": self.show.title,
            "item": self.progress.item + 1,
            "items": len(self.show.item),
            "programme": self.programme(),
            "special_days": self.special_days(),
            "hours": opening_hours.hours_text(self.show.calendar, self._day),
            "scenario": self.item.scenario,
            "tour": self.item.tour,
            "elapsed_s": self.progress.elapsed_s,
            "next": show_file.waits_for(self.show, self.progress),
            "open": self.open,
            "shade": self.shade,
        }

    def programme(self) -> list[dict[str, Any]]:
        """Describe all items, for a presenter."""
        day = self._day
        return [
            {
                "scenario": item.scenario,
                "tour": item.tour,
                "start": item.start,
                "for_s": item.for_s,
                "caption": item.caption_in("en"),
                "languages": 1 if isinstance(item.caption, str) else len(item.caption),
                "on": self.show.is_on(number, day),
            }
            for number, item in enumerate(self.show.item)
        ]

    def special_days(self) -> list[dict[str, Any]]:
        """Describe the special days, for a presenter; `now` on those that are today."""
        today = self._day
        return [
            {
                "title": day.title,
                "when": day.when,
                "hours": day.hours if isinstance(day.hours, str) else ", ".join(day.hours or ()),
                "now": day.holds(today),
            }
            for day in self.show.special_day
        ]

    @property
    def item(self) -> show_file.ShowItem:
        """The item that is on."""
        return self.show.item[self.progress.item]

    @property
    def closed(self) -> bool:
        """True while the screens are blank outside the opening hours."""
        return not self.open and self.shade >= 1.0

    @property
    def due(self) -> int | None:
        """The item to be shown, once the screens are dark; None: the right one is."""
        wanted = self.open and self.shade >= 1.0 and self.shown != self.progress.item
        return self.progress.item if wanted else None

    def update(self, elapsed_s: float, held: bool = False) -> None:
        """Go on, `elapsed_s` after the last call; while `held`, black screens stay black."""
        now, before = self._clock(), self.progress
        cue, self._cue = self._cue, False
        if not self._loaded:  # loading took time that is not of the show: the clock is right
            before = msgspec.structs.replace(before, utc_s=now.utc_s - elapsed_s)
            self._loaded = True
        if abs(jump := show_file.jump_s(before, now, elapsed_s)) > show_file.JUMP_S:
            way = "forward" if jump > 0.0 else "back"
            self._tell(f"the clock went {way} by {abs(jump):.0f} s; the show goes on")
        was_open, self.open = self.open, opening_hours.is_open(self.show.calendar, now.local)
        if self.open and not was_open:
            self.progress, self.shown = show_file.begin(self.show, now), None
            self._tell("the show opens")
        elif self.open:
            self.progress = show_file.advance(self.show, before, now, elapsed_s, cue)
            if (wanted := self._wanted or (None if cue else self._chased)) is not None:
                item, since_s = wanted
                self.progress = msgspec.structs.replace(self.progress, item=item, elapsed_s=since_s)
        else:
            self.progress = msgspec.structs.replace(before, seen=now.local, utc_s=now.utc_s)
            if was_open:
                self._tell(f"the show closes; {self._next_opening(now)}")
        self._wanted = self._chased = None
        self._fade(elapsed_s, held)

    def show_item(self, item: int) -> None:
        """Note that an item's sea is ready to be seen."""
        if item != self.shown:
            self._caption_s = 0.0
        self.shown = item

    def caption(self) -> Caption:
        """The caption of the shown item, which comes with its first picture.

        In several languages they follow each other.
        """
        if self.shown is None:
            return Caption()
        since_s = self._caption_s
        for words in self.show.captions_of(self.shown):
            length_s = shown_s(words, self.show.item[self.shown].caption_s)
            if words and since_s < length_s:
                return faded(words, since_s, length_s - since_s)
            since_s -= length_s if words else 0.0
        return Caption()

    @property
    def _day(self) -> date:
        """The day of the show, which a night is part of until its hours end."""
        return opening_hours.day_of(self.show.calendar, self.progress.seen)

    def _fade(self, elapsed_s: float, held: bool) -> None:
        """Darken before another item and outside the hours, else lighten."""
        dark = held or not self.open or self.shown != self.progress.item
        given = self.item.fade_s
        fade_s = self.show.fade_s if given is None else given
        elapsed_s = min(elapsed_s, STEP_S)
        step = 1.0 if fade_s == 0.0 else elapsed_s / fade_s
        self.shade = min(max(self.shade + (step if dark else -step), 0.0), 1.0)
        if not dark:
            self._caption_s += elapsed_s

    def _next_opening(self, now: show_file.ShowClock) -> str:
        today, minute = now.local.date(), 60 * now.local.hour + now.local.minute
        for day in (today + timedelta(days=k) for k in range(LOOK_AHEAD_DAYS)):
            for first, _ in opening_hours.spans_on(self.show.calendar, day):
                if day > today or first > minute:
                    at = opening_hours.clock_text(first)
                    return f"it opens at {at}" if day == today else f"it opens on {day} at {at}"
        return "no day on which it opens is near"


SAVE_S = 15.0  # between two saved states
REST_S = 0.1  # between two black pictures outside the opening hours


class ShowScreens(DivePart):
    """The show of a dive. `player` has its state and takes cues."""

    leads = True

    def __init__(self, path: Path, tell: Tell) -> None:
        """Read the show and its saved state.

        An item whose scenario or tour is missing is reported; a UserError if no item can be shown.
        """
        self.path, self._tell = path, tell
        self.show: show_file.Show = show_file.load_show(path)
        bad = dict(show_file.faults(self.show, path))
        for fault in bad.values():
            tell(f"{fault}; the sea before it goes on")
        for fault in overlay_faults(self.show, path):
            tell(f"{fault}; {WITHOUT}")
        if len(bad) == len(self.show.item):
            raise UserError("no item can be shown", file=path)
        self._store = ShowStore(show_file.show_digest(path), tell)
        saved = self._store.load()
        self.player = ShowPlayer(self.show, tell, None if saved is None else saved.progress)
        item, elapsed_s = self.player.progress.item, self.player.progress.elapsed_s
        order = [*range(item, -1, -1), *range(item + 1, len(self.show.item))]
        self.first_scenario = show_file.scenario_name(
            self.show, path, next(k for k in order if k not in bad)
        )
        resumes = saved is not None and saved.progress.item == saved.shown == item
        resumes &= saved is not None and elapsed_s >= saved.progress.elapsed_s
        self._saved = saved if resumes else None
        self._muted: bool | None = None  # the sound before the screens went blank
        self._fresh, self._since_s, self._since_save_s = True, 0.0, 0.0
        self._black = False  # in the last picture
        self._overlay: OverlayFile | None = None  # over the sea of the item
        self._given: tuple[frozenset[str], bool] | None = None  # diagrams and wireframe

    def restore(self, world: World) -> None:
        """Put the first world, before its first tick, where a power cut ended the show."""
        saved, self._saved = self._saved, None
        if saved is None:
            return
        try:
            snapshot.restore(world, saved.sea)
        except UserError as fault:
            self._tell(f"{fault}; the sea of this item begins again")
            return
        self._since_s = saved.progress.elapsed_s
        self._tell(f"the show goes on at item {saved.shown + 1}, second {self._since_s:.0f}")

    def before(self, dive: "Dive", elapsed_s: float) -> bool:
        """Go on; all is black and silent outside the opening hours."""
        player = self.player
        player.update(elapsed_s, dive.tick_source.gathering)
        due, black = player.due, player.shade >= 1.0
        ready = self._fresh or self._black  # a picture later: all screens are
        if due is not None and ready and not dive.restarts:
            self._begin(dive, due)
        self._black = black
        self._since_save_s += elapsed_s
        if self._since_save_s > SAVE_S and player.open and player.shown == player.progress.item:
            self._since_save_s = 0.0
            self._store.save(player.progress, player.shown, lambda: snapshot.take(dive.world))
        closed, sound = player.closed, dive.sound
        if closed and self._muted is None:
            self._muted = sound.settings.mute
            sound.change(mute=True)
        elif not closed and self._muted is not None:
            sound.change(mute=self._muted)
            self._muted = None
        if closed:
            time.sleep(REST_S)
        return closed

    def over(self, presented: Presented) -> Presented:
        """Lay the black, the caption and the overlay of the show under those of a presenter."""
        shown = with_show(presented, self.player.shade, self.player.caption())
        return msgspec.structs.replace(shown, overlay=self._overlay)

    def cue(self) -> None:
        """Go on to the next item."""
        self.player.next_cue()

    def go_to(self, number: int) -> None:
        """Go to an item, counted from 0; a UserError if there is none, or the show is closed."""
        if not 0 <= number < len(self.show.item):
            raise UserError(f"item {number + 1}: expected 1 to {len(self.show.item)}")
        if not self.player.open:
            raise UserError("the show is closed now")
        self.player.go_to(number)

    def take(self, show: show_file.Show) -> None:
        """Go on with the changed file."""
        self.show = show
        self.player.take(show)
        self._store.show = show_file.show_digest(self.path)

    def may_end(self) -> bool:
        """True while the screens are black before the next item, or outside the opening hours."""
        return self.player.closed or self.player.due is not None

    def end(self, dive: "Dive") -> None:
        """Save the state of a dive that starts again, and else forget it.

        Where the operator ended the show, the next one begins by the clock.
        """
        self._store.close()
        if dive.restarts and self.player.shown is not None:
            self._store.save(
                self.player.progress, self.player.shown, lambda: snapshot.take(dive.world)
            )
        elif not dive.restarts:
            self._store.forget()

    def close(self) -> None:
        """Wait until the state is saved."""
        self._store.close()

    def _begin(self, dive: "Dive", number: int) -> None:
        """Show an item; one that cannot be shown keeps the sea before it."""
        player, item = self.player, self.show.item[number]
        keeps = self._fresh or (item.scenario is None and player.shown is not None)
        since_s, self._fresh, self._since_s = self._since_s, False, 0.0
        start: tuple[Scenario, Path, int | None] | None = None
        tour = item.tour
        try:
            scenario, source = show_file.open_item(self.show, self.path, number)
            if keeps or dive.open_world(scenario, source):
                start = scenario, source, None
        except UserError as fault:
            self._tell(f"item {number + 1}: {fault}; the sea before it goes on")
            tour = None if tour is None else AUTOPILOT
        player.show_item(number)
        dive.tours.start_item(tour, since_s, start)
        self._draw_as(dive, item, start is not None)

    def _read_overlay(self, item: show_file.ShowItem) -> Fisheye | None:
        """Read the picture over the sea of an item; one that is gone is a line."""
        self._overlay = None
        if item.overlay is None:
            return None
        try:
            shown, self._overlay = read_overlay(self.path.parent, item.overlay.picture)
        except UserError as fault:
            self._tell(f"{fault}; {WITHOUT}")
            return None
        return shown

    def _draw_as(self, dive: "Dive", item: show_file.ShowItem, opened: bool) -> None:
        """Show what an item says of its fishes, and look at or through one of them.

        Without keys of its own an item is drawn as the options of the dive say.
        """
        if self._given is None:
            picture = dive.picture
            self._given = frozenset(picture.diagrams), picture.wireframe
        diagrams, wireframe = self._given
        dive.picture.diagrams = {*diagrams, *chosen_diagrams(",".join(item.show))}
        dive.picture.wireframe = wireframe or item.wireframe
        dive.picture.bodies = item.bodies
        dive.picture.overlay = self._read_overlay(item)
        name, fish = item.eyes or item.follow, None
        if opened and name is not None:
            fish = find_fish(name, dive.world.scenario)
        if fish is not None and not dive.world.state.fishes.alive[fish]:
            self._tell(f"fish {name} of this item no longer lives; the submarine looks on")
            fish = None
        dive.picture.eyes_shown = item.eyes is not None or name is None
        if fish is not None:
            dive.ride_fish(fish, behind=item.eyes is None)
            if dive.picture.ride is not None:
                dive.picture.ride.gaze = Gaze(*item.gaze_deg)
