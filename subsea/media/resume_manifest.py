"""Resume a folder of numbered pictures.

`film.json` beside the pictures records which film they belong to. Filming the same again continues
after an interruption: every picture is complete or absent.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from subsea import __version__
from subsea.base.atomic_io import check_folder, replacing
from subsea.base.errors import UserError
from subsea.base.input_files import file_hash, read_input
from subsea.media.film_options import FilmOptions
from subsea.media.frame_writers import frame_file, window_path

NAME = "film.json"
PICTURES = "frame_*.png"


# Options that are not compared as such: sources, and groups whose fields are given one by one.
NOT_COMPARED = ("out", "force", "scenario", "changes", "stereo", "surround", "exposure")


def describe_film(scenario: Path, options: FilmOptions, **resolved: Any) -> dict[str, Any]:
    """A film's options, scenario file and version as JSON; `resolved` values replace and add."""
    found: dict[str, Any] = {
        "version": __version__,
        "scenario": scenario.name,
        "sha256": file_hash(scenario),
    }
    if options.changes:
        found["set"] = [*options.changes]
    given = {name: value for name, value in asdict(options).items() if name not in NOT_COMPARED}
    described: dict[str, Any] = json.loads(json.dumps(found | given | resolved))
    return described


def missing_frames(
    out: Path, wanted: Mapping[str, Any], windows: Sequence[str], frames: int
) -> list[int]:
    """Numbers of the frames that the folder `out` lacks in any of its windows.

    A UserError if its pictures belong to another film than `wanted`, or to an unknown one.
    """
    check_folder(out)
    own = any(any(window_path(out, window).glob(PICTURES)) for window in windows)
    # Another film may have other windows, with folders of their own beside the same file.
    if own or ((out / NAME).exists() and any(out.rglob(PICTURES))):
        _refuse_another(out, wanted)
    return [
        k
        for k in range(frames)
        if not all(frame_file(window_path(out, window), k).exists() for window in windows)
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
