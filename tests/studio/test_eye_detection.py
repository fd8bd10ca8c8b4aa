"""Eyes in photographs."""

import cv2
import numpy as np

from subsea.studio.photograph import eye_near


def face(eye=True, noise=6.0):
    """A striped face, with an eye at (150, 120) whose radius is 18 pixels."""
    rng = np.random.default_rng(4)
    y, x = np.mgrid[:300, :400]
    picture = np.stack([190 + 0 * x, 120 + 40 * ((x // 25) % 2), 60 + 0 * y], 2).astype(float)
    if eye:
        cv2.circle(picture, (150, 120), 18, (230, 200, 120), -1, cv2.LINE_AA)
        cv2.circle(picture, (150, 120), 10, (10, 10, 12), -1, cv2.LINE_AA)
    return (picture + rng.normal(0, noise, picture.shape)).clip(0, 255).astype(np.uint8)


def test_an_eye_is_found_near_by():
    for size in (0.75, 1.0, 1.25):
        for off in ((0.0, 0.0), (25.0, -10.0), (-20.0, 25.0)):
            place, contrast = eye_near(face(), np.array([150.0, 120.0]) + off, 18.0 * size)
            assert np.hypot(*(place - (150.0, 120.0))) < 3.0
            assert contrast > 0.4


def test_no_eye_is_not_plain():
    place = np.array([150.0, 120.0])
    assert eye_near(face(eye=False), place, 18.0)[1] < 0.1
    assert eye_near(face(), np.array([300.0, 200.0]), 18.0)[1] < 0.1
    assert eye_near(face(), np.array([5000.0, -300.0]), 18.0)[1] < 0.1  # outside the picture
