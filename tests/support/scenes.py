"""A small sea with directions, for tests of the application."""

from pathlib import Path

import numpy as np

BARE = Path(__file__).with_name("bare_sea.toml")


def scene(folder, *directions):
    """Write the bare sea with these `[[direction]]` tables; returns the file."""
    file = folder / "scene.toml"
    file.write_text(BARE.read_text() + "".join(f"[[direction]]\n{one}\n" for one in directions))
    return file


def everyone(fishes):
    """The indices of all fishes, for kernels that take a part of them."""
    return np.arange(len(fishes.length))
