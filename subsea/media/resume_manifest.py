"""A folder of numbered pictures that is filmed in several goes.

`film.json` beside the pictures says which film they are of. Who films the same again goes on where
the last go ended, however it ended: a picture is there as a whole or not at all.
"""

import json
from collections.abc import Mapping, Sequence
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

from subsea.core.atomic_io import check_folder, replacing
from subsea.core.errors import UserError
from subsea.media.frame_writers import frame_file, place_of

NAME = "film.json"
PICTURES = "frame_*.png"


def description(scenario: Path, changes: Sequence[str] = (), **options: Any) -> dict[str, Any]:
    """All that decides what a film shows, as JSON has it: the options, scenario and version."""
    told: dict[str, Any] = {
        "version": version("subsea"),
        "scenario": scenario.name,
        "sha256": sha256(scenario.read_bytes()).hexdigest(),
    }
    if changes:
        told["set"] = [*changes]
    described: dict[str, Any] = json.loads(json.dumps(told | options))
    return described


def missing_frames(
    out: Path, wanted: Mapping[str, Any], windows: Sequence[str], frames: int
) -> list[int]:
    """Which frames of the film `wanted` the folder `out` lacks, of any of its windows.

    A folder with pictures of another film, or of none that is known, is a UserError.
    """
    check_folder(out)
    own = any(any(place_of(out, window).glob(PICTURES)) for window in windows)
    # Another film may have other windows: its pictures lie in other folders beside the same file.
    if own or ((out / NAME).exists() and any(out.rglob(PICTURES))):
        _refuse_another(out, wanted)
    return [
        k
        for k in range(frames)
        if not all(frame_file(place_of(out, window), k).exists() for window in windows)
    ]


def begin(out: Path, wanted: Mapping[str, Any]) -> None:
    """Write down which film the pictures in `out` are going to be of."""
    with replacing(out / NAME) as temporary:
        temporary.write_text(json.dumps(wanted, indent=2) + "\n", encoding="utf-8")


def _refuse_another(out: Path, wanted: Mapping[str, Any]) -> None:
    """A UserError unless the pictures in `out` are of the film `wanted`."""
    path = out / NAME
    if not path.exists():
        raise UserError(f"{out}: holds numbered pictures of unknown origin, name another folder")
    elsewhere = f"name another folder, or remove {out}"
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as fault:
        raise UserError(
            f"{path}: damaged, so that nobody knows what the pictures are of; {elsewhere}"
        ) from fault
    if not isinstance(found, dict):
        raise UserError(f"{path}: damaged, expected a description of a film; {elsewhere}")
    for key in [*wanted, *(key for key in found if key not in wanted)]:
        there, here = found.get(key), wanted.get(key)
        if there != here:
            if key == "sha256":
                raise UserError(f"{out}: the scenario has changed since, name another folder")
            raise UserError(
                f"{out}: holds another film: `{key}` is {_words(key, there)} there and "
                f"{_words(key, here)} here, name another folder"
            )


def _words(key: str, value: Any) -> str:
    """An option as a person would say it."""
    if value is not None:
        return json.dumps(value)
    return "the scenario's own" if key == "seed" else "not given"
