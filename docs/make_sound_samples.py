"""Make the sound samples and the spectrograms: `python docs/make_sound_samples.py`.

Writes docs/sounds/*.m4a and docs/pictures/sound.png, and prints levels and the cost of a tick.
"""

import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import av
import matplotlib.pyplot as plt
import numpy as np
from picture_files import STYLE, output_folder, save_plot

from subsea.dive.directed_camera import tour_steering
from subsea.media.film_sound import FilmSound
from subsea.scenario.load import load_scenario
from subsea.sound.mixer import SoundLevels
from subsea.sound.space import LAYOUTS, RATE
from subsea.submarine.vessel import Helm
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World

SOUNDS = Path(__file__).parent / "sounds"
SECONDS = 8.0
BITS_S = 128_000
SHRIMP_HZ = (2000, 15_000)  # the band of snapping shrimp (Everest et al. 1948)
AHEAD = Helm(surge=1.0, yaw=0.15)


class Sample(NamedTuple):
    """A part of a dive."""

    title: str
    scenario: str
    start_s: float
    fish: int | None = None  # that listens
    steer: Callable[[World], Any] | None = None  # None: the autopilot


SAMPLES = {
    "reef": Sample("The reef of peaceful, beside a vent", "peaceful", 12.0),
    "school": Sample("A school that a shark chases, heard by a fish of it", "preying", 10.0, 3),
    "vessel": Sample("Full speed ahead", "schooling", 3.0, None, lambda world: AHEAD),
}


def record(sample: Sample) -> np.ndarray:
    """The samples (n, 2) of a part of a dive."""
    world = create_world(load_scenario(sample.scenario)[0])
    steer = sample.steer or tour_steering(world, "auto")
    track = FilmSound(LAYOUTS["stereo"], sample.start_s, SoundLevels(1.0), files=True)
    spent = time.process_time()
    stepping = 0.0
    while world.state.tick * TICK_S < sample.start_s + SECONDS:
        begin = time.process_time()
        step(world, steer(world))
        stepping += time.process_time() - begin
        track.listen(world, sample.fish)
    samples = track.whole(SECONDS)
    spent = time.process_time() - spent - stepping
    share = spent / (world.state.tick * TICK_S)
    level = 20.0 * np.log10(np.sqrt((samples**2).mean()))
    print(
        f"{sample.title}: peak {np.abs(samples).max():.2f}, {level:.0f} dBFS, {share:.1%} of a core"
    )
    return samples


def write(path: Path, samples: np.ndarray) -> None:
    """Write samples (n, 2) as AAC."""
    with av.open(str(path), "w", format="mp4") as container:
        stream: Any = container.add_stream("aac", rate=RATE, layout="stereo")
        stream.bit_rate = BITS_S
        frame = av.AudioFrame.from_ndarray(
            np.ascontiguousarray(samples.T), format="fltp", layout="stereo"
        )
        frame.sample_rate, frame.pts, frame.time_base = RATE, 0, Fraction(1, RATE)
        container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    print(f"{path}: {path.stat().st_size / 1024:.0f} KiB")


def main() -> None:
    """Write the samples and the figure."""
    SOUNDS.mkdir(exist_ok=True)
    plt.rcParams.update(STYLE)
    figure, axes = plt.subplots(len(SAMPLES), 1, figsize=(9, 8), sharex=True, layout="tight")
    for axis, (name, sample) in zip(axes, SAMPLES.items(), strict=True):
        samples = record(sample)
        write(SOUNDS / f"{name}.m4a", samples)
        axis.specgram(samples[:, 0], NFFT=1024, Fs=RATE, noverlap=512, vmin=-125, vmax=-45)
        axis.set_yscale("symlog", linthresh=500)
        axis.set_ylim(30, RATE / 2)
        axis.set_yticks([100, 500, 2000, 15_000], ["100", "500", "2,000", "15,000"])
        axis.set_ylabel("Hz")
        axis.set_title(sample.title, loc="left")
        for edge in SHRIMP_HZ:
            axis.axhline(edge, color="white", linewidth=0.7, linestyle=":")
    axes[-1].set_xlabel("s")
    save_plot(figure, output_folder() / "sound.png")


if __name__ == "__main__":
    main()
