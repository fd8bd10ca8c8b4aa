"""`subsea film`: a tour without a window, also into a folder of numbered pictures.

`film.json` beside the pictures records which film they belong to. Filming the same again continues
after an interruption: every picture is complete or absent.
"""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from subsea import __version__
from subsea.base import interrupts
from subsea.base.arrays import Array, Bytes, describe_durations
from subsea.base.errors import UserError
from subsea.base.files import check_folder, file_hash, read_input, replacing
from subsea.base.pictures import Pixels
from subsea.base.progress import count_noun, print_line, progress, say
from subsea.base.system import require
from subsea.dive.captions import caption_of, draw_caption
from subsea.dive.directed_camera import (
    check_tour,
    directed_steering,
    is_cut,
    is_over,
    tour_steering,
)
from subsea.dive.start import headless, picture_maker, ready_world
from subsea.frame.diagrams import DiagramBuilder, PlacedLabel, place_labels
from subsea.frame.packet import pack
from subsea.media.exposure import PINHOLE, Exposure
from subsea.media.exr import write_exr
from subsea.media.film_sound import FilmSound, check_sound_files, write_sound
from subsea.media.frame_writers import (
    CODECS,
    NO_METADATA,
    FilmFormat,
    WriteAll,
    check_output,
    codec_of,
    fitted_size,
    frame_file,
    frame_rate,
    kind_of,
    metadata_for,
    open_writers,
    output_names,
    window_path,
)
from subsea.media.passes import PassFrames
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.load import LoadedScenario
from subsea.scenario.schema import AUTOPILOT, DIRECTED
from subsea.scenario.shoals import find_fish, with_total
from subsea.sound.mixer import SoundLevels
from subsea.sound.space import AMBISONIC, layout_of
from subsea.submarine.vessel import course_of
from subsea.view.display_rigs import chosen_rig, cockpit, theatre_digest
from subsea.view.follow import FollowCamera, follow_fish
from subsea.view.levels import empty_lod_state
from subsea.view.retina import AHEAD, FIELD_DEG, Gaze, bodies_at
from subsea.view.rig import CameraPose, levelled, views
from subsea.view.stereo import EYES, Stereo
from subsea.view.surround import ALL_ROUND, Surround
from subsea.world.step import Order, step
from subsea.world.world import TICK_S, World


@dataclass(frozen=True, kw_only=True)
class FilmOptions:
    """The filmed dive, and the part of it."""

    out: Path
    loaded: LoadedScenario
    seed: int | None = None  # None: the scenario's
    fish: int | None = None  # total number; None: the scenario's
    tour: str = AUTOPILOT  # one of the scenario's, "auto" or "directed"
    start: float = 0.0  # s of the dive before the first frame
    seconds: float | None = None  # None: to the end of the tour
    fps: float = 30.0
    size: tuple[int, int] = (1280, 720)  # of one picture, pixels
    quality: str = "high"  # the name of a preset
    force: bool = False  # replace a file of another kind


@dataclass(frozen=True, kw_only=True)
class TourFilmOptions(FilmOptions):
    """A film of the submarine's windows."""

    display: str = "mono"
    stereo: Stereo = EYES
    surround: Surround = ALL_ROUND
    theatre: str | None = None  # instead of one picture of `size`, a film for each window
    shrink: int = 1  # the theatre's width and height are divided by this
    show: Sequence[str] = ()  # diagrams over the sea
    wireframe: bool = False
    mute: bool = False  # a film without sound
    score: bool = False  # a quiet score under its sound
    sound_layout: str = "stereo"  # one of `sound.space.LAYOUTS`
    audio: Path | None = None  # the sound alone, a WAV file
    audio_stems: Path | None = None  # a folder with the sound of each group
    follow: str | None = None  # a fish to look at from behind, as long as it lives
    exposure: Exposure = PINHOLE  # motion blur and depth of field
    passes: tuple[str, ...] = ()  # in OpenEXR files, see `media.passes`; (): developed pictures
    codec: str | None = None  # one of `frame_writers.CODECS`; None: that of the kind of file
    alpha: bool = False  # open water is transparent


@dataclass(frozen=True, kw_only=True)
class EyeFilmOptions(FilmOptions):
    """Labelled frames of a fish's view."""

    eyes: str  # the fish
    gaze: Gaze = AHEAD
    field_deg: float = FIELD_DEG
    see_brightness: bool = False  # the fish reacts to the light in its eyes


Check = Callable[[], None]

DEFAULT_S = 10.0
SCORE_LEVEL = 0.7  # of a film
MAX_DIRECTED_S = 900.0


def film_length_s(options: FilmOptions) -> float:
    """Find the length of a film: as given, or to the end of a finite tour."""
    if options.seconds is not None:
        return options.seconds
    if options.tour == AUTOPILOT:
        return DEFAULT_S
    if options.tour == DIRECTED:
        scenario = with_total(options.loaded.scenario, options.fish)
        end = directed_length_s(options.loaded._replace(scenario=scenario), options.seed)
    else:
        end = course_of(options.loaded.scenario, options.tour).seconds
    return max(end - options.start, 0.0)


def directed_length_s(loaded: LoadedScenario, seed: int | None) -> float:
    """Measure the seconds until a scenario's directions are over, by playing them once.

    This is a trial, as in Tu §11.6.1: when fishes mate cannot be known beforehand. A UserError
    after a quarter of an hour.
    """
    say("rehearsing the directions to find the length of the film")
    world = ready_world(loaded, seed)
    with interrupts.deferred_interrupts() as check:
        steer = directed_steering(world)
        while not is_over(world):
            check()
            step(world, steer(world))
            if world.state.tick * TICK_S > MAX_DIRECTED_S:
                raise UserError(
                    f"its directions are not over after {MAX_DIRECTED_S / 60:g} minutes: "
                    "a `camera`, `caption` or `end` never came; give --seconds",
                    file=loaded.path,
                )
    return world.state.tick * TICK_S


def instants(start: float, seconds: float, rate: Fraction) -> list[float]:
    """Times of the frames in seconds since the dive began; at least one."""
    return [start + float(k / rate) for k in range(max(round(seconds * rate), 1))]


def reach(
    world: World, instant: float, steer: Callable[[World], Order], check: Check,
    before: Check = lambda: None, after: Check = lambda: None,
) -> float:  # fmt: skip
    """Step the world until `instant` lies between its last two ticks; returns where, 0 to 1.

    `before` and `after` are called around every tick, and `check`, which may raise, also once at
    the beginning.
    """
    ticks, alpha = divmod(instant / TICK_S, 1.0)
    check()
    while world.state.tick < ticks + 1:  # tick 1 is the start of the dive
        check()
        before()
        step(world, steer(world))
        after()
    return alpha


NAME = "film.json"
PICTURES = "frame_*.png", "frame_*.exr"


# Options that are not compared as such: sources, and groups whose fields are given one by one.
NOT_COMPARED = ("out", "force", "loaded", "stereo", "surround", "exposure")


def describe_film(options: FilmOptions, **resolved: Any) -> dict[str, Any]:
    """Describe a film's options, scenario and version as JSON; `resolved` replaces and adds."""
    source = options.loaded.path
    origin: dict[str, Any] = {
        "version": __version__,
        "scenario": source.name,
        "sha256": file_hash(source),
    }
    if options.loaded.changes:
        origin["set"] = [*options.loaded.changes]
    given = {name: value for name, value in vars(options).items() if name not in NOT_COMPARED}
    described: dict[str, Any] = json.loads(json.dumps(origin | given | resolved))
    return described


def missing_frames(
    out: Path, wanted: Mapping[str, Any], windows: Sequence[str], frames: int, suffix: str = ".png"
) -> list[int]:
    """Numbers of the frames that the folder `out` lacks in any of its windows.

    A UserError if its pictures belong to another film than `wanted`, or to an unknown one.
    """
    check_folder(out)
    own = any(any(window_path(out, window).glob(kind)) for window in windows for kind in PICTURES)
    # Another film may have other windows, with folders of their own beside the same file.
    if own or ((out / NAME).exists() and any(any(out.rglob(kind)) for kind in PICTURES)):
        _refuse_another(out, wanted)
    return [
        k
        for k in range(frames)
        if not all(frame_file(window_path(out, window), k, suffix).exists() for window in windows)
    ]


def write_manifest(out: Path, wanted: Mapping[str, Any]) -> None:
    """Record which film the pictures in `out` belong to."""
    with replacing(out / NAME) as temporary:
        temporary.write_text(json.dumps(wanted, indent=2) + "\n", encoding="utf-8")


def _refuse_another(out: Path, wanted: Mapping[str, Any]) -> None:
    """Raise a UserError unless the pictures in `out` belong to the film `wanted`."""
    path = out / NAME
    if not path.exists():
        raise UserError("holds numbered pictures of unknown origin, name another folder", file=out)
    elsewhere = f"name another folder, or remove {out}"
    try:
        found = json.loads(read_input(path))
    except (UserError, ValueError, RecursionError) as fault:
        raise UserError(
            f"damaged, cannot tell which film the pictures belong to; {elsewhere}", file=path
        ) from fault
    if not isinstance(found, dict):
        raise UserError(f"damaged, expected a description of a film; {elsewhere}", file=path)
    for key in [*wanted, *(key for key in found if key not in wanted)]:
        there, here = found.get(key), wanted.get(key)
        if there != here:
            if key == "sha256":
                raise UserError("the scenario has changed since, name another folder", file=out)
            raise UserError(
                f"holds another film: `{key}` is {_words(key, there)} there and "
                f"{_words(key, here)} here, name another folder",
                file=out,
            )


def _words(key: str, value: Any) -> str:
    """An option's value for a message."""
    if value is not None:
        return json.dumps(value)
    return "the scenario's own" if key == "seed" else "not given"


LABEL_HEIGHT, MIN_LABEL_PX = 0.022, 9.0  # height of labels: share of the picture's, and at least


def film(options: TourFilmOptions) -> int:
    """Film a tour of the submarine; returns the exit code.

    A single picture shows the end of the film. An incomplete folder gets its missing frames. The
    world is stepped and packed for all frames, so that new ones equal those of an uninterrupted
    run.

    Ctrl-C keeps the frames so far. Prints the frame times: ticks of the world, packing, drawing
    and reading back, without encoding.
    """
    out, show = options.out, options.show
    scenario = with_total(options.loaded.scenario, options.fish)
    check_tour(scenario, options.tour)
    fish = None if options.follow is None else find_fish(options.follow, scenario)
    seconds = film_length_s(options)
    kind = kind_of(out)
    passes = options.passes or ("beauty",) * (out.suffix.lower() == ".exr")
    size = fitted_size(kind, options.size)
    rig, windows = chosen_rig(
        options.display, size, options.stereo, options.surround, options.theatre, options.shrink
    )
    check_output(out, windows, options.force)
    sizes = {n: fitted_size(kind, shown) for n, shown in zip(windows, rig.outputs, strict=True)}
    names = output_names(out, windows)
    rate = frame_rate(options.fps)
    end = options.start + seconds
    times = [end] if kind == "picture" else instants(options.start, seconds, rate)
    check_sound_files(options.audio, options.audio_stems, options.force)
    sound = _sound_of(options, kind)
    missing = list(range(len(times)))
    if kind == "folder":
        manifest = describe_film(
            options, seconds=seconds, size=size,
            theatre=theatre_digest(options.theatre), follow=fish,
            **options.stereo._asdict(), **options.surround._asdict(),
            **options.exposure._asdict(), passes=passes or None, alpha=options.alpha or None,
        )  # fmt: skip
        suffix = ".exr" if passes else ".png"
        missing = missing_frames(out, manifest, windows, len(times), suffix)
        if not missing:
            print_line(f"{out}: complete, {count_noun(len(times), 'frame', 'frames')}")
            return 0
    preset = PRESETS[options.quality]
    codec = codec_of(out, options.codec) if kind == "film" else "h264"
    if kind == "film" and CODECS[codec].deep:
        preset = replace(preset, deep=True)
    if passes:
        require("exr", "an OpenEXR file")
        preset = replace(preset, floats=True)  # light of any brightness
    durations: list[float] = []
    try:
        with ExitStack() as stack:
            context = stack.enter_context(headless())
            world = ready_world(options.loaded, options.seed, fish=options.fish)
            steer = tour_steering(world, options.tour)
            check = stack.enter_context(interrupts.deferred_interrupts())
            renderer = stack.enter_context(picture_maker(context, world, rig, preset))
            renderer.wireframe = options.wireframe
            diagrams = DiagramBuilder(world)
            if kind == "folder":
                write_manifest(out, manifest)
            # Every channel of a theatre has two eyes, which no player can show.
            metadata = metadata_for(options.display) if options.theatre is None else NO_METADATA
            write: WriteAll | None = None
            frames: PassFrames | None = None
            if passes:
                frames = PassFrames(world, renderer, passes, rate, partial(_write_passes, out))
            else:
                heard = None if options.mute else sound
                form = FilmFormat(rate, metadata, heard, codec, options.alpha)
                write = stack.enter_context(open_writers(out, sizes, form))
            say(_intent(names, len(times), missing))
            done = stack.enter_context(progress(len(times), "frame", len(times) - len(missing)))
            memory = empty_lod_state(len(world.state.fishes.species))
            wanted = set(missing)
            camera: FollowCamera | None = None
            observer: CameraPose | None = None
            exposure = options.exposure

            def listen() -> None:
                if sound is None:
                    return
                heading = None
                if sound.layout.name == AMBISONIC and observer is not None:
                    # Players turn the sound of a sphere with the picture.
                    heading = levelled(observer) if rig.level else observer
                sound.listen(world, fish, heading)

            def look_out(alpha: float) -> CameraPose:
                """Move the camera: to the pilot's eye, or behind the followed fish."""
                nonlocal camera
                if fish is None or not world.state.fishes.alive[fish]:
                    return cockpit(world.state.submarine, alpha)
                camera, pose = follow_fish(world, fish, alpha, camera)
                return pose

            listen()
            reach(world, times[0], steer, check, after=listen)
            for k, instant in enumerate(times[: missing[-1] + 1]):
                begun = time.perf_counter()
                covers: list[Array] = []
                open_at = options.exposure.instants(instant, float(1 / rate))
                for sample, moment in enumerate(open_at):
                    alpha = reach(world, moment, steer, check, after=listen)
                    before, observer = observer, look_out(alpha)
                    cut = is_cut(before, observer, float(1 / rate))
                    if cut:  # no cross-fade over a cut
                        if sample:  # the next frame begins with it
                            observer = before
                            break
                        memory = empty_lod_state(len(world.state.fishes.species))
                    if fish is not None and world.state.fishes.alive[fish]:
                        gap = bodies_at(world, fish, alpha)[0] - observer.eye
                        exposure = options.exposure.focused(float(gap @ observer.forward))
                    pinhole = views(rig, observer)
                    seen = exposure.through_lens(pinhole, sample)
                    drawing = diagrams.draw(show, seen, alpha)
                    packet = pack(
                        world, seen, alpha, options=preset.packing,
                        memory=memory, lines=drawing.lines,
                    )  # fmt: skip
                    if k not in wanted:
                        renderer.choose(packet)
                    elif len(open_at) == 1:
                        renderer.draw(packet)
                    else:
                        renderer.expose(packet, first=sample == 0)
                    if frames and not sample:
                        frames.begin(k, replace(packet, views=pinhole), alpha, cut, k in wanted)
                    if frames and k in wanted:
                        frames.add(packet, len(open_at))
                    if options.alpha and k in wanted:
                        covers.append(renderer.light_parts(packet).cover)
                if k not in wanted:
                    continue
                if len(open_at) > 1:
                    renderer.show_exposure()
                if frames:
                    frames.expose()
                drawn = time.perf_counter()
                if write:
                    labels = place_labels(rig, seen, drawing.labels)
                    caption = caption_of(world, alpha)
                    pictures = {}
                    for number, (name, (width, height)) in enumerate(sizes.items()):
                        lettering = partial(lettered, labels=labels, output=number)
                        captioned = partial(draw_caption, rig=rig, output=number, caption=caption)
                        picture = drawn_over(renderer.read_pixels(number), lettering, captioned)
                        if covers:
                            picture = with_opacity(picture, np.mean(covers, axis=0))
                        pictures[name] = picture[:height, :width]
                    drawn = time.perf_counter()
                    write(k, pictures)
                durations.append(drawn - begun)
                done()
            if sound is not None:  # it ends with the last frame, not at its beginning
                reach(world, end, steer, check, after=listen)
            if frames:  # the motion of the last frame leads to another one
                instant += float(1 / rate)
                alpha = reach(world, instant, steer, check)
                before, observer = observer, look_out(alpha)
                cut = is_cut(before, observer, float(1 / rate))
                packet = pack(world, views(rig, observer), alpha, options=preset.packing)
                frames.begin(k + 1, packet, alpha, cut, wanted=False)
        if sound is not None:
            write_sound(sound, seconds, options.audio, options.audio_stems)
    except KeyboardInterrupt:
        _report(names, kind, durations)
        raise
    _report(names, kind, durations)
    return 0


def _write_passes(
    out: Path, number: int, channels: Mapping[str, Array], header: Mapping[str, Any]
) -> None:
    """Write a frame as an OpenEXR file."""
    path = out if kind_of(out) == "picture" else frame_file(out, number, ".exr")
    write_exr(path, channels, header)


def _sound_of(options: TourFilmOptions, kind: str) -> FilmSound | None:
    """The sound to record, if a film or a file is to have it."""
    layout = layout_of(options.sound_layout)
    wanted = options.audio is not None or options.audio_stems is not None
    if wanted or (kind == "film" and not options.mute):
        levels = SoundLevels(score=SCORE_LEVEL if options.score else 0.0)
        return FilmSound(layout, options.start, levels, files=wanted)
    return None


def lettered(picture: Bytes, labels: Sequence[PlacedLabel], output: int) -> Bytes:
    """Draw the labels of an `output` on its picture (h, w, 3)."""
    if not any(label.output == output for label in labels):
        return picture
    from PIL import Image, ImageDraw, ImageFont

    image = Image.fromarray(picture)
    canvas = ImageDraw.Draw(image)
    tall = max(LABEL_HEIGHT * picture.shape[0], MIN_LABEL_PX)
    font = ImageFont.load_default(tall)
    for label in labels:
        if label.output == output:
            canvas.text(
                (label.x, label.y), label.text, (235, 248, 255), font, anchor="mb",
                stroke_width=max(round(0.1 * tall), 1), stroke_fill=(0, 25, 40),
            )  # fmt: skip
    return np.asarray(image)


def drawn_over(picture: Pixels, *draw: Callable[[Bytes], Bytes]) -> Pixels:
    """Let functions draw on a picture (h, w, 3) of 8 bits, or over one of 16 bits."""
    if picture.dtype == np.uint8:
        plain: Any = picture
        for one in draw:
            plain = one(plain)
        return np.asarray(plain)
    low = (picture >> 8).astype(np.uint8)
    over = drawn_over(low, *draw)
    changed = (over != low).any(axis=2, keepdims=True)
    return np.where(changed, over.astype(np.uint16) * 257, picture)


def with_opacity(picture: Pixels, opacity: Array) -> Pixels:
    """Append opacity (h, w), 0 to 1, to a picture (h, w, 3). Colours stay as they are."""
    most = np.iinfo(picture.dtype).max
    values = np.rint(most * np.clip(opacity, 0.0, 1.0)).astype(picture.dtype)
    return np.concatenate([picture, values[..., None]], axis=2)


def _intent(names: str, frames: int, missing: list[int]) -> str:
    """The message before a film begins."""
    if len(missing) == frames:
        return f"filming to {names}"
    lacking = count_noun(len(missing), "frame", "frames")
    return f"filming to {names}: {lacking} of {frames} missing, from {missing[0]} on"


def _report(names: str, kind: str, durations: list[float]) -> None:
    """Print the written files; nothing without a complete picture."""
    if durations:
        print_line(f"{names}: {'written' if kind == 'picture' else describe_durations(durations)}")
