"""Measure how bright fishes are drawn: `python tools/measure_fish_light.py [SCENARIO ...]`.

All species swim over sand in the water of a scenario, at its hour and the depth of its submarine.
A row has the mean luminance of a fish's pixels, that of the same pixels without fishes (the water
and sand behind them), the ratio of both, and the fish's chroma.
"""

import argparse
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.system import resource_path
from subsea.fish.skinning import couple, place
from subsea.fish.species import Species, load_species, shipped_species
from subsea.fish.surface import rest_control_points
from subsea.frame.packet import (
    FINS,
    IDENTITY,
    KIND,
    ORIENTATION,
    POSITION,
    ROW_A,
    ROW_B,
    SCALE,
    Batch,
    Packet,
    RenderScene,
    resting_instances,
)
from subsea.frame.packet import FISH as NUMBER
from subsea.geometry.rotation import multiply
from subsea.rendering.gl.context import headless_context
from subsea.rendering.gl.id_buffer import FISH
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.repertoire import read_repertoire
from subsea.scenario.load import load_scenario, scenario_names
from subsea.scenario.schema import LUMINANCE, Scenario
from subsea.state import SWEEP_LEFT, SWEEP_RIGHT
from subsea.view.display_rigs import display_rig, views_for
from subsea.view.rig import pose_from_angles

Array = NDArray[np.floating[Any]]

SIZE = (480, 270)
LENGTH_CM = 20.0  # of every fish: so all cover as many pixels
AWAY_CM, SPACE_CM = 70.0, (26.0, 15.0)  # of the eye; between fishes across and up
TURNS = 0.0, 2.5  # rad, of the two rows: both flanks, as the sun lights one more
GROUND_CM = 60.0  # below the eye
HALF_WIDTH_CM = 3000.0
PITCH = -0.1


class FishLight(NamedTuple):
    """Means over the pixels of one species."""

    luminance: float  # in [0, 1], linear
    behind: float  # the same without fishes
    chroma: float  # greatest colour less the least, linear

    @property
    def ratio(self) -> float:
        """Luminance over that behind."""
        return self.luminance / max(self.behind, 1e-6)


def linear(picture: NDArray[np.uint8]) -> Array:
    """Linear light (h, w, 3) of an sRGB picture."""
    share = picture / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


@cache
def swimmers() -> tuple[tuple[Species, ...], Array]:
    """All shipped species, and control points (species, 426, 3) of their medium swimming."""
    names = shipped_species()
    species = tuple(load_species(name) for name in names)
    rows = [_swimmer(name, one) for name, one in zip(names, species, strict=True)]
    return species, np.array(rows, np.float32)


def _swimmer(name: str, species: Species) -> Array:
    repertoire = read_repertoire(resource_path("repertoires") / f"{name}.h5")
    segment = repertoire.segments["swim_medium"]
    if segment.control_points is not None:
        return np.asarray(segment.control_points[0])
    nodes = repertoire.rest_nodes
    rest = rest_control_points(species.surface, repertoire.body_length_cm, nodes[0, 0])
    return np.asarray(place(couple(species.surface.coupling, nodes, rest), segment.nodes[:1])[0])


def sea_of(scenario: Scenario, eye: Array) -> RenderScene:
    """Flat sand below an eye in the water of a scenario."""
    species, points = swimmers()
    return RenderScene(
        species=species,
        control_points=points,
        recorded_length_cm=tuple(one.length_cm for one in species),
        terrain=np.full((61, 61), eye[2] - GROUND_CM, np.float32),
        terrain_half_width_cm=HALF_WIDTH_CM,
        water=scenario.water,
        grade=scenario.grade,
    )


def rows_of_fishes(eye: Array, level: int) -> Packet:
    """Two rows of all species before an eye, at one level of detail."""
    species, points = swimmers()
    records = resting_instances(2 * len(species))
    for k, record in enumerate(records):
        row, kind = divmod(k, len(species))
        column, line = kind % 5, 2 * row + kind // 5
        turn = np.array([np.cos(TURNS[row] / 2), 0.0, 0.0, np.sin(TURNS[row] / 2)])
        beside = SPACE_CM[0] * (column - 2.0), 0.0, SPACE_CM[1] * (1.5 - line)
        record[POSITION] = eye + (0.0, AWAY_CM, 0.0) + beside
        record[ORIENTATION] = multiply(turn, np.sqrt([0.5, 0.5, 0.0, 0.0]))
        record[SCALE] = LENGTH_CM / species[kind].length_cm
        record[POSITION][0] += record[SCALE] * (points[kind, :, 0].mean()) * -np.cos(TURNS[row])
        record[ROW_A] = record[ROW_B] = record[KIND] = kind
        record[IDENTITY], record[NUMBER] = 0.5, k
        record[FINS][[SWEEP_LEFT, SWEEP_RIGHT]] = 0.55
    views = views_for("mono", SIZE, pose_from_angles(eye, np.pi / 2, PITCH))
    batches = (Batch(level, 0, len(records)),)
    return Packet(1.0, views, records, (batches,), np.zeros((0, 3), np.float32), 0)


def light_on_fishes(renderer: Renderer, packet: Packet) -> Iterator[tuple[int, FishLight]]:
    """Yield species and light of the fishes that a packet shows."""
    renderer.draw(packet)
    seen = linear(renderer.read_pixels())
    maps = renderer.id_maps(packet)
    renderer.bodies = False
    renderer.draw(packet)
    behind = linear(renderer.read_pixels()) @ LUMINANCE
    renderer.bodies = True
    kinds = np.full(len(packet.instances), -1)
    kinds[packet.instances[:, NUMBER].astype(int)] = packet.instances[:, KIND]
    for kind in np.unique(kinds):
        own = (maps.kind == FISH) & (kinds[maps.number] == kind)
        light = seen[own]
        chroma = light.max(axis=1) - light.min(axis=1)
        means = (light @ LUMINANCE).mean(), behind[own].mean(), chroma.mean()
        yield int(kind), FishLight(*map(float, means))


def measured(name: str, quality: str = "medium", level: int = 0) -> dict[str, FishLight]:
    """Measure all species in the water of a scenario, by their names."""
    scenario = load_scenario(name)[0]
    eye = np.array([0.0, 0.0, scenario.submarine.position_cm[2]])
    rig = display_rig("mono", SIZE)
    with headless_context() as context:
        renderer = Renderer(context, sea_of(scenario, eye), rig, PRESETS[quality])
        lights = dict(light_on_fishes(renderer, rows_of_fishes(eye, level)))
        renderer.release()
    return {one.name: lights[k] for k, one in enumerate(swimmers()[0])}


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a row for each scenario and species."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=scenario_names())
    parser.add_argument("--quality", default="medium", choices=PRESETS)
    parser.add_argument("--level", default=0, type=int, help="level of detail, 0 the finest")
    chosen = parser.parse_args(arguments)
    print(f"{'scenario':12} {'species':24} {'fish':>6} {'behind':>6} {'ratio':>6} {'chroma':>6}")
    for name in chosen.scenarios:
        for species, one in sorted(measured(name, chosen.quality, chosen.level).items()):
            print(f"{name:12} {species:24} {one.luminance:6.3f} {one.behind:6.3f}", end="")
            print(f" {one.ratio:6.2f} {one.chroma:6.3f}", flush=True)


if __name__ == "__main__":
    main()
