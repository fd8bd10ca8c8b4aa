"""`subsea export`: record a part of a dive, frame by frame as in `subsea film`, and write it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np

from subsea.base import interrupts
from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError, unknown
from subsea.base.files import file_hash
from subsea.base.progress import count_noun, print_line, progress, say
from subsea.base.system import require
from subsea.dive.captions import caption_of
from subsea.dive.directed_camera import check_tour, is_cut, tour_steering
from subsea.dive.start import ready_world
from subsea.dive.tour import Steer
from subsea.export.clips import Model, Surface, model_of
from subsea.export.conventions import continuous
from subsea.export.options import SceneOptions
from subsea.export.scene import (
    GROUPS,
    Scene,
    SceneCamera,
    SceneExtent,
    SceneFish,
    SceneMesh,
    ScenePoses,
    SceneWriter,
    extent_of_meshes,
)
from subsea.export.statics import moment_of, static_meshes
from subsea.fish.mesh import DETAILS, fish_mesh
from subsea.fish.species import repertoire_file
from subsea.frame.packet import (
    FISH,
    INSTANCE_COLUMNS,
    ORIENTATION,
    POSITION,
    ROW_A,
    ROW_B,
    SCALE,
    PackOptions,
    pack,
)
from subsea.geometry.rotation import from_matrix
from subsea.media.film import FilmOptions, film_length_s, instants, reach
from subsea.media.frame_writers import frame_rate
from subsea.media.record import Record, read_origin, read_record
from subsea.rendering.gl.feedback import compute_context
from subsea.repertoire import read_repertoire
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario
from subsea.scenario.shoals import find_fish, with_total
from subsea.submarine.vessel import NEUTRAL
from subsea.view.camera import FAR_CM, NEAR_CM
from subsea.view.display_rigs import VERTICAL_FOV, cockpit, display_rig
from subsea.view.follow import FollowCamera, follow_fish
from subsea.view.rig import CameraPose, views
from subsea.world.world import World

# Loaded when chosen: each needs other packages.
WRITERS = {
    "usd": "subsea.export.usd_scene",
    "gltf": "subsea.export.gltf_scene",
    "web": "subsea.export.web",
}
LIMIT_BYTES = 1_000_000_000  # beyond it --force is needed
MAX_OFF_CM = 0.001  # of a replayed fish from its record, which has single precision
POSES = [ROW_A, ROW_B]
EVERY_FISH = PackOptions(growth=0.0, culling=False, lod=False)

Announce = Callable[[SceneExtent], object]


@dataclass(frozen=True, kw_only=True)
class SceneFilmOptions(FilmOptions):
    """The part of a dive that a scene records, and what of it."""

    record: Path | None = None  # replay this record of `subsea simulate`, not a scenario
    follow: str | None = None  # the camera looks at this fish, as long as it lives
    groups: Sequence[str] = GROUPS  # of the scene, beside fishes and camera
    detail: int = 1  # level of the fishes' meshes, 0 is the finest


class _Take(NamedTuple):
    """The fishes and the camera of one frame."""

    rows: Array  # (m, 27) float32, of the fishes in the sea
    simulated: Array  # (k, 426, 3) float32 cm: poses that follow those of earlier frames
    observer: CameraPose
    caption: str


def export_scene(target: str, film: SceneFilmOptions, options: SceneOptions) -> int:
    """Record the scene of `film` and write it to `film.out`; return the exit code.

    Print the estimated bytes before the work. UserError for an unknown target, tour, fish or
    group, for a scene without fishes, for more than LIMIT_BYTES without `options.force`, without
    OpenGL, and if a file cannot be written.
    """
    if target not in WRITERS:
        raise unknown("target", target, list(WRITERS))
    if target == "usd":
        require("usd", "USD")
    writer: SceneWriter = import_module(WRITERS[target]).WRITER
    for name in film.groups:
        if name not in GROUPS:
            raise unknown("group", name, list(GROUPS))
    writer.check(film.out, options)
    scene = record_scene(film, lambda extent: _announce(extent, writer, options))
    files = writer.write(scene, film.out, options)
    fishes = count_noun(len(scene.fishes), "fish", "fishes")
    total = sum(path.stat().st_size for path in files if path.is_file())
    print_line(
        f"{film.out}: {total / 1e6:.1f} MB, {count_noun(scene.frames, 'frame', 'frames')} of "
        f"{fishes} at {scene.fps:g} fps"
    )
    return 0


def record_scene(film: SceneFilmOptions, announce: Announce = lambda extent: None) -> Scene:
    """Record the scene of `film`; `announce` gets its extent and may raise.

    It is called before any work, and again when what does not move is known.
    """
    record = None
    if film.record is not None:
        film, record = _replay_of(film, film.record)
    scenario, source = with_total(film.loaded.scenario, film.fish), film.loaded.path
    if not any(shoal.number for shoal in scenario.fish):
        raise UserError("has no fishes, nothing to export", file=source)
    if record is None:
        check_tour(scenario, film.tour)
    follow = None if film.follow is None else find_fish(film.follow, scenario)
    if film.seconds is not None or record is None:
        seconds = film_length_s(film)
    else:
        seconds = max(float(record.time[-1]) - record.tick_s - film.start, 0.0)
    rate = frame_rate(film.fps)
    times = instants(film.start, seconds, rate)
    extent = _extent(scenario, len(times), film.detail)
    announce(extent)
    compute_context()  # without OpenGL, say so before the work
    world = ready_world(film.loaded, film.seed, fish=film.fish)
    # Nobody steers in `subsea simulate`.
    steer = tour_steering(world, film.tour) if record is None else lambda world: NEUTRAL
    after = (lambda: None) if record is None else _check_against(record, world, film)
    with interrupts.deferred_interrupts() as check:
        alpha = reach(world, times[0], steer, check, after=after)
    eye = cockpit(world.state.submarine, alpha).eye
    statics = static_meshes(world, film.groups, film.detail, moment_of(world, alpha, eye))
    announce(extent._replace(still=extent_of_meshes(statics)))
    takes, camera = record_frames(world, times, steer, follow, float(rate), film.size, after)
    return make_scene(source.stem, world, takes, camera, statics, film, float(rate))


def _replay_of(film: SceneFilmOptions, path: Path) -> tuple[SceneFilmOptions, Record]:
    """Return the options of the dive that `subsea simulate` recorded, and the record.

    UserError for a record of another scenario.
    """
    record, origin = read_record(path), read_origin(path)
    source = film.loaded.path
    if not origin.scenario_sha256:
        raise UserError("of an earlier version, which cannot be replayed", file=path)
    if origin.scenario_sha256 != file_hash(source):
        raise UserError(
            f"recorded from another scenario ({origin.title!r}), or {source} has changed since",
            file=path,
        )
    loaded = load_scenario(str(source), origin.changes)
    film = replace(film, loaded=loaded, seed=record.seed, fish=origin.fish)
    if film.seconds is not None and film.start + film.seconds > record.time[-1]:
        raise UserError(f"ends after {record.time[-1]:.1f} s, before the scene does", file=path)
    return film, record


def _check_against(record: Record, world: World, film: SceneFilmOptions) -> Callable[[], None]:
    """Make a check for after each tick: are the fishes where the record has them?"""

    def check() -> None:
        row = world.state.tick - 1
        if row >= len(record.time):
            return
        fishes = world.state.fishes
        alive = fishes.alive
        off = np.abs(fishes.position[alive] - record.position[row][alive]).max(initial=0.0)
        if off > MAX_OFF_CM or (alive != record.alive[row]).any():
            raise UserError(
                f"the replay departs from it at {record.time[row]:.2f} s: another version of the "
                "program, of a species or of a repertoire recorded it",
                file=film.record,
            )

    return check


def record_frames(
    world: World, times: Sequence[float], steer: Steer, follow: int | None,
    rate: float, size: tuple[int, int], after: Callable[[], None] = lambda: None,
) -> tuple[list[_Take], SceneCamera]:  # fmt: skip
    """Step a world through the instants `times`; return what each frame shows, and the camera.

    `steer` steers the submarine; `follow` is the number of a fish to look at. `rate` is the number
    of frames in a second, `size` that of the film's picture. `after` is called after each tick.
    """
    rig = display_rig("mono", size)
    camera: FollowCamera | None = None
    takes: list[_Take] = []
    cuts = []
    simulated = 0  # poses in earlier frames
    with interrupts.deferred_interrupts() as check, progress(len(times), "frame") as done:
        for k, instant in enumerate(times):
            alpha = reach(world, instant, steer, check, after=after)
            observer = cockpit(world.state.submarine, alpha)
            if follow is not None and world.state.fishes.alive[follow]:
                camera, observer = follow_fish(world, follow, alpha, camera)
            if takes and is_cut(takes[-1].observer, observer, 1.0 / rate):
                cuts.append(k)
            packet = pack(world, views(rig, observer), alpha, EVERY_FISH)
            rows = packet.instances.copy()
            rows[:, POSES] += simulated * (rows[:, POSES] >= packet.live_row)
            simulated += len(packet.live_points)
            said = caption_of(world, alpha)
            words = said.words if said.opacity > 0.0 else ""
            takes.append(_Take(rows, packet.live_points.copy(), observer, words))
            done()
    observers = [take.observer for take in takes]
    axes = np.array([(pose.axes[0], pose.up, -pose.forward) for pose in observers])
    track = SceneCamera(
        position=np.array([pose.eye for pose in observers], np.float64),
        rotation=continuous(from_matrix(np.swapaxes(axes, 1, 2))),
        height_rad=float(VERTICAL_FOV),
        aspect=size[0] / size[1],
        size=size,
        near_cm=NEAR_CM,
        far_cm=FAR_CM,
        cuts=tuple(cuts),
    )
    return takes, track


def make_scene(
    name: str, world: World, takes: Sequence[_Take], camera: SceneCamera,
    statics: Sequence[SceneMesh], film: SceneFilmOptions, rate: float,
) -> Scene:  # fmt: skip
    """Make the scene of recorded frames; UserError if no fish is in the sea in any of them."""
    rows = np.full(
        (len(takes), len(world.state.fishes.species), INSTANCE_COLUMNS), np.nan, np.float32
    )
    for frame, take in zip(rows, takes, strict=True):
        frame[take.rows[:, FISH].astype(int)] = take.rows
    shown = np.flatnonzero(np.isfinite(rows[:, :, 0]).any(axis=0))
    if not len(shown):
        raise UserError(f"{name}: no fish is in the sea in these seconds, nothing to export")
    rows = rows[:, shown]
    fishes, models, surfaces = _cast(world, shown, rows, film.detail)
    recorded = world.library.control_points[: len(world.library.entry)]
    table = np.concatenate([recorded, *(take.simulated for take in takes)])
    return Scene(
        name=name,
        title=world.scenario.title,
        seed=world.state.seed,
        fps=rate,
        start_s=film.start,
        frames=len(takes),
        models=models,
        fishes=fishes,
        position=rows[:, :, POSITION].astype(np.float64),
        rotation=continuous(rows[:, :, ORIENTATION].astype(np.float64)),
        camera=camera,
        statics=tuple(statics),
        poses=ScenePoses(rows, table, surfaces),
        water=world.scenario.water,
        grade=world.scenario.grade,
        captions=tuple(take.caption for take in takes),
    )


def _cast(
    world: World, shown: Ints, rows: Array, detail: int
) -> tuple[tuple[SceneFish, ...], tuple[Model, ...], tuple[Surface, ...]]:
    """Describe the fishes with the numbers `shown`, and make the mesh of each of their species."""
    known, names = world.state.fishes, list(world.scenario.species)
    models: dict[int, Model] = {}
    surfaces: dict[int, Surface] = {}
    tints = np.ones((len(shown), 3))
    for kind in np.unique(known.species[shown]).tolist():
        key, recorded_cm = names[kind], float(world.library.recorded_length[kind])
        snout = float(read_repertoire(repertoire_file(key)).rest_nodes[0, 0])
        model, surface = model_of(key, world.species[kind], recorded_cm, snout, detail)
        models[kind], surfaces[kind] = model, surface
        mine = known.species[shown] == kind
        tints[mine] = surface.tints(known.identity[shown[mine]])
    fishes = []
    for column, number in enumerate(shown.tolist()):
        kind = int(known.species[number])
        inside = np.flatnonzero(np.isfinite(rows[:, column, 0]))
        usual = models[kind].length_cm / float(world.library.recorded_length[kind])
        fishes.append(
            SceneFish(
                number=number,
                name=f"{names[kind]}_{(known.species[:number] == kind).sum():03}",
                model=list(models).index(kind),
                scale=float(rows[inside[0], column, SCALE]) / usual,
                length_cm=float(known.length[number]),
                first=int(inside[0]),
                last=int(inside[-1]),
                tint=tints[column],
            )
        )
    return tuple(fishes), tuple(models.values()), tuple(surfaces.values())


def _extent(scenario: Scenario, frames: int, detail: int) -> SceneExtent:
    """Measure the fishes of a scene before any work."""
    mesh = fish_mesh(DETAILS[detail])
    return SceneExtent(
        frames=frames,
        fishes=sum(shoal.number for shoal in scenario.fish),
        species=len({shoal.species for shoal in scenario.fish if shoal.number}),
        vertices=len(mesh.vertices),
        triangles=mesh.body + mesh.fins,
    )


def _announce(extent: SceneExtent, writer: SceneWriter, options: SceneOptions) -> None:
    """Print the estimated size once all is known; a UserError beyond the limit."""
    estimated = writer.estimate(extent, options)
    what = (
        f"{count_noun(extent.fishes, 'fish', 'fishes')} in "
        f"{count_noun(extent.frames, 'frame', 'frames')} take about {_bytes(estimated)}"
    )
    if estimated > LIMIT_BYTES and not options.force:
        raise UserError(
            f"{what}, more than {_bytes(LIMIT_BYTES)}: give --force, or fewer --seconds, --fps, "
            "--fish or a coarser --detail"
        )
    if extent.still is not None:
        say(what)


def _bytes(number: int) -> str:
    return f"{number / 1e9:.1f} GB" if number >= 1e9 else f"{max(number / 1e6, 0.1):.1f} MB"
