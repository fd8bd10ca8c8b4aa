"""`subsea film --eyes`: labelled frames of a fish's view, for vision research (Tu §6.7).

For each frame and each eye a folder gets the picture, an identity map, the same in colours, and a
depth map; `camera.json` describes the camera. docs/how-to/fish-frames.md explains all of them.
"""

import json
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.base import interrupts
from subsea.base.arrays import describe_durations
from subsea.base.errors import UserError
from subsea.base.files import read_input, replacing
from subsea.base.progress import count_noun, print_line, progress, say
from subsea.dive.directed_camera import check_tour, tour_steering
from subsea.dive.ride import (
    MOST_FISHES,
    SIDES,
    VALUES,
    codes,
    retina_brightness,
    values_of,
    velocity_of,
)
from subsea.dive.start import headless, picture_maker, ready_world
from subsea.frame.packet import pack
from subsea.habitat.reef import KINDS as REEF_KINDS
from subsea.media.film import (
    EyeFilmOptions,
    describe_film,
    film_length_s,
    instants,
    missing_frames,
    reach,
    write_manifest,
)
from subsea.media.frame_writers import FilmFormat, frame_rate, kind_of, open_writers
from subsea.rendering.gl.id_buffer import CORAL, FISH, KINDS, PILLAR, ROCK, IdMaps
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.shoals import find_fish, with_total
from subsea.state import MENTAL_STATES
from subsea.view.camera import View
from subsea.view.levels import empty_lod_state
from subsea.view.retina import (
    OPENCV,
    FishEyes,
    Gaze,
    bodies_at,
    fish_eyes,
    retina_rig,
    retinal_views,
)
from subsea.view.rig import CameraRig
from subsea.world.world import World

PARTS = "", "identity", "coded", "depth"  # folders of the pictures, and of the maps
CAMERA = "camera.json"
MM = 10.0  # per cm
CONVENTION = (
    "pinhole, square pixels, origin in the middle of the upper left pixel; x right, y down, "
    "z ahead; `left` and `right` of a frame are 4x4 matrices from the world (cm, z up) to the eye: "
    "pixel = (fx x/z + cx, fy y/z + cy)"
)


def film_eyes(options: EyeFilmOptions) -> int:
    """Film a fish's view into a folder; returns the exit code.

    The dive equals that of `subsea film` with the same scenario, seed, tour and start. An
    incomplete folder gets its missing frames.
    """
    out, gaze, field_deg = options.out, options.gaze, options.field_deg
    if kind_of(out) != "folder":
        raise UserError("labelled frames need the name of a folder", file=out)
    scenario = with_total(options.loaded.scenario, options.fish)
    fish = find_fish(options.eyes, scenario)
    check_tour(scenario, options.tour)
    seconds = film_length_s(options)
    rate = frame_rate(options.fps)
    times = instants(options.start, seconds, rate)
    manifest = describe_film(options, seconds=seconds)
    windows = [f"{part}/{side}" if part else side for part in PARTS for side in SIDES]
    missing = missing_frames(out, manifest, windows, len(times))
    if not missing and _frames_in(out / CAMERA, manifest) == len(times):
        print_line(f"{out}: complete, {count_noun(len(times), 'frame', 'frames')}")
        return 0
    durations: list[float] = []
    frames: list[dict[str, Any]] = []
    with ExitStack() as stack:
        context = stack.enter_context(headless())
        world = ready_world(options.loaded, options.seed, fish=options.fish)
        steer = tour_steering(world, options.tour)
        by = fish_eyes(world, fish)
        rig = retina_rig(options.size, by.half_cm, gaze, field_deg)
        check = stack.enter_context(interrupts.deferred_interrupts())
        preset = PRESETS[options.quality]
        renderer = stack.enter_context(picture_maker(context, world, rig, preset))
        write_manifest(out, manifest)
        stack.callback(_report, out, durations)
        about = describe_camera(world, manifest, by, rig, gaze, field_deg)
        stack.callback(_write_camera, out / CAMERA, about | {"frames": frames})
        sizes = dict.fromkeys(windows, options.size)
        write = stack.enter_context(open_writers(out, sizes, FilmFormat(rate)))
        say(f"filming what fish {fish} sees, {_species(world, fish)}, to {out}")
        done = stack.enter_context(progress(len(times), "frame", len(times) - len(missing)))
        memory = empty_lod_state(len(world.state.fishes.species))
        wanted = set(missing)

        def see() -> None:
            if options.see_brightness:
                world.seen_light[fish] = retina_brightness(renderer, world, by)

        reach(world, times[0], steer, check, see)
        for k, instant in enumerate(times):
            begun = time.perf_counter()
            alpha = reach(world, instant, steer, check, see)
            views = retinal_views(world, by, rig, alpha)
            packet = pack(world, views, alpha, options=preset.packing, memory=memory)
            packet = replace(packet, passing_cm_s=velocity_of(world, fish))
            if k in wanted:
                renderer.draw(packet)
                pictures = [renderer.read_pixels(side) for side in range(len(SIDES))]
                write(k, labelled(pictures, renderer.id_maps(packet)))
                durations.append(time.perf_counter() - begun)
                done()
            else:
                renderer.choose(packet)
            frames.append(describe_frame(world, by, views, k, instant, alpha))
    return 0


def labelled(pictures: Sequence[NDArray[np.uint8]], seen: IdMaps) -> dict[str, Any]:
    """Arrange pictures and maps of a frame by their folders; `seen` covers both eyes."""
    value = values_of(seen)
    depth = np.where(np.isfinite(seen.depth), np.rint(MM * seen.depth), 0.0)
    maps: dict[str, NDArray[Any]] = {
        "identity": value.astype(np.uint16),
        "coded": codes()[value],
        "depth": np.minimum(depth, 2**16 - 1).astype(np.uint16),
    }
    out: dict[str, Any] = dict(zip(SIDES, pictures, strict=True))
    for name, both in maps.items():
        halves = np.split(both, len(SIDES), axis=1)
        out |= {f"{name}/{side}": half for side, half in zip(SIDES, halves, strict=True)}
    return out


def describe_camera(
    world: World,
    manifest: dict[str, Any],
    by: FishEyes,
    rig: CameraRig,
    gaze: Gaze,
    field_deg: float,
) -> dict[str, Any]:
    """Describe the camera, without frames, for its file."""
    width, height = rig.outputs[0]
    p = rig.eyes[0].projection.astype(float)
    if len(world.state.fishes.species) > MOST_FISHES:
        raise UserError(f"an identity map holds at most {MOST_FISHES} fishes")
    return {
        "film": manifest,
        "seed": world.state.seed,
        "fish": {"number": by.fish, "species": _species(world, by.fish)},
        "camera": {
            "width": width,
            "height": height,
            "fx": p[0, 0] * width / 2,
            "fy": p[1, 1] * height / 2,
            "cx": (width - 1) / 2,
            "cy": (height - 1) / 2,
            "field_deg": field_deg,
            "gaze_deg": gaze._asdict(),
            "baseline_cm": 2 * by.half_cm,
            "convention": CONVENTION,
        },
        "depth": {"unit": "mm", "of": "z, along the optical axis", "nothing": 0},
        "identities": identities(world),
    }


def identities(world: World) -> list[dict[str, Any]]:
    """List the meaning of each value of an identity map."""
    fishes, sea, reef = world.state.fishes, world.state.sea, world.state.reef
    out: list[dict[str, Any]] = [
        {"value": VALUES[kind], "kind": kind}
        for number, kind in enumerate(KINDS)
        if number not in (PILLAR, ROCK, CORAL, FISH)
    ]
    for kind, rows in (("pillar", sea.pillars), ("rock", sea.rocks)):
        for k, row in enumerate(rows):
            out.append(_numbered(kind, k) | {"x_cm": float(row[0]), "y_cm": float(row[1])})
    growths = list(REEF_KINDS)
    out += [_numbered("coral", k) | {"form": growths[kind]} for k, kind in enumerate(reef.kind)]
    for k, length in enumerate(fishes.length):
        out.append(
            _numbered("fish", k) | {"species": _species(world, k), "length_cm": float(length)}
        )
    return out


def describe_frame(
    world: World, by: FishEyes, views: Sequence[View], frame: int, instant: float, alpha: float
) -> dict[str, Any]:
    """Describe a frame for the camera file.

    The picture shows the bodies `alpha` of the way from the tick before to the current one, which
    the mental states are of.
    """
    fishes, minds, i = world.state.fishes, world.state.minds, by.fish
    place, turn = bodies_at(world, i, alpha)
    return {
        "frame": frame,
        "time_s": instant,
        "tick": world.state.tick - 1,
        "between": alpha,
        **{
            side: (OPENCV @ view.view.astype(np.float64)).tolist()
            for side, view in zip(SIDES, views, strict=True)
        },
        "fish": {
            "alive": bool(fishes.alive[i]),
            "position_cm": place.tolist(),
            "orientation_wxyz": turn.tolist(),
            "velocity_cm_s": fishes.velocity[i].tolist(),
            "intention": world.table.names[minds.intention[i]],
            **dict(zip(MENTAL_STATES, minds.mental[i].tolist(), strict=True)),
            "light": float(minds.light[i]),
        },
    }


def _numbered(kind: str, number: int) -> dict[str, Any]:
    return {"value": VALUES[kind] + number, "kind": kind, "number": number}


def _species(world: World, fish: int) -> str:
    return world.scenario.species[world.state.fishes.species[fish]]


def _write_json(path: Path, content: dict[str, Any]) -> None:
    """Write JSON with each entry of a list on its own line."""
    parts = []
    for key, value in content.items():
        text = json.dumps(value)
        if isinstance(value, list) and value:
            text = "[\n  " + ",\n  ".join(json.dumps(entry) for entry in value) + "\n ]"
        parts.append(f" {json.dumps(key)}: {text}")
    with replacing(path) as temporary:
        temporary.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")


def _write_camera(path: Path, about: dict[str, Any]) -> None:
    """Write a camera file, unless the existing one has more frames of the same film."""
    if len(about["frames"]) >= _frames_in(path, about["film"]):
        _write_json(path, about)


def _frames_in(path: Path, manifest: dict[str, Any]) -> int:
    """Number of frames of a film in a camera file; 0 without one."""
    try:
        about = json.loads(read_input(path))
        return len(about["frames"]) if about["film"] == manifest else 0
    except (UserError, ValueError, KeyError, TypeError, RecursionError):
        return 0


def _report(out: Path, durations: list[float]) -> None:
    if durations:
        print_line(f"{out}: {describe_durations(durations)}")
