"""The sound of a film, heard at the eye, tick by tick."""

import wave
from collections.abc import Callable
from pathlib import Path

import numpy as np

from subsea.base.arrays import Array
from subsea.base.file_kinds import SOUND, check_result
from subsea.base.files import check_folder, replacing
from subsea.sound.mixer import Mixer, SoundLevels
from subsea.sound.moment import GROUPS, SCORE, Sources, hear, sources_of
from subsea.sound.space import BLOCK, RATE, Layout, listener_at, listener_of
from subsea.view.rig import CameraPose
from subsea.world.world import World

Reader = Callable[[float], Array]
"""Returns the samples (n, c) from where the last call ended to a time of the film, s."""


class FilmSound:
    """Mixes a dive for films that begin `start_s` seconds after it.

    Samples are kept until all readers have taken them. With `files` all are kept for `whole`, and
    those of each group for `stems`.
    """

    def __init__(
        self, layout: Layout, start_s: float, levels: SoundLevels, files: bool = False
    ) -> None:
        self.layout = layout
        self._mixer, self._levels, self._files = Mixer(layout), levels, files
        self._sources: Sources | None = None
        self._skipped = -round(start_s * RATE)  # samples so far since the film's beginning
        self._readers: list[list[Array]] = []  # samples that each has not taken
        self._whole: list[Array] = []
        self._stems: list[Array] = []

    def listen(
        self, world: World, fish: int | None = None, camera: CameraPose | None = None
    ) -> None:
        """Add the tick that the world has just made, heard from the submarine, or from a fish.

        Left is that of the `camera`, if it is given.
        """
        self._sources = self._sources or sources_of(world)
        listener = listener_of(world, fish)
        if camera is not None:
            listener = listener._replace(axes=listener_at(camera, listener.velocity, True).axes)
        moment = hear(world, listener, self._sources)
        stems = self._mixer.stems(moment, scored=self._levels.score > 0.0)
        block = self._mixer.blend(stems, self._levels)
        first = max(-self._skipped, 0)
        self._skipped += BLOCK
        if first >= BLOCK:  # before the film
            return
        for pending in self._readers:
            pending.append(block[first:])
        if self._files:
            self._whole.append(block[first:])
            self._stems.append(stems[:, first:].astype(np.float32))

    def reader(self) -> Reader:
        """A reader from the beginning of the film, made before anything is heard."""
        pending: list[Array] = []
        self._readers.append(pending)
        taken = 0

        def read(until_s: float) -> Array:
            nonlocal taken
            samples = self._joined(pending)
            found = samples[: max(round(until_s * RATE) - taken, 0)]
            taken += len(found)
            pending[:] = [samples[len(found) :]]
            return found

        return read

    def whole(self, seconds: float) -> Array:
        """All samples (n, c) of a film of this length."""
        return self._joined(self._whole)[: round(seconds * RATE)]

    def stems(self, seconds: float) -> dict[str, Array]:
        """The samples (n, c) of each group of a film of this length, at full volume."""
        names = GROUPS if self._levels.score > 0.0 else GROUPS[:SCORE]
        nothing = np.zeros((len(names), 0, self.layout.channels), np.float32)
        parts = np.concatenate([nothing, *self._stems], axis=1)[:, : round(seconds * RATE)]
        return dict(zip(names, parts, strict=True))

    def _joined(self, blocks: list[Array]) -> Array:
        return np.concatenate([np.zeros((0, self.layout.channels), np.float32), *blocks])


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


def write_wav(path: Path, samples: Array) -> None:
    """Write samples (n, c) in [-1, 1] as a WAV file of 16 bits, completely or not at all."""
    words = np.round(32767.0 * np.clip(samples, -1.0, 1.0)).astype("<i2")
    with replacing(path) as temporary, wave.open(str(temporary), "wb") as file:
        file.setnchannels(words.shape[1])
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes(words.tobytes())
