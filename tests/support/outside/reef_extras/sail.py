"""A format of theatres: the size of one flat screen, such as `sail 300x200`."""

from pathlib import Path

from subsea.stage.theatre.imported import ImportedTheatre, TheatreBuilder


def read_sail(path: Path) -> ImportedTheatre:
    """Read the screen of a sail."""
    wide, high = path.read_text(encoding="utf-8").split()[1].split("x")
    builder = TheatreBuilder(path, "a sail")
    window = builder.window("sail", size=(int(wide), int(high)))
    if window is not None:
        field = {"left_deg": -30, "right_deg": 30, "down_deg": -20, "up_deg": 20}
        builder.channel("sail", window, angles=field)
    return builder.build()
