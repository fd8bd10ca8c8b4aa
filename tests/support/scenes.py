"""A small sea with directions, for tests of the application, and a box for those of schools."""

from pathlib import Path

import numpy as np

BARE = Path(__file__).with_name("bare_sea.toml")
# A box with periodic sides; these are a power of two, so that shifts by half of one are exact.
BOX, SIDE = str(Path(__file__).parents[2] / "docs/studies/periodic.toml"), 1024.0  # cm
SCHOOL = ["fish.0.number=24", "fish.0.position_cm=[0, 0, -250]", "fish.0.spread_cm=70",
          "fish.0.heading_deg=30"]  # fmt: skip


def scene(folder, *directions):
    """Write the bare sea with these `[[direction]]` tables; returns the file."""
    file = folder / "scene.toml"
    file.write_text(BARE.read_text() + "".join(f"[[direction]]\n{one}\n" for one in directions))
    return file


def everyone(fishes):
    """The indices of all fishes, for kernels that take a part of them."""
    return np.arange(len(fishes.length))
