"""Play a show in a dive: its seas and tours, black screens, captions, and its saved state."""

import time
from pathlib import Path
from typing import Protocol

from subsea.base.errors import UserError
from subsea.dive.live_sound import LiveSound
from subsea.dive.presented import Presented, with_show
from subsea.scenario.schema import AUTOPILOT, Scenario
from subsea.stage.show_file import (
    Show,
    faults,
    load_show,
    open_item,
    scenario_name,
    show_digest,
)
from subsea.stage.show_player import ShowPlayer
from subsea.stage.show_state import ShowStore, Tell
from subsea.world import snapshot
from subsea.world.world import World

SAVE_S = 15.0  # between two saved states
REST_S = 0.1  # between two black pictures outside the opening hours


class ItemTours(Protocol):
    """The tours of a dive."""

    def start_item(
        self, tour: str | None, since_s: float, start: tuple[Scenario, Path, int | None] | None
    ) -> None:
        """Begin the tour of an item, or leave the helm to the pilot."""


class ShownDive(Protocol):
    """The parts of a dive that a show changes."""

    world: World
    sound: LiveSound

    @property
    def tours(self) -> ItemTours:
        """The tours."""

    def open_world(
        self, scenario: Scenario, source: Path, seed: int | None = None, keep: bool = False
    ) -> bool:
        """Replace the world."""


class ShowScreens:
    """The show of a dive. `player` has its state and takes cues."""

    def __init__(self, path: Path, tell: Tell) -> None:
        """Read the show and its saved state.

        An item whose scenario or tour is missing is reported; a UserError if no item can be shown.
        """
        self.path, self._tell = path, tell
        self.show: Show = load_show(path)
        bad = dict(faults(self.show, path))
        for fault in bad.values():
            tell(f"{fault}; the sea before it goes on")
        if len(bad) == len(self.show.item):
            raise UserError("no item can be shown", file=path)
        self._store = ShowStore(show_digest(path), tell)
        saved = self._store.load()
        self.player = ShowPlayer(self.show, tell, None if saved is None else saved.progress)
        item, elapsed_s = self.player.progress.item, self.player.progress.elapsed_s
        order = [*range(item, -1, -1), *range(item + 1, len(self.show.item))]
        self.first_scenario = scenario_name(self.show, path, next(k for k in order if k not in bad))
        resumes = saved is not None and saved.progress.item == saved.shown == item
        resumes &= saved is not None and elapsed_s >= saved.progress.elapsed_s
        self._saved = saved if resumes else None
        self._muted: bool | None = None  # the sound before the screens went blank
        self._fresh, self._since_s, self._since_save_s = True, 0.0, 0.0
        self._black = False  # in the last picture

    def restore(self, world: World) -> None:
        """Put the first world, before its first tick in a dive, into the saved state."""
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

    def update(self, dive: ShownDive, elapsed_s: float) -> None:
        """Go on, `elapsed_s` after the last picture."""
        player = self.player
        player.update(elapsed_s)
        due, black = player.due, player.shade >= 1.0
        if due is not None and (self._fresh or self._black):  # a picture later: all screens are
            self._begin(dive, due)
        self._black = black
        self._since_save_s += elapsed_s
        if self._since_save_s > SAVE_S and player.open and player.shown == player.progress.item:
            self._since_save_s = 0.0
            self._store.save(player.progress, player.shown, lambda: snapshot.take(dive.world))

    def rest(self, dive: ShownDive) -> bool:
        """Wait, and be silent, outside the opening hours; True while the screens are blank."""
        closed, sound = self.player.closed, dive.sound
        if closed and self._muted is None:
            self._muted = sound.settings.mute
            sound.change(mute=True)
        elif not closed and self._muted is not None:
            sound.change(mute=self._muted)
            self._muted = None
        if closed:
            time.sleep(REST_S)
        return closed

    def under(self, presenter: Presented) -> Presented:
        """The overlays of a presenter over the black and the caption of the show."""
        return with_show(presenter, self.player.shade, self.player.caption())

    def end(self) -> None:
        """Forget the state: the operator ended the show, and the next one begins by the clock."""
        self._store.close()
        self._store.forget()

    def close(self) -> None:
        """Wait until the state is saved."""
        self._store.close()

    def _begin(self, dive: ShownDive, number: int) -> None:
        """Show an item; one that cannot be shown keeps the sea before it."""
        player, one = self.player, self.show.item[number]
        keeps = self._fresh or (one.scenario is None and player.shown is not None)
        since_s, self._fresh, self._since_s = self._since_s, False, 0.0
        start: tuple[Scenario, Path, int | None] | None = None
        tour = one.tour
        try:
            scenario, source = open_item(self.show, self.path, number)
            if keeps or dive.open_world(scenario, source):
                start = scenario, source, None
        except UserError as fault:
            self._tell(f"item {number + 1}: {fault}; the sea before it goes on")
            tour = None if tour is None else AUTOPILOT
        player.show_item(number)
        dive.tours.start_item(tour, since_s, start)
