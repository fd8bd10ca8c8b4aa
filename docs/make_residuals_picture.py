"""Make residuals.png: the errors of a projector that a camera saw in part.

PYTHONPATH=. python docs/make_residuals_picture.py

The room is rendered, as tests of the calibration have it: a wall, and a camera too far to the left.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

from picture_files import output_folder, save
from PIL import Image

from subsea.cli.main import main as subsea
from subsea.stage.calibration.optics import ORDINARY
from tests.support.lit_room import look, planned_room, write_points

SIZE = 320, 180
MARKS = [(x, y, 400.0) for x in (-290, -180, -60, 60) for y in (-60, 70)]


def main() -> None:
    """Calibrate the room, and keep the picture of its right projector."""
    with TemporaryDirectory() as scratch:
        folder = Path(scratch)
        path, room = planned_room("wall", SIZE, folder, projectors=2, width=600, distance=400)
        room.noise = 2.0
        camera = look(
            (-200, 30, -60), (-170, 0, 400), (560, 330), ORDINARY, 400, (-0.1, 0.02), (3, -2)
        )
        room.photograph(camera, folder / "photographs")
        write_points(folder / "photographs" / "points.toml", camera, MARKS)
        assert subsea(["theatre", str(path), "--calibrate", str(folder / "photographs")]) == 0
        with Image.open(folder / "room-calibrated-right-residuals.png") as picture:
            save(picture, output_folder() / "residuals.png")


if __name__ == "__main__":
    main()
