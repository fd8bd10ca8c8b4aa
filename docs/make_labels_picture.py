"""labels.jpg: boxes, masks and keypoints over a picture of a school, and its optical flow.

Run from the root of a checkout: python docs/make_labels_picture.py [FOLDER]
"""

import numpy as np
from picture_files import output_folder, save
from PIL import Image

import subsea
from subsea.lab.dataset.overlay import flow_colours, overlay

SIZE, TICKS, GAP_PX = (448, 232), 300, 4
ASIDE_CM, BEHIND_CM = 75.0, 20.0  # of the camera, from the middle fish of the school


def main() -> None:
    """Write labels.jpg."""
    world = subsea.load("schooling", seed=1)
    world.step(TICKS)
    places = world.fishes.position.astype(np.float64)
    middle = places[np.linalg.norm(places - np.median(places, axis=0), axis=1).argmin()]
    ahead = np.median(world.fishes.velocity, axis=0)
    ahead /= np.linalg.norm(ahead)
    aside = np.array([ahead[1], -ahead[0], 0.0])
    eye = middle + ASIDE_CM * aside - BEHIND_CM * ahead
    truth = subsea.labels(world, subsea.camera(eye, middle), size=SIZE, quality="high")
    high, wide = SIZE[1], 2 * SIZE[0] + GAP_PX
    sheet = np.full((high, wide, 3), 255, np.uint8)
    sheet[:, : SIZE[0]] = overlay(truth)
    sheet[:, -SIZE[0] :] = flow_colours(truth.flow_forward)
    save(Image.fromarray(sheet), output_folder() / "labels.jpg")


if __name__ == "__main__":
    main()
