"""`subsea export`: record a scene and write it for other programs."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from subsea.base import interrupts
from subsea.base.errors import UserError, unknown
from subsea.base.files import file_hash
from subsea.base.progress import count_noun, say
from subsea.dive.directed_camera import check_tour, tour_steering
from subsea.dive.start import ready_world
from subsea.export.recording import SceneFilmOptions, make_scene, record_frames
from subsea.export.scene import GROUPS, Scene, SceneExtent, SceneOptions, SceneWriter
from subsea.export.statics import moment_of, static_meshes
from subsea.export.writers import writer_of
from subsea.fish.mesh import DETAILS, fish_mesh
from subsea.media.film import film_length_s, instants, reach
from subsea.media.frame_writers import frame_rate
from subsea.media.record import Record, read_origin, read_record
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario
from subsea.scenario.shoals import find_fish, with_total
from subsea.submarine.vessel import NEUTRAL, Helm, Rail
from subsea.view.display_rigs import cockpit
from subsea.world.world import World

LIMIT_BYTES = 1_000_000_000  # beyond it --force is needed
MAX_OFF_CM = 0.001  # of a replayed fish from its record, which has single precision

Announce = Callable[[SceneExtent], object]


def export_scene(target: str, film: SceneFilmOptions, options: SceneOptions) -> int:
    """Record the scene of `film` and write it to `film.out`; returns the exit code.

    The estimated bytes are printed before the work. UserError for an unknown target, tour, fish or
    group, for a scene without fishes, for more than LIMIT_BYTES without `options.force`, and if a
    file cannot be written.
    """
    writer = writer_of(target)
    for name in film.groups:
        if name not in GROUPS:
            raise unknown("group", name, list(GROUPS))
    writer.check(film.out, options)
    scene = record_scene(film, lambda extent: _announce(extent, writer, options))
    files = writer.write(scene, film.out, options)
    fishes = count_noun(len(scene.fishes), "fish", "fishes")
    total = sum(path.stat().st_size for path in files if path.is_file())
    print(
        f"{film.out}: {total / 1e6:.1f} MB, {count_noun(scene.frames, 'frame', 'frames')} of "
        f"{fishes} at {scene.fps:g} fps"
    )
    return 0


def record_scene(film: SceneFilmOptions, announce: Announce = lambda extent: None) -> Scene:
    """The scene of `film`; `announce` is called with its extent before the work and may raise."""
    record = None
    if film.record is not None:
        film, record = _replay_of(film, film.record)
    scenario, source = with_total(film.loaded.scenario, film.fish), film.loaded.path
    if not any(shoal.number for shoal in scenario.fish):
        raise UserError("has no fishes, nothing to export", file=source)
    if record is None:
        check_tour(scenario, film.tour)
    follow = None if film.follow is None else find_fish(film.follow, scenario)
    seconds = _seconds_of(film, record)
    rate = frame_rate(film.fps)
    times = instants(film.start, seconds, rate)
    announce(_extent(scenario, len(times), film.detail))
    world = ready_world(film.loaded, film.seed, fish=film.fish)
    steer = tour_steering(world, film.tour) if record is None else _drift
    after = _no_check if record is None else _check_against(record, world, film)
    with interrupts.deferred_interrupts() as check:
        alpha = reach(world, times[0], steer, check, after=after)
    eye = cockpit(world.state.submarine, alpha).eye
    statics = static_meshes(world, film.groups, film.detail, moment_of(world, alpha, eye))
    takes, camera = record_frames(world, times, steer, follow, float(rate), film.size, after)
    return make_scene(source.stem, world, takes, camera, statics, film, float(rate))


def _drift(world: World) -> Helm | Rail:
    """Nobody steers the submarine, as in `subsea simulate`."""
    return NEUTRAL


def _no_check() -> None:
    """Nothing to compare with."""


def _seconds_of(film: SceneFilmOptions, record: Record | None) -> float:
    """The length of a scene: as given, to the end of the record, or as of a film."""
    if film.seconds is not None or record is None:
        return film_length_s(film)
    return max(float(record.time[-1]) - record.tick_s - film.start, 0.0)


def _replay_of(film: SceneFilmOptions, path: Path) -> tuple[SceneFilmOptions, Record]:
    """The dive that a record of `subsea simulate` was made from, and the record.

    A UserError if it is of another scenario.
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
    """A check after each tick that the fishes are where the record has them."""

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


def _extent(scenario: Scenario, frames: int, detail: int) -> SceneExtent:
    """The extent of a scene, before any work."""
    mesh = fish_mesh(DETAILS[detail])
    kinds = np.repeat(
        [scenario.species.index(shoal.species) for shoal in scenario.fish],
        [shoal.number for shoal in scenario.fish],
    ).tolist()
    return SceneExtent(
        frames=frames,
        vertices=(len(mesh.vertices),) * len(kinds),
        triangles=(mesh.body + mesh.fins,) * len(kinds),
        species=tuple(kinds),
    )


def _announce(extent: SceneExtent, writer: SceneWriter, options: SceneOptions) -> None:
    """Print the estimated size; a UserError beyond the limit."""
    estimated = writer.estimate(extent, options)
    what = (
        f"{count_noun(len(extent.vertices), 'fish', 'fishes')} in "
        f"{count_noun(extent.frames, 'frame', 'frames')} take about {_bytes(estimated)}"
    )
    if estimated > LIMIT_BYTES and not options.force:
        raise UserError(
            f"{what}, more than {_bytes(LIMIT_BYTES)}: give --force, or fewer --seconds, --fps, "
            "--fish or a coarser --detail"
        )
    say(what)


def _bytes(number: int) -> str:
    return f"{number / 1e9:.1f} GB" if number >= 1e9 else f"{max(number / 1e6, 0.1):.1f} MB"
