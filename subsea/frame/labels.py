"""Labels: text at points in the world, and their positions in pictures."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.view.camera import View
from subsea.view.rig import CameraRig, Projection


class Label(NamedTuple):
    """Text at a point in the world."""

    place: Array  # (3,) cm
    text: str


class PlacedLabel(NamedTuple):
    """A label in a finished picture."""

    output: int
    x: float  # pixels from the left and from the top, of the middle of its lower edge
    y: float
    text: str


def place_labels(
    rig: CameraRig, views: Sequence[View], labels: Sequence[Label]
) -> list[PlacedLabel]:
    """Place labels on the flat patches of a rig that draws these `views`, the farthest first."""
    found = []
    for patch in rig.patches:
        view = next((one for one in views if one.viewport == patch.left), None)
        if view is None or patch.shape != Projection.FLAT:
            continue
        x, y, width, height = patch.place
        top = rig.outputs[patch.output][1]
        for distance, across, up, text in projected(view, labels):
            at = PlacedLabel(patch.output, x + width * across, top - y - height * up, text)
            found.append((distance, at))
    return [at for _, at in sorted(found, key=lambda pair: -pair[0])]


def projected(view: View, labels: Sequence[Label]) -> list[tuple[float, float, float, str]]:
    """Distance in cm, x and y in shares of the viewport from its lower left, and text of labels."""
    if not labels:
        return []
    places = np.array([label.place for label in labels])
    both = view.projection.astype(np.float64) @ view.view.astype(np.float64)
    clip = np.concatenate([places, np.ones((len(places), 1))], axis=1) @ both.T
    inside = (clip[:, 3] > 0.0) & (np.abs(clip[:, :2]) <= clip[:, 3:]).all(axis=1)
    shares = 0.5 + 0.5 * clip[:, :2] / np.where(inside, clip[:, 3], 1.0)[:, None]
    return [
        (float(clip[k, 3]), float(shares[k, 0]), float(shares[k, 1]), labels[k].text)
        for k in np.flatnonzero(inside).tolist()
    ]
