"""`subsea export`: record a part of a dive, frame by frame as in `subsea film`, and write it."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path

import numpy as np

from subsea.base import interrupts
from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError, unknown
from subsea.base.files import file_hash
from subsea.base.progress import count_noun, print_line, say
from subsea.base.system import require
from subsea.dive.directed_camera import check_tour, tour_steering
from subsea.dive.start import ready_world
from subsea.dive.tour import Steer
from subsea.export.clips import Model, Surface, model_of
from subsea.export.conventions import continuous
from subsea.export.loop import (
    SHORTEST_S,
    camera_home,
    close,
    home_seconds,
    homing,
    lead_in,
    run_up,
)
from subsea.export.options import SceneOptions
from subsea.export.plant_motion import plant_motion
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
from subsea.export.take import Take, record_frames
from subsea.fish.mesh import DETAILS, fish_mesh
from subsea.fish.species import repertoire_file
from subsea.frame.packet import (
    FISH,
    INSTANCE_COLUMNS,
    ORIENTATION,
    POSITION,
    SCALE,
)
from subsea.media.film import FilmOptions, film_length_s, instants, reach
from subsea.media.frame_writers import frame_rate
from subsea.media.record import Record, read_origin, read_record
from subsea.rendering.gl.feedback import compute_context
from subsea.repertoire import read_repertoire
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario
from subsea.scenario.shoals import find_fish, with_total
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import cockpit
from subsea.world.world import World

# Loaded when chosen: each needs other packages.
WRITERS = {
    "usd": "subsea.export.usd_scene",
    "gltf": "subsea.export.gltf_scene",
    "web": "subsea.export.web",
}
LIMIT_BYTES = 1_000_000_000  # beyond it --force is needed
MAX_OFF_CM = 0.001  # of a replayed fish from its record, which has single precision
EASED = 0.35  # of its fastest speed: a fish that is moved faster than this is not home in time

Announce = Callable[[SceneExtent], object]


@dataclass(frozen=True, kw_only=True)
class SceneFilmOptions(FilmOptions):
    """The part of a dive that a scene records, and what of it."""

    record: Path | None = None  # replay this record of `subsea simulate`, not a scenario
    follow: str | None = None  # the camera looks at this fish, as long as it lives
    groups: Sequence[str] = GROUPS  # of the scene, beside fishes and camera
    detail: int = 1  # level of the fishes' meshes, 0 is the finest
    loop: bool = False  # let the fishes swim back to where the scene begins


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
    if scenario.bounds.periodic_cm is not None:
        raise UserError(
            "`bounds.periodic_cm`: fishes would leap from side to side between two frames, "
            "expected a scenario without it; `subsea film` shows this one",
            file=source,
        )
    if record is None:
        check_tour(scenario, film.tour)
    follow = None if film.follow is None else find_fish(film.follow, scenario)
    if film.seconds is not None or record is None:
        seconds = film_length_s(film)
    else:
        seconds = max(float(record.time[-1]) - record.tick_s - film.start, 0.0)
    rate = frame_rate(film.fps)
    times = instants(film.start, seconds, rate)
    extent = _extent(scenario, len(times), float(rate), film.detail)
    announce(extent)
    compute_context()  # without OpenGL, say so before the work
    world = ready_world(film.loaded, film.seed, fish=film.fish)
    # Nobody steers in `subsea simulate`.
    steer = tour_steering(world, film.tour) if record is None else lambda world: NEUTRAL
    after = (lambda: None) if record is None else _check_against(record, world, film)
    loops = film.loop and (len(times) - 1) / rate >= SHORTEST_S
    with interrupts.deferred_interrupts() as check:
        early = _run_up(world, film, steer, after) if loops else []
        alpha = reach(world, times[0], steer, check, after=after)
    eye = cockpit(world.state.submarine, alpha).eye
    statics = static_meshes(world, film.groups, film.detail, moment_of(world, alpha, eye))
    extent = extent._replace(still=extent_of_meshes(statics))
    if not loops:
        announce(extent)
    takes, camera = record_frames(world, times, steer, follow, float(rate), film.size, after)
    seamless = False
    if loops:
        lead = lead_in(early, takes, len(world.state.fishes.alive), float(rate))
        steps = math.ceil(home_seconds(world, lead) * rate)
        announce(extent._replace(frames=len(times) + steps))
        later = [times[-1] + float(k / rate) for k in range(1, steps + 1)]
        pilot = homing(lead, later[-1])
        home, _ = record_frames(world, later, pilot, None, float(rate), film.size)
        takes, seamless = _closed(world, early, takes, home, float(rate))
        camera = camera_home(camera, steps, float(rate))
    scene = make_scene(source.stem, world, takes, camera, statics, film, float(rate))
    return replace(scene, filmed=len(times), seamless=seamless)


def _run_up(
    world: World, film: SceneFilmOptions, steer: Steer, after: Callable[[], None]
) -> list[Take]:
    """Record the seconds before a film, from which its fishes come."""
    rate = float(frame_rate(film.fps))
    times = run_up(film.start, rate)
    return record_frames(world, times, steer, None, rate, film.size, after)[0] if times else []


def _closed(
    world: World, early: Sequence[Take], film: Sequence[Take], home: Sequence[Take], rate: float
) -> tuple[list[Take], bool]:
    """Close a film by the way home; tell how well, and if no fish jumps."""
    fishes = world.state.fishes
    number = len(fishes.alive)
    takes, speed = close(early, film, home, rate, number, _recorded_poses(world))
    begin, end = ({*take.rows[:, FISH].astype(int).tolist()} for take in (film[0], home[-1]))
    late = int((speed / fishes.fast > EASED).sum())
    stays = np.isfinite(speed)
    most = float(speed[stays].max(initial=0.0))
    say(f"closes in {len(home) / rate:.1f} s; fishes are moved by {most:.1f} cm/s at most")
    if wrong := late + len(begin ^ end):
        say(f"no loop: {count_noun(wrong, 'fish is', 'fishes are')} not back at the start")
    return takes, not wrong


def _recorded_poses(world: World) -> Array:
    """Return the control points of all recorded frames (rows, 426, 3), cm."""
    return world.library.control_points[: len(world.library.entry)]


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


def make_scene(
    name: str, world: World, takes: Sequence[Take], camera: SceneCamera,
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
    table = np.concatenate([_recorded_poses(world), *(take.simulated for take in takes)])
    return Scene(
        name=name,
        title=world.scenario.title,
        seed=world.state.seed,
        fps=rate,
        start_s=film.start,
        frames=len(takes),
        filmed=len(takes),
        seamless=False,
        models=models,
        fishes=fishes,
        position=rows[:, :, POSITION].astype(np.float64),
        rotation=continuous(rows[:, :, ORIENTATION].astype(np.float64)),
        camera=camera,
        statics=tuple(_in_motion(mesh, takes) for mesh in statics),
        poses=ScenePoses(rows, table, surfaces),
        water=world.scenario.water,
        grade=world.scenario.grade,
        captions=tuple(take.caption for take in takes),
    )


def _in_motion(mesh: SceneMesh, takes: Sequence[Take]) -> SceneMesh:
    """Give a mesh of seaweed its recorded motion."""
    if mesh.bent is None:
        return mesh
    keys = [(k, take.leaves) for k, take in enumerate(takes) if take.leaves is not None]
    frames, nodes = np.array([k for k, _ in keys]), np.array([leaves for _, leaves in keys])
    return mesh._replace(motion=plant_motion(mesh.bent, nodes, frames))


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


def _extent(scenario: Scenario, frames: int, fps: float, detail: int) -> SceneExtent:
    """Measure the fishes of a scene before any work."""
    mesh = fish_mesh(DETAILS[detail])
    return SceneExtent(
        frames=frames,
        fps=fps,
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
