"""Plot ten minutes of sound: `python docs/make_loudness_plot.py [FOLDER [MINUTES]]`.

Writes docs/pictures/ten-minutes.jpg: spectrogram and loudness of two scenarios, with the score.
"""

import sys
from io import BytesIO
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from picture_files import BLUE, GREY, ORANGE, STYLE, output_folder, save
from PIL import Image
from scipy.signal import lfilter

from subsea.base.arrays import Array
from subsea.dive.directed_camera import tour_steering
from subsea.scenario.load import load_scenario
from subsea.sound.mixer import Mixer
from subsea.sound.moment import SCORE, hear, sources_of
from subsea.sound.space import LAYOUTS, RATE, listener_of
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S

SCENARIOS = "peaceful", "preying"
VOLUME = 0.8  # of films
COARSE_DPI = 80
WINDOW_S = 3.0  # of short-term loudness (EBU Tech 3341)
# ITU-R BS.1770-4, tables 1 and 2: the head as a sphere, and a high-pass.
SHELF = ([1.53512485958697, -2.69169618940638, 1.19839281085285],
         [1.0, -1.69065929318241, 0.73248077421585])  # fmt: skip
HIGH_PASS = [1.0, -2.0, 1.0], [1.0, -1.99004745483398, 0.99007225036621]


def record(scenario: str, seconds: float) -> tuple[Array, Array, Array]:
    """Return the samples (n, 2) of a tour and of its score, and ticks in which one large comes."""
    world = create_world(load_scenario(scenario)[0])
    steer, sources, mixer = (
        tour_steering(world, "auto"),
        sources_of(world),
        Mixer(LAYOUTS["stereo"]),
    )
    sea, score, comes = [], [], []
    while world.state.tick * TICK_S < seconds:
        step(world, steer(world))
        moment = hear(world, listener_of(world), sources)
        stems = VOLUME * mixer.stems(moment, scored=True)
        sea.append(stems[:SCORE].sum(axis=0).astype(np.float32))
        score.append(stems[SCORE].astype(np.float32))
        comes.append(any(one.leads for one in moment.words))
    return np.concatenate(sea), np.concatenate(score), np.array(comes)


def loudness(samples: Array) -> tuple[Array, Array]:
    """Return times, s, and the short-term loudness, LUFS, of samples (n, 2)."""
    weighted = lfilter(*HIGH_PASS, lfilter(*SHELF, samples, axis=0), axis=0)
    total = np.concatenate([[0.0], np.cumsum((weighted**2).sum(axis=1))])
    window = round(WINDOW_S * RATE)
    starts = np.arange(0, len(samples) - window, RATE)
    power = (total[starts + window] - total[starts]) / window
    return starts / RATE + 0.5 * WINDOW_S, -0.691 + 10.0 * np.log10(power + 1e-12)


def draw(scenario: str, upper: Any, lower: Any, seconds: float) -> None:
    """Draw the spectrogram of a scenario, and its loudness."""
    sea, score, comes = record(scenario, seconds)
    upper.specgram(sea[:, 0], NFFT=4096, Fs=RATE, noverlap=0, vmin=-125, vmax=-50)
    upper.set_yscale("symlog", linthresh=500)
    upper.set_ylim(25, RATE / 2)
    upper.set_yticks([100, 500, 2000, 15_000], ["100", "500", "2,000", "15,000"])
    upper.set_ylabel("Hz")
    upper.set_title(scenario, loc="left")
    times = TICK_S * np.arange(len(comes))
    lower.fill_between(times, -80, 0, where=comes, color=GREY, alpha=0.3, linewidth=0,
                       label="something large comes")  # fmt: skip
    lower.plot(*loudness(sea), color=BLUE, linewidth=0.9, label="all sounds")
    lower.plot(*loudness(score), color=ORANGE, linewidth=0.9, label="quiet score")
    lower.set_ylim(-62, -10)
    lower.set_ylabel("LUFS")
    lower.legend(loc="lower right", ncols=3)
    whole = loudness(sea)[1]
    levels = ", ".join(f"{part:.0f}" for part in np.percentile(whole, [5, 50, 95]))
    print(f"{scenario}: peak {np.abs(sea).max():.2f}, short-term loudness {levels} LUFS")


def main() -> None:
    """Write the figure."""
    seconds = 60.0 * float(sys.argv[2]) if len(sys.argv) > 2 else 600.0
    plt.rcParams.update(STYLE)
    figure, axes = plt.subplots(4, 1, figsize=(9, 9), sharex=True, layout="constrained")
    for k, scenario in enumerate(SCENARIOS):
        draw(scenario, axes[2 * k], axes[2 * k + 1], seconds)
    axes[-1].set_xlabel("s")
    axes[-1].set_xlim(0, seconds)
    with BytesIO() as drawn:  # spectrograms of more dots make large files
        figure.savefig(drawn, format="png", dpi=COARSE_DPI)
        save(Image.open(drawn), output_folder() / "ten-minutes.jpg")


if __name__ == "__main__":
    main()
