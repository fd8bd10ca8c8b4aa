"""The sound of a film, heard at the eye, tick by tick."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from subsea.core.arrays import Array
from subsea.core.atomic_io import check_folder
from subsea.core.file_kinds import SOUND, check_result
from subsea.sound.listening import listener_of
from subsea.sound.mixer import Mixer, SoundLevels
from subsea.sound.soundtrack import Soundtrack, stems, write_wav
from subsea.sound.space import BLOCK, RATE, Layout
from subsea.world.world import World

Reader = Callable[[float], Array]
"""Returns the samples (n, c) from where the last call ended to a time of the film, s."""


class FilmSound:
    """Records a dive for films that begin `start_s` seconds after it."""

    def __init__(self, layout: Layout, start_s: float, levels: SoundLevels) -> None:
        self.layout = layout
        self.track = Soundtrack(layout)
        self._mixer, self._levels = Mixer(layout), levels
        self._begin = round(start_s * RATE)
        self._blocks: list[Array] = []  # of each tick since the dive began

    def listen(self, world: World, fish: int | None = None) -> None:
        """Add the tick that the world has just made, heard from the submarine, or from a fish."""
        moment = self.track.listen(world, listener_of(world, fish))
        silence = np.zeros((BLOCK, self.layout.channels), np.float32)
        self._blocks += [silence] * (moment.tick - 1 - len(self._blocks))
        self._blocks.append(self._mixer.mix(moment, self._levels))

    def reader(self) -> Reader:
        """A reader from the beginning of the film."""
        position = self._begin

        def read(until_s: float) -> Array:
            nonlocal position
            begin, end = position, min(self._begin + round(until_s * RATE), self._end)
            position = max(begin, end)
            return self._cut(begin, position)

        return read

    @property
    def _end(self) -> int:
        return len(self._blocks) * BLOCK

    def whole(self, seconds: float) -> Array:
        """All samples (n, c) of a film of this length."""
        return self.reader()(seconds)

    def stems(self, seconds: float) -> dict[str, Array]:
        """The samples (n, c) of each group of a film of this length, at full volume."""
        first = self.track.moments[0].tick - 1 if self.track.moments else 0
        begin = self._begin - first * BLOCK
        return {
            name: samples[max(begin, 0) : begin + round(seconds * RATE)]
            for name, samples in stems(self.track.moments, self.layout).items()
        }

    def _cut(self, begin: int, end: int) -> Array:
        """Samples of the dive from one index to another."""
        if end <= begin:
            return np.zeros((0, self.layout.channels), np.float32)
        first = begin // BLOCK
        part = np.concatenate(self._blocks[first : -(-end // BLOCK)])
        return part[begin - first * BLOCK : end - first * BLOCK]


def check_sound_files(audio: Path | None, stems: Path | None, force: bool) -> None:
    """Raise a UserError unless the files of a film's sound can be written."""
    if audio is not None:
        check_result(audio, SOUND, force)
    if stems is not None:
        check_folder(stems)


def write_sound(sound: FilmSound, seconds: float, audio: Path | None, folder: Path | None) -> None:
    """Write the sound of a film as a WAV file, and each group as one in a folder."""
    if audio is not None:
        write_wav(audio, sound.whole(seconds))
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        for name, samples in sound.stems(seconds).items():
            write_wav(folder / f"{name}.wav", samples)
