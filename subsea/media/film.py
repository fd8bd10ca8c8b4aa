"""`subsea film`: a tour without a window."""

import time
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np

from subsea.base import interrupts
from subsea.base.arrays import Bytes
from subsea.base.console import count_noun, say
from subsea.base.durations import describe_durations
from subsea.base.progress import progress
from subsea.dive.captions import caption_of, draw_caption
from subsea.dive.directed_camera import check_tour, is_cut, tour_steering
from subsea.dive.start import headless, picture_maker, start_world
from subsea.frame.diagrams import DiagramBuilder
from subsea.frame.labels import PlacedLabel, place_labels
from subsea.frame.packet import pack
from subsea.media.exposure import MeanPictures
from subsea.media.film_options import TourFilmOptions
from subsea.media.film_sound import FilmSound, check_sound_files, write_sound
from subsea.media.film_timing import film_length_s, instants, reach
from subsea.media.frame_writers import (
    check_output,
    fitted_size,
    frame_rate,
    kind_of,
    open_writers,
    output_names,
)
from subsea.media.resume_manifest import describe_film, missing_frames, write_manifest
from subsea.media.video_metadata import NO_METADATA, metadata_for
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.fish_lookup import find_fish
from subsea.scenario.load import load_scenario
from subsea.sound.mixer import SoundLevels
from subsea.sound.space import layout_of
from subsea.stage.theatre.theatre_setup import chosen_rig, theatre_digest
from subsea.view.display_rigs import cockpit
from subsea.view.follow import FollowCamera, follow_fish
from subsea.view.levels import empty_lod_state
from subsea.view.rig import CameraPose, views
from subsea.world.populate import with_total

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
    scenario, source = load_scenario(options.scenario, options.changes)
    scenario = with_total(scenario, options.fish)
    check_tour(scenario, options.tour)
    fish = None if options.follow is None else find_fish(options.follow, scenario)
    seconds = film_length_s(scenario, source, options)
    kind = kind_of(out)
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
            source, options, seconds=seconds, size=size,
            theatre=theatre_digest(options.theatre), follow=fish,
            **options.stereo._asdict(), **options.surround._asdict(),
            **options.exposure._asdict(),
        )  # fmt: skip
        missing = missing_frames(out, manifest, windows, len(times))
        if not missing:
            print(f"{out}: complete, {count_noun(len(times), 'frame', 'frames')}")
            return 0
    preset = PRESETS[options.quality]
    durations: list[float] = []
    try:
        with ExitStack() as stack:
            context = stack.enter_context(headless())
            world = start_world(
                options.scenario, options.seed, options.fish, changes=options.changes
            )
            steer = tour_steering(world, options.tour)
            check = stack.enter_context(interrupts.deferred_interrupts())
            renderer = stack.enter_context(picture_maker(context, world, rig, preset))
            renderer.wireframe = options.wireframe
            diagrams = DiagramBuilder(world)
            if kind == "folder":
                write_manifest(out, manifest)
            # Every channel of a theatre has two eyes, which no player can show.
            metadata = metadata_for(options.display) if options.theatre is None else NO_METADATA
            write = stack.enter_context(
                open_writers(out, sizes, rate, metadata, None if options.mute else sound)
            )
            say(_intent(names, len(times), missing))
            done = stack.enter_context(progress(len(times), "frame", len(times) - len(missing)))
            memory = empty_lod_state(len(world.state.fishes.species))
            wanted = set(missing)
            camera: FollowCamera | None = None
            observer: CameraPose | None = None

            def listen() -> None:
                if sound is not None:
                    sound.listen(world, fish)

            listen()
            reach(world, times[0], steer, check, after=listen)
            for k, instant in enumerate(times[: missing[-1] + 1]):
                begun = time.perf_counter()
                taken = MeanPictures()
                open_at = options.exposure.instants(instant, float(1 / rate))
                for sample, moment in enumerate(open_at):
                    alpha = reach(world, moment, steer, check, after=listen)
                    before, observer = observer, cockpit(world.state.submarine, alpha)
                    if is_cut(before, observer, float(1 / rate)):  # no cross-fade over a cut
                        if sample:  # the next frame begins with it
                            observer = before
                            break
                        memory = empty_lod_state(len(world.state.fishes.species))
                    if fish is not None and world.state.fishes.alive[fish]:
                        camera, observer = follow_fish(world, fish, alpha, camera)
                    seen = options.exposure.through_lens(views(rig, observer), sample)
                    drawing = diagrams.draw(show, seen, alpha)
                    packet = pack(
                        world, seen, alpha, options=preset.packing,
                        memory=memory, lines=drawing.lines,
                    )  # fmt: skip
                    if k not in wanted:
                        renderer.choose(packet)
                        continue
                    renderer.draw(packet)
                    taken.add({name: renderer.read_pixels(n) for n, name in enumerate(sizes)})
                if k not in wanted:
                    continue
                labels = place_labels(rig, seen, drawing.labels)
                caption = caption_of(world, alpha)
                pictures = {}
                for number, (name, picture) in enumerate(taken.mean()):
                    width, height = sizes[name]
                    picture = lettered(picture, labels, number)
                    picture = draw_caption(picture, rig, number, caption)
                    pictures[name] = picture[:height, :width]
                drawn = time.perf_counter()
                write(k, pictures)
                durations.append(drawn - begun)
                done()
            if sound is not None:  # it ends with the last frame, not at its beginning
                reach(world, end, steer, check, after=listen)
        if sound is not None:
            write_sound(sound, seconds, options.audio, options.audio_stems)
    except KeyboardInterrupt:
        _report(names, kind, durations)
        raise
    _report(names, kind, durations)
    return 0


def _sound_of(options: TourFilmOptions, kind: str) -> FilmSound | None:
    """The sound to record, if a film or a file is to have it."""
    layout = layout_of(options.sound_layout)
    wanted = options.audio is not None or options.audio_stems is not None
    if wanted or (kind == "film" and not options.mute):
        return FilmSound(layout, options.start, SoundLevels(), files=wanted)
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


def _intent(names: str, frames: int, missing: list[int]) -> str:
    """The message before a film begins."""
    if len(missing) == frames:
        return f"filming to {names}"
    lacking = count_noun(len(missing), "frame", "frames")
    return f"filming to {names}: {lacking} of {frames} missing, from {missing[0]} on"


def _report(names: str, kind: str, durations: list[float]) -> None:
    """Print the written files; nothing without a complete picture."""
    if durations:
        print(f"{names}: {'written' if kind == 'picture' else describe_durations(durations)}")
