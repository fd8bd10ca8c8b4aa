"""Measure the accuracy of `subsea skin --auto` on rendered photographs with known outlines.

Run from the root of a checkout: python docs/skin_accuracy.py [FOLDER]

Prints a table, and writes the photographs with the detected outlines to FOLDER. Exit code 1
if the worst error of an outline is 1.5% of the length or more.
"""

import sys
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from subsea.fish import paint, sheet_layout
from subsea.fish.species import load_species
from subsea.fish.surface import DORSAL, FIN_V, LEFT, VENTRAL, U, V, rest_control_points
from subsea.geometry.curves import basis_at, dense
from subsea.studio.deformable_mesh import FishMeshes
from subsea.studio.fitting import fin_errors, find_fish, outline_error
from subsea.studio.lift import rasterize
from subsea.studio.photograph import Photograph
from subsea.studio.side_view import mesh_outlines, side_view

FINER = 3  # supersampling each way
MOST = 0.015  # largest error of an outline, body lengths


class Case(NamedTuple):
    """Parameters of a rendered photograph."""

    species: str
    background: str = "plain"
    length: float = 620.0  # pixels
    tilt: float = 0.0  # degrees, head up
    right: bool = False  # it heads right
    other: float = 1.0  # how far its shape is from the species': bent, deeper, taller fins
    noise: float = 0.0  # deviation of each colour, of 255
    blur: float = 0.0  # pixels
    size: tuple[int, int] = (900, 640)
    grey: bool = False  # black and white
    seed: int = 0


class Made(NamedTuple):
    """A photograph and its ground truth."""

    photograph: Photograph
    mask: np.ndarray  # (h, w) what body, tail, dorsal and ventral fin cover
    body: np.ndarray  # (k, 2) the outline of body and tail, under the fins too


def _shaped(places: np.ndarray, case: Case, fin: bool = False) -> np.ndarray:
    """Points of an individual with a slightly different shape."""
    rng = np.random.default_rng(case.seed)
    deeper, bend, wave = case.other * rng.uniform((-0.1, -0.07, -0.012), (0.12, 0.07, 0.012))
    phase = rng.uniform(0.0, 6.3)
    s, y = places[..., 0], places[..., 1]
    y = y * (1.0 + deeper * np.sin(np.pi * np.clip(s, 0, 1)))
    y = y * (1.0 + (0.08 * case.other if fin else 0.0))
    y = y + bend * np.clip(s - 0.35, 0.0, 1.0) ** 2 + wave * np.sin(5.0 * s + phase)
    return np.stack([s + 0.01 * case.other * np.sin(4.0 * s + phase), y], axis=-1)


def made(case: Case) -> Made:
    """Render the photograph of a case."""
    species = load_species(case.species)
    plan = species.surface
    width, height = (FINER * n for n in case.size)
    angle = np.radians(case.tilt) * (1.0 if case.right else -1.0)
    turn = np.array([[np.cos(-angle), -np.sin(-angle)], [np.sin(-angle), np.cos(-angle)]])
    turn = case.length * FINER * turn @ np.diag([-1.0 if case.right else 1.0, -1.0])
    rng = np.random.default_rng(100 + case.seed)
    middle = np.array([width, height]) * (0.5 + 0.04 * rng.uniform(-1, 1, 2))
    shift = middle - turn @ (0.5, 0.0)

    def pixels(places: np.ndarray, fin: bool = False) -> np.ndarray:
        return _shaped(places, case, fin) @ turn.T + shift

    control = rest_control_points(plan, 1.0, 0.0) * (-1.0, 1.0, 1.0)
    sheet = paint.paint(species).astype(np.float32) / 255.0
    rows, columns = sheet.shape[:2]
    front, rear = sheet_layout.borders(plan)
    top = sheet_layout.half_height(plan)
    colour = _background(case, species, sheet)
    mask = np.zeros((height, width), bool)
    fine = np.linspace(0.0, 1.0, 97)
    along = dense(basis_at(FIN_V, fine), FIN_V)
    parts = []
    for frame, points, there in (
        (sheet_layout.DORSAL, DORSAL, plan.dorsal), (sheet_layout.VENTRAL, VENTRAL, plan.ventral),
    ):  # fmt: skip
        if there:
            low, high = (along @ row for row in control[points].reshape(2, FIN_V, 3)[..., :2])
            up = np.linspace(0.0, 1.0, 9)[:, None, None]
            wide, tall = (frame.right - frame.left) * columns, (frame.top - frame.bottom) * rows
            x = frame.left * columns + fine * wide - 0.5
            y = frame.bottom * rows + np.clip(up[:, :, 0], 0.02, 0.98) * tall - 0.5
            texel = np.stack(np.broadcast_arrays(x, y), axis=2)
            parts.append((pixels(low + up * (high - low), True), texel))
    across = dense(basis_at(U, np.linspace(0.0, 1.0, 49)), U)
    body = np.einsum(
        "au,bv,uvx->abx", across, dense(basis_at(V, fine), V), control[LEFT].reshape(U, V, 3)
    )[..., :2]
    scale = np.array([columns / (rear - front), sheet_layout.BODY.top * rows / (2 * top)])
    corners = pixels(body)
    parts.append((corners, (body - (front, -top)) * scale - 0.5))
    ring = [corners[0], corners[1:, -1], corners[-1, -2::-1], corners[-2:0:-1, 0]]
    outline = (np.concatenate(ring) + 0.5) / FINER - 0.5
    if plan.pelvic:  # a fin that hangs out of the outline
        t = np.linspace(0.0, 1.0, 20)[:, None]
        wide = 0.5 * plan.pelvic.width * np.sin(np.pi * t**0.7) * np.array([[-1.0, 1.0]])
        droop = np.radians(plan.pelvic.droop)
        axis = np.array([np.cos(droop), -np.sin(droop)])
        leaf = np.array([plan.pelvic.at, plan.pelvic.height]) + plan.pelvic.length * t * axis
        leaf = leaf[:, None] + wide[..., None] * axis[::-1] * (-1.0, 1.0)
        ring = pixels(np.concatenate([leaf[:, 0], leaf[::-1, 1]]))
        paddle = species.skin.paddles.colour
        ink = [255.0 * c ** (1 / 2.2) for c in paddle]
        cv2.fillPoly(colour, [np.round(ring).astype(np.int32)], ink)
    for corners, texel in parts:
        at = rasterize(corners, texel, (height, width))
        there = np.isfinite(at[..., 0])
        x, y = np.ascontiguousarray(np.nan_to_num(at).transpose(2, 0, 1))
        seen = cv2.remap(sheet, x, y, cv2.INTER_LINEAR)
        shown = there & (seen[..., 3] > 0.35)
        light = np.ones((height, width, 1), np.float32)
        mix = np.clip(seen[..., 3:], 0.0, 1.0) * shown[..., None]
        colour += mix * (255.0 * seen[..., :3] * light - colour)
        mask |= shown
    small = cv2.resize(colour, case.size, interpolation=cv2.INTER_AREA)
    truth = cv2.resize(mask.astype(np.float32), case.size, interpolation=cv2.INTER_AREA) > 0.5
    if case.grey:
        small[:] = small @ np.float32([[0.3], [0.59], [0.11]])
    if case.blur:
        small = cv2.GaussianBlur(small, (0, 0), case.blur)
    small = small + rng.normal(0.0, 1.0 + case.noise, small.shape)
    photograph = Photograph(Path(f"{case.species}.png"), small.clip(0, 255).astype(np.uint8), None)
    return Made(photograph, truth, outline)


def border_error(meshes: FishMeshes, case: Case, body: np.ndarray) -> float:
    """Mean distance of the worst fin's root from the true outline of the body, body lengths."""
    ring = body.astype(np.float32)
    fins = side_view(load_species(case.species).surface).fins
    off = [
        np.mean([
            abs(cv2.pointPolygonTest(ring, place.tolist(), True))
            for place in meshes.fins[name].mesh.nodes[0][one.shows]
        ])
        for name, one in fins.items()
    ]  # fmt: skip
    return float(max(off)) / meshes.length


def _background(case: Case, species: object, sheet: np.ndarray) -> np.ndarray:
    """The background (h, w, 3) of 255, at the finer size."""
    rng = np.random.default_rng(case.seed + 7)
    wide, high = case.size
    y, x = np.mgrid[:high, :wide].astype(np.float32)
    body = sheet_layout.crop(sheet.transpose(2, 0, 1), sheet_layout.BODY)[:3]
    flank = 255.0 * np.median(body[:, 150:360, 300:700].reshape(3, -1), axis=1)
    plain = np.zeros((high, wide, 3), np.float32)
    if case.background == "plain":
        plain[:] = (70, 110, 150)
        plain *= (1.15 - 0.3 * y / high)[..., None]
    elif case.background == "gravel":
        plain[:] = (90, 80, 65)
        for _ in range(6000):
            place = int(rng.uniform(0, wide)), int(rng.uniform(0, high))
            grey = rng.uniform(40, 210)
            tone = [float(c) for c in grey * rng.uniform((0.95, 0.85, 0.7), (1.05, 1.0, 0.95))]
            cv2.ellipse(
                plain, place, (int(rng.uniform(4, 13)), int(rng.uniform(3, 9))),
                rng.uniform(0, 180), 0, 360, tone, -1, cv2.LINE_AA,
            )  # fmt: skip
    elif case.background == "faint":  # the colour of the fish itself, a little darker
        plain[:] = 0.9 * flank
        for scale in (60, 17):
            cloud = cv2.GaussianBlur(
                rng.normal(size=(high, wide)).astype(np.float32), (0, 0), scale
            )
            plain += (5.0 * cloud / cloud.std())[..., None]
    elif case.background == "edges":  # bright here, dark there: the outline is both (Tu fig. 5.5)
        plain[:] = (40 + 190 * x / wide)[..., None]
        plain += (50 * np.cos(6.3 * y / high))[..., None]
    elif case.background == "reef":  # blobs of any colour, some of them the fish's own
        plain[:] = (45, 70, 80)
        inks = body[:, ::37, ::41].reshape(3, -1).T * 255.0
        for _ in range(260):
            place = int(rng.uniform(0, wide)), int(rng.uniform(0, high))
            tone = inks[rng.integers(len(inks))] if rng.uniform() < 0.3 else rng.uniform(20, 200, 3)
            cv2.ellipse(
                plain, place, (int(rng.uniform(10, 60)), int(rng.uniform(8, 45))),
                rng.uniform(0, 180), 0, 360, [float(c) for c in 0.8 * tone], -1, cv2.LINE_AA,
            )  # fmt: skip
        plain = cv2.GaussianBlur(plain, (0, 0), 4.0)
    size = FINER * wide, FINER * high
    return cv2.resize(plain.clip(0, 255), size, interpolation=cv2.INTER_LINEAR)


CASES = {
    "plain water": Case("emperor_angelfish"),
    "plain, heading right": Case("fusilier", right=True, seed=1),
    "tilted by 25 degrees": Case("clownfish", tilt=25.0, seed=2),
    "tilted, heading right": Case("moon_wrasse", tilt=-30.0, right=True, seed=3),
    "gravel": Case("blue_tang", "gravel", seed=4),
    "gravel, slender": Case("hardyhead_silverside", "gravel", seed=5),
    "low contrast": Case("fusilier", "faint", seed=6),
    "low contrast, shark": Case("blacktip_reef_shark", "faint", noise=6.0, seed=18),
    "low contrast, deep": Case("bluecheek_butterflyfish", "faint", seed=7),
    "light and dark edges": Case("moon_wrasse", "edges", seed=8),
    "light and dark, shark": Case("blacktip_reef_shark", "edges", seed=9),
    "light and dark, striped": Case("emperor_angelfish", "edges", right=True, seed=10),
    "noise": Case("clownfish", "plain", noise=45.0, seed=11),
    "noise on gravel": Case("emperor_angelfish", "gravel", noise=30.0, seed=12),
    "out of focus": Case("blue_tang", "edges", blur=6.0, seed=13),
    "small in the picture": Case("clownfish", "plain", length=230.0, seed=14),
    "before a reef": Case("bluecheek_butterflyfish", "reef", seed=15),
    "before a reef, right": Case("clownfish", "reef", right=True, tilt=12.0, seed=16),
    "black and white, gravel": Case("clownfish", "gravel", grey=True, seed=19),
    "black and white, reef": Case("emperor_angelfish", "reef", grey=True, right=True, seed=20),
    "another shape": Case("fusilier", "gravel", other=1.8, seed=21),
    "all at once": Case(
        "moon_wrasse", "reef", noise=20.0, blur=2.0, tilt=18.0, right=True, seed=17
    ),
}


def main() -> int:
    """Print the table and draw the outlines; 1 if an error is too large."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    print("| photograph | species | outline | body and fins | shown for fins |")
    print("| --- | --- | --- | --- | --- |")
    every = []
    for name, case in CASES.items():
        photograph, truth, body = made(case)
        plan = load_species(case.species).surface
        one = find_fish(photograph, plan)
        errors = (
            outline_error(one.meshes, truth),
            border_error(one.meshes, case, body),
            max(fin_errors(one.meshes, plan).values()),
        )
        every.append(100.0 * np.array(errors))
        print(f"| {name} | {case.species.replace('_', ' ')} | {_cells(every[-1])} |", flush=True)
        if folder:
            folder.mkdir(parents=True, exist_ok=True)
            picture = photograph.colour[..., ::-1].copy()
            edges, _ = cv2.findContours(
                truth.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE
            )
            cv2.drawContours(picture, edges, -1, (0, 255, 0), 1)
            edges, _ = cv2.findContours(
                one.mask.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE
            )
            cv2.drawContours(picture, edges, -1, (255, 160, 0), 1)
            for ring in mesh_outlines(one.meshes):
                ring = np.round(16 * ring).astype(np.int32)
                cv2.polylines(picture, [ring], True, (0, 0, 255), 1, cv2.LINE_AA, 4)
            cv2.imwrite(str(folder / f"{name.replace(' ', '_').replace(',', '')}.png"), picture)
    print(f"| worst | | {_cells(np.max(every, 0))} |\n| mean | | {_cells(np.mean(every, 0))} |")
    return 0 if np.max(every, 0)[0] < 100.0 * MOST else 1


def _cells(values: np.ndarray) -> str:
    return " | ".join(f"{value:.2f}" for value in values)


if __name__ == "__main__":
    sys.exit(main())
