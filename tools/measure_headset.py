"""Cost of a dive in a headset over one in a window with as many pixels, and as wide a view.

    python -m tools.measure_headset [--scenario peaceful] [--rounds 4]

Needs no runtime: the headset is one of the tests. Prints processor times of frames, in turn.
"""

import argparse
import os
import statistics
import time
from contextlib import closing

import moderngl

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.stage.headset import display as headset_display
from subsea.ui.dive import Dive
from subsea.view.head import head_eyes
from tests.support.headset import FakeHeadset
from tools.monkey import virtual_display

EYE = 512, 512  # pixels of each eye
WINDOW = 160, 90  # that mirrors it
MONO = 724, 724
FRAMES = 10


def frames_ms(dive: Dive) -> float:
    """The mean processor time of frames at rest, ms."""
    dive.frame(0.0)
    dive.picture.finish()
    start = time.process_time()
    for _ in range(FRAMES):
        dive.frame(0.0)
    dive.picture.finish()
    return 1000.0 * (time.process_time() - start) / FRAMES


def measured(scenario: str, mode: str, size: tuple[int, int]) -> float:
    """The cost of a frame of a dive of its own."""
    display = DisplayOptions(mode, size, quality="medium")
    with closing(Dive(DiveOptions(scenario, seed=1, display=display))) as dive:
        for _ in range(5):
            dive.frame(0.1)
        if mode == "mono":  # as wide as the left eye
            rig = dive.picture.rig
            eye = head_eyes(FakeHeadset(dive.window_set.context).eyes[:1], [rig.eyes[0].viewport])
            dive.picture.rig = rig._replace(eyes=eye)
            dive.picture.arrange()
        return frames_ms(dive)


def main() -> None:
    """Measure in turn and print the ratio of medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenario", default="peaceful")
    parser.add_argument("--rounds", type=int, default=4)
    options = parser.parse_args()
    headset_display.open_headset = lambda: FakeHeadset(moderngl.create_context(), EYE)
    times: dict[str, list[float]] = {"mono": [], "headset": []}
    with virtual_display() as name:
        os.environ["DISPLAY"] = name
        for _ in range(options.rounds):
            for mode, found in times.items():
                size = WINDOW if mode == "headset" else MONO
                found.append(measured(options.scenario, mode, size))
    middle = {mode: statistics.median(found) for mode, found in times.items()}
    for mode, ms in middle.items():
        print(f"{mode:<14} {ms:7.1f} ms   {ms / middle['mono']:.2f} of mono")


if __name__ == "__main__":
    main()
