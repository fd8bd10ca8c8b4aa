"""The sound of a dive, volumes, and captions of sounds."""

from collections.abc import Callable

import msgspec

from subsea.base.language import marked, translated
from subsea.dive.settings import SoundSettings
from subsea.sound.device import Open, Player, open_device
from subsea.sound.mixer import SoundLevels
from subsea.sound.moment import HeardSound, Moment, Sources, hear, nearness_of, side_of, sources_of
from subsea.sound.space import Head, Layout, at_rest, layout_of, listener_of
from subsea.world.world import TICK_S, World

STEP = 0.1  # of the volume
SCORE_ON, SCORE_OFF = marked("score on"), marked("score off")
CAPTION_S = 6.0  # until a caption of the same sound may return
SAME_S = 20.0  # until one of a sound that leads may return as near or far as before
BETWEEN_S = 2.0  # from one caption to the next


class LiveSound:
    """Listens to every tick of a world, and plays it."""

    def __init__(
        self,
        settings: SoundSettings,
        note: Callable[[str], object],
        log: Callable[[str], object],
        loudspeakers: Layout | None = None,
        open_one: Open = open_device,
    ) -> None:
        """Silent until a world is given.

        `note` shows volumes and captions, `log` tells of the device. `loudspeakers` replace the
        layout of the settings; without a channel they are silent, and no device is opened.
        """
        layout = layout_of(settings.layout) if loudspeakers is None else loudspeakers
        self.settings = settings
        self.fish: int | None = None  # that listens; None: the pilot
        self.head: Head = at_rest  # of the pilot
        self._note, self._log = note, log
        self._plays = layout.channels > 0
        self._player = Player(layout, self.levels, open_one)
        self._world: World | None = None
        self._sources: Sources | None = None
        # Time of the dive of each sound that had a caption, and of each caption.
        self._said: dict[str, float] = {}

    @property
    def levels(self) -> SoundLevels:
        """The volumes, as the mixer takes them."""
        own = self.settings
        score = own.score_level if own.score else 0.0
        return SoundLevels(own.volume, own.sea, own.fishes, own.vessel, score, own.mute, own.night)

    def attend(self, world: World | None) -> None:
        """Listen to this world from now on, and to no other."""
        if self._world is not None:
            self._world.observers.remove(self._listen)
        self._world, self._sources = world, None if world is None else sources_of(world)
        self._said.clear()
        if world is not None:
            world.observers.append(self._listen)

    def change(self, **settings: object) -> None:
        """Change settings; they are heard at once."""
        self.settings = msgspec.structs.replace(self.settings, **settings)
        self._player.levels = self.levels

    def turn(self, up: bool) -> None:
        """Turn the volume up or down by a step, and the sound on."""
        volume = round(min(max(self.settings.volume + (STEP if up else -STEP), 0.0), 1.0), 2)
        self.change(volume=volume, mute=False)
        self._note(self.text)

    def mute(self) -> None:
        """Turn the sound off or on."""
        self.change(mute=not self.settings.mute)
        self._note(self.text)

    def turn_score(self) -> None:
        """Turn the score on or off."""
        self.change(score=not self.settings.score)
        self._note(translated(SCORE_ON if self.settings.score else SCORE_OFF))

    @property
    def text(self) -> str:
        """The volume in words."""
        if self.settings.mute:
            return translated("sound off")
        return translated("sound {volume}").format(volume=self.volume_text)

    @property
    def volume_text(self) -> str:
        """The volume, for a line about sound."""
        return translated("off") if self.settings.mute else f"{self.settings.volume:.0%}"

    @property
    def missing(self) -> bool:
        """True if sound should be played here, and the system has no device for it."""
        return self._plays and self._player.missing

    def check(self) -> None:
        """Look after the device, once a frame."""
        if self._plays and (line := self._player.check()):
            self._log(line)

    def close(self) -> None:
        """Stop."""
        self.attend(None)
        self._player.close()

    def _listen(self, world: World) -> None:
        if self._sources is None:
            return
        moment = hear(world, listener_of(world, self.fish, self.head), self._sources)
        if self._plays:
            self._player.push(moment)
        if self.settings.captions:
            self._caption(moment)

    def _caption(self, moment: Moment) -> None:
        """Show the sound that leads, or the loudest, unless one was just shown."""
        now = moment.tick * TICK_S
        if now - self._said.get("", -BETWEEN_S) < BETWEEN_S:
            return
        for sound in sorted(moment.words, key=lambda one: (not one.leads, -one.level)):
            if now - self._said.get(sound.words, -CAPTION_S) < CAPTION_S:
                continue
            leads = f"{sound.words}, {nearness_of(sound.away)}" if sound.leads else sound.words
            if sound.leads and now - self._said.get(leads, -SAME_S) < SAME_S:
                continue
            self._said[sound.words] = self._said[leads] = self._said[""] = now
            self._note(caption_of(sound))
            return


def caption_of(sound: HeardSound) -> str:
    """Name a sound, its side and whether it is near, in the language of visitors."""
    side = side_of(sound.way)
    parts = sound.words, side, nearness_of(sound.away) if side else ""
    return f"[{', '.join(translated(part) for part in parts if part)}]"
