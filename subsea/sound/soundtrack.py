"""The sound of a dive as a stream of samples, cut into any blocks."""

import wave
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from subsea.base.arrays import Array
from subsea.base.files import replacing
from subsea.sound.mixer import Mixer, SoundLevels
from subsea.sound.moment import GROUPS, Moment, Sources, hear, sources_of
from subsea.sound.space import RATE, Layout, Listener
from subsea.world.world import TICK_S, World

FULL = SoundLevels(volume=1.0)


class Soundtrack:
    """Records what a listener hears, tick by tick."""

    def __init__(self, layout: Layout, levels: SoundLevels = FULL) -> None:
        self.moments: list[Moment] = []
        self._layout, self._levels = layout, levels
        self._sources: tuple[World, Sources] | None = None

    def listen(self, world: World, listener: Listener) -> Moment:
        """Add the tick that the world has just made; returns what is heard in it."""
        if self._sources is None or self._sources[0] is not world:
            self._sources = world, sources_of(world)
        moment = hear(world, listener, self._sources[1])
        self.moments.append(moment)
        return moment

    def render(self, start_s: float, samples: int) -> Array:
        """The `samples` (n, c) float32 from `start_s` seconds of the dive on."""
        return render(self.moments, self._layout, start_s, samples, self._levels)


def render(
    moments: Iterable[Moment], layout: Layout, start_s: float, samples: int,
    levels: SoundLevels = FULL,
) -> Array:  # fmt: skip
    """The samples (n, c) float32 of consecutive moments from `start_s` seconds of the dive on.

    Silent where there is no moment. Any way to cut the samples into calls gives the same ones, as
    each call mixes from the first moment on.
    """
    mixer = Mixer(layout)
    out = np.zeros((samples, layout.channels), np.float32)
    begin = round(start_s * RATE)
    for moment in moments:
        at = round((moment.tick - 1) * TICK_S * RATE) - begin
        if at >= samples:
            break
        block = mixer.mix(moment, levels)
        low, high = max(at, 0), min(at + len(block), samples)
        if low < high:
            out[low:high] = block[low - at : high - at]
    return out


def stems(moments: Iterable[Moment], layout: Layout) -> dict[str, Array]:
    """The samples (n, c) float32 of each group, one after another, at full volume."""
    mixer = Mixer(layout)
    blocks = [np.zeros((len(GROUPS), 0, layout.channels)), *map(mixer.stems, moments)]
    whole = np.concatenate(blocks, axis=1)
    return {name: part.astype(np.float32) for name, part in zip(GROUPS, whole, strict=True)}


def write_wav(path: Path, samples: Array) -> None:
    """Write samples (n, c) in [-1, 1] as a WAV file of 16 bits, completely or not at all."""
    words = np.round(32767.0 * np.clip(samples, -1.0, 1.0)).astype("<i2")
    with replacing(path) as temporary, wave.open(str(temporary), "wb") as file:
        file.setnchannels(words.shape[1])
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes(words.tobytes())
