"""Colours that differ in meaning remain apart for eyes that lack a kind of cones."""

from itertools import combinations

import numpy as np
import pytest

from subsea.frame import diagrams
from subsea.ui import gui

# Machado, Oliveira & Fernandes 2009, severity 1, for linear light.
EYES = {
    "usual": np.eye(3),
    "protan": np.array([
        [0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ]),
    "deutan": np.array([
        [0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ]),
    "tritan": np.array([
        [1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ]),
}  # fmt: skip
TO_XYZ = np.array([
    [0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
    [0.0193339, 0.1191920, 0.9503041],
])  # fmt: skip
WHITE = TO_XYZ.sum(axis=1)
APART = 25.0  # CIE 1976 colour difference; 2.3 is just visible
GROUPS = {
    "muscles": (diagrams.PALE, diagrams.RED),
    "alarm": (diagrams.CALM, diagrams.ALARMED),
    "school": (diagrams.LEADER, diagrams.COMPANION),
    "perception": (diagrams.SIGHT, diagrams.SMELL, diagrams.BLIND),
    "frusta": (diagrams.VESSEL, diagrams.EYES),
    "mesh": (diagrams.MESH, diagrams.FIN),
    "springs": (diagrams.CROSS, diagrams.OTHER),
    "axes": diagrams.AXES,
    "panels": (gui.MARK, gui.WARM, gui.INK),
    "placement": (gui.MARK, gui.WARM, gui.REFUSED),
}


def lab(rgb, eye):
    """CIE L*a*b* of a colour of the screen, as an eye sees it."""
    value = np.asarray(rgb, float)
    light = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    share = TO_XYZ @ np.clip(EYES[eye] @ light, 0.0, 1.0) / WHITE
    x, y, z = np.where(share > 216 / 24389, np.cbrt(share), (24389 / 27 * share + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_red_and_green_of_the_same_lightness_are_one_to_a_deutan_eye():
    red, green = (0.80, 0.30, 0.20), (0.55, 0.50, 0.14)
    usual, deutan = (np.linalg.norm(lab(red, e) - lab(green, e)) for e in ("usual", "deutan"))
    assert deutan < 0.4 * usual  # the simulation does something


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("group", GROUPS)
def test_colours_that_differ_in_meaning_remain_apart(group, eye):
    for one, other in combinations(GROUPS[group], 2):
        assert np.linalg.norm(lab(one, eye) - lab(other, eye)) > APART, (one, other)
