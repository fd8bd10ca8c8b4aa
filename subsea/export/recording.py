"""Record a scene: the rows that the dive draws, frame by frame as in `subsea film`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from subsea.base import interrupts
from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.base.progress import progress
from subsea.dive.captions import caption_of
from subsea.dive.directed_camera import is_cut
from subsea.dive.tour import Steer
from subsea.export.clips import Model, model_of
from subsea.export.drawn_surface import Surface
from subsea.export.scene import GROUPS, Scene, SceneCamera, SceneFish, SceneMesh, ScenePoses
from subsea.fish.species import Species, repertoire_file
from subsea.frame.packet import (
    FISH,
    INSTANCE_COLUMNS,
    ORIENTATION,
    POSITION,
    ROW_A,
    ROW_B,
    SCALE,
    WEIGHT,
    Packet,
    PackOptions,
    pack,
)
from subsea.geometry.rotation import from_matrix
from subsea.media.film import FilmOptions, reach
from subsea.repertoire import read_repertoire
from subsea.view.camera import FAR_CM, NEAR_CM
from subsea.view.display_rigs import VERTICAL_FOV, cockpit, display_rig
from subsea.view.follow import FollowCamera, follow_fish
from subsea.view.rig import CameraPose, views
from subsea.world.world import World

EVERY_FISH = PackOptions(growth=0.0, culling=False, lod=False)


@dataclass(frozen=True, kw_only=True)
class SceneFilmOptions(FilmOptions):
    """The part of a dive that a scene records, and what of it."""

    record: Path | None = None  # replay this record of `subsea simulate`, not a scenario
    follow: str | None = None  # the camera looks at this fish, as long as it lives
    groups: Sequence[str] = GROUPS  # of the scene, beside fishes and camera
    detail: int = 1  # level of the fishes' meshes, 0 is the finest


class _Take(NamedTuple):
    """The fishes and the camera of one frame."""

    rows: Array  # (m, 23) float32, of the fishes in the sea
    live: dict[int, Array]  # control points (426, 3) of simulated fishes, by number
    observer: CameraPose
    caption: str


def record_frames(
    world: World, times: Sequence[float], steer: Steer, follow: int | None,
    rate: float, size: tuple[int, int], after: Callable[[], None] = lambda: None,
) -> tuple[list[_Take], SceneCamera]:  # fmt: skip
    """Step a world through the instants `times`; what each frame shows, and the camera.

    `steer` steers the submarine; `follow` is the number of a fish to look at. `rate` is the number
    of frames in a second, `size` that of the film's picture. `after` is called after each tick.
    """
    rig = display_rig("mono", size)
    camera: FollowCamera | None = None
    takes: list[_Take] = []
    cuts = []
    with interrupts.deferred_interrupts() as check, progress(len(times), "frame") as done:
        for k, instant in enumerate(times):
            alpha = reach(world, instant, steer, check, after=after)
            observer = cockpit(world.state.submarine, alpha)
            if follow is not None and world.state.fishes.alive[follow]:
                camera, observer = follow_fish(world, follow, alpha, camera)
            if takes and is_cut(takes[-1].observer, observer, 1.0 / rate):
                cuts.append(k)
            packet = pack(world, views(rig, observer), alpha, EVERY_FISH)
            said = caption_of(world, alpha)
            words = said.words if said.opacity > 0.0 else ""
            takes.append(_Take(packet.instances, _shapes(world, packet), observer, words))
            done()
    poses = [take.observer for take in takes]
    axes = np.array([(one.axes[0], one.up, -one.forward) for one in poses])
    track = SceneCamera(
        position=np.array([one.eye for one in poses], np.float64),
        rotation=continuous(from_matrix(np.swapaxes(axes, 1, 2))),
        height_rad=float(VERTICAL_FOV),
        aspect=size[0] / size[1],
        size=size,
        near_cm=NEAR_CM,
        far_cm=FAR_CM,
        cuts=tuple(cuts),
    )
    return takes, track


def _shapes(world: World, packet: Packet) -> dict[int, Array]:
    """Control points (426, 3) of the fishes whose pose is simulated, by number."""
    found: dict[int, Array] = {}
    start, table = packet.live_row, world.library.control_points
    for row in packet.instances[(packet.instances[:, [ROW_A, ROW_B]] >= start).any(axis=1)]:
        a, b = (
            packet.live_points[k - start] if k >= start else table[k]
            for k in (int(row[ROW_A]), int(row[ROW_B]))
        )
        weight = float(row[WEIGHT])
        found[int(row[FISH])] = ((1.0 - weight) * a + weight * b).astype(np.float32)
    return found


class _Cast(NamedTuple):
    """The fishes of a scene and their meshes."""

    numbers: Ints  # (N,) in the world
    fishes: tuple[SceneFish, ...]
    models: tuple[Model, ...]
    surfaces: tuple[Surface, ...]
    model_scale: tuple[float, ...]


def make_scene(
    name: str, world: World, takes: Sequence[_Take], camera: SceneCamera,
    statics: Sequence[SceneMesh], options: SceneFilmOptions, rate: float,
) -> Scene:  # fmt: skip
    """The scene of recorded frames; a UserError if no fish is in the sea in any of them."""
    frames, total = len(takes), len(world.state.fishes.species)
    rows = np.full((frames, total, INSTANCE_COLUMNS), np.nan, np.float32)
    for k, take in enumerate(takes):
        rows[k, take.rows[:, FISH].astype(int)] = take.rows
    shown = np.flatnonzero(np.isfinite(rows[:, :, 0]).any(axis=0))
    if not len(shown):
        raise UserError(f"{name}: no fish is in the sea in these seconds, nothing to export")
    rows = rows[:, shown]
    cast = _cast_of(world, shown, rows, options.detail)
    column = {int(number): k for k, number in enumerate(shown)}
    live: dict[int, tuple[list[int], list[Array]]] = {}
    for k, take in enumerate(takes):
        for number, shape in take.live.items():
            numbers, shapes = live.setdefault(column[number], ([], []))
            numbers.append(k)
            shapes.append(shape)
    return Scene(
        name=name,
        title=world.scenario.title,
        seed=world.state.seed,
        fps=rate,
        start_s=options.start,
        frames=frames,
        models=cast.models,
        fishes=cast.fishes,
        position=rows[:, :, POSITION].astype(np.float64),
        rotation=continuous(rows[:, :, ORIENTATION].astype(np.float64)),
        camera=camera,
        statics=tuple(statics),
        poses=ScenePoses(
            rows=rows,
            table=world.library.control_points[: len(world.library.entry)],
            live={k: (np.array(one), np.array(shapes)) for k, (one, shapes) in live.items()},
            surfaces=cast.surfaces,
            model_scale=cast.model_scale,
        ),
        water=world.scenario.water,
        grade=world.scenario.grade,
        captions=tuple(take.caption for take in takes),
    )


def _cast_of(world: World, shown: Ints, rows: Array, detail: int) -> _Cast:
    """The fishes with the numbers `shown`, and the mesh of each of their species."""
    kinds = world.state.fishes.species
    names = list(world.scenario.species)
    among = [int((kinds[:number] == kinds[number]).sum()) for number in shown]
    used = sorted({int(kinds[number]) for number in shown})
    models, surfaces, scales = [], [], []
    for kind in used:
        key, recorded = names[kind], float(world.library.recorded_length[kind])
        snout = float(read_repertoire(repertoire_file(key)).rest_nodes[0, 0])
        model, surface = model_of(key, world.species[kind], recorded, snout, detail)
        models.append(model)
        surfaces.append(surface)
        scales.append(model.length_cm / recorded)
    fishes = []
    for k, number in enumerate(shown):
        inside = np.flatnonzero(np.isfinite(rows[:, k, 0]))
        kind = int(kinds[number])
        scale = float(rows[inside[0], k, SCALE])
        fishes.append(
            SceneFish(
                number=int(number),
                name=f"{names[kind]}_{among[k]:03}",
                model=used.index(kind),
                scale=scale / scales[used.index(kind)],
                length_cm=float(world.state.fishes.length[number]),
                first=int(inside[0]),
                last=int(inside[-1]),
                tint=tint_of(world.species[kind], float(world.state.fishes.identity[number])),
            )
        )
    return _Cast(shown, tuple(fishes), tuple(models), tuple(surfaces), tuple(scales))


def tint_of(species: Species, identity: float) -> Array:
    """Factors (3,) of a fish's colours, as `tone` of `shaders/individual.glsl`."""
    vary = species.skin.variation
    spread = np.array([61.7, 97.3, 151.9])
    hue, own = (2.0 * ((identity * spread + which) % 1.0) - 1.0 for which in (0.0, 0.37))
    tint = 1.0 + vary.hue * (hue - hue.mean())
    return np.asarray(tint * (1.0 + vary.brightness * own[0]))


def continuous(rotation: Array) -> Array:
    """Quaternions (T, ..., 4) with the signs that make each the nearest to the one before."""
    dots = (rotation[1:] * rotation[:-1]).sum(axis=-1, keepdims=True)
    signs = np.cumprod(np.where(dots < 0.0, -1.0, 1.0), axis=0)
    return np.concatenate([rotation[:1], signs * rotation[1:]])
