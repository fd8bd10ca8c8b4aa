"""ride.jpg and steered.jpg: a ride on a fish, and a fish under manual control.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_ride_picture.py [FOLDER]
"""

from contextlib import closing

from picture_files import output_folder, save, window_image

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.ui.dive import Dive

SIZE, FISH, FEMALE = (960, 540), 9, 0
DISPLAY = DisplayOptions(size=SIZE, quality="high")
WAIT_S, RIDE_S, COURTED_S, STEER_S = 5.0, 2.4, 7.0, 3.0


def _go(dive: Dive, seconds: float) -> None:
    for _ in range(round(seconds / 0.1)):
        dive.frame(0.1)


def main() -> None:
    """Make both pictures."""
    folder = output_folder()
    with closing(Dive(DiveOptions("peaceful", seed=1, display=DISPLAY))) as dive:
        _go(dive, WAIT_S)
        dive.ride_fish(FISH)
        dive.run_command("look")
        _go(dive, RIDE_S)
        save(window_image(dive), folder / "ride.jpg")
    with closing(Dive(DiveOptions("mating", seed=1, display=DISPLAY))) as dive:
        _go(dive, COURTED_S)
        dive.ride_fish(FEMALE, behind=True)
        dive.commands.start_ride(None, None, teleop=True)
        _go(dive, STEER_S)
        save(window_image(dive), folder / "steered.jpg")


if __name__ == "__main__":
    main()
