"""Edit a species file as immutable drafts.

Every edit returns another valid draft or raises EditError, so a saved file always loads.
"""

import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from shutil import copyfile
from typing import Any

import numpy as np
from msgspec import structs

from subsea.base.atomic_io import replacing
from subsea.base.errors import UserError
from subsea.base.input_files import read_input
from subsea.base.toml_edit import edit_toml
from subsea.base.toml_files import load_toml
from subsea.base.validation import convert
from subsea.fish.species import Species, own_species_file

KeyPath = tuple[str | int, ...]  # keys and indices that lead to a value of the file

SHAPE_DIGITS = 4  # of lengths in body lengths


class EditError(Exception):
    """An edit that would not make a valid species; the message is a sentence for the user."""


@dataclass(frozen=True, eq=False)
class SpeciesDraft:
    """The content of a species file, and the species that it makes."""

    key: str  # file name without suffix; "" before there is a file
    content: dict[str, Any]
    species: Species
    text: str  # the file that was read or copied: its comments and order are kept
    sheet: Path | None = None  # the picture that the species uses instead of a painted skin


def read_draft(path: Path) -> SpeciesDraft:
    """Read a species file; UserError for a faulty one."""
    species = load_toml(path, Species)
    text = path.read_bytes().decode("utf-8")  # keeps CRLF line ends
    sheet = path.absolute().with_name(species.skin.sheet) if species.skin.sheet else None
    return SpeciesDraft(path.stem, tomllib.loads(text), species, text, sheet)


def copy_draft(source: SpeciesDraft, key: str, name: str) -> SpeciesDraft:
    """Begin a new species as a copy; `key` names its file, `name` is the common name."""
    try:
        own_species_file(key)
    except UserError as fault:
        raise EditError(str(fault)) from None
    if not name.strip():
        raise EditError("A species needs a common name, such as Red snapper.")
    draft = with_value(source, ("name",), name.strip())
    if source.sheet:  # the copy gets its own picture
        draft = with_value(draft, ("skin", "sheet"), f"{key}.png")
    return replace(draft, key=key)


def with_sheet_path(draft: SpeciesDraft) -> Species:
    """The species with the absolute path of its picture, as `load_species` returns it."""
    sheet = str(draft.sheet) if draft.sheet and draft.species.skin.sheet else None
    return structs.replace(draft.species, skin=structs.replace(draft.species.skin, sheet=sheet))


def value_at(draft: SpeciesDraft, path: KeyPath) -> Any:
    """The value of the file at a path."""
    here: Any = draft.content
    for step in path:
        here = here[step]
    return here


def with_value(draft: SpeciesDraft, path: KeyPath, value: Any) -> SpeciesDraft:
    """Set one value; None removes the key."""
    return with_values(draft, {path: value})


def with_values(draft: SpeciesDraft, values: dict[KeyPath, Any]) -> SpeciesDraft:
    """Set several values at once; EditError if the result is not a species."""
    content = draft.content
    for path, value in values.items():
        content = _replaced(content, path, value)
    try:
        species = convert(content, Species)
    except UserError as fault:
        raise EditError(str(fault)) from None
    return replace(draft, content=content, species=species)


def _replaced(here: Any, path: KeyPath, value: Any) -> Any:
    """Copy the tables and lists along the path, share the others."""
    if not path:
        return value
    step, rest = path[0], path[1:]
    if isinstance(here, list):
        assert isinstance(step, int)
        return [_replaced(old, rest, value) if k == step else old for k, old in enumerate(here)]
    out = dict(here)
    if not rest and value is None:
        out.pop(step, None)
    else:
        out[step] = _replaced(out.get(step, {}), rest, value) if rest else value
    return out


def round_length(x: float) -> float:
    """Round a length in body lengths as files have it."""
    return round(float(x), SHAPE_DIGITS)


def clip_share(x: float) -> float:
    """Round, and clip to 0 to 1."""
    return round_length(np.clip(x, 0.0, 1.0))


def clip_height(x: float) -> float:
    """Round, and clip to -1 to 1."""
    return round_length(np.clip(x, -1.0, 1.0))


def to_toml(draft: SpeciesDraft) -> str:
    """The text of the file, with only the changed values replaced."""
    return edit_toml(draft.text, tomllib.loads(draft.text), draft.content)


def changed_on_disk(path: Path, known: SpeciesDraft | None) -> bool:
    """True if the file differs from the draft that was read or written last."""
    try:
        return read_input(path) != (known.text.encode("utf-8") if known else None)
    except UserError:
        return False  # nothing to lose, or saving reports the fault


def save_draft(draft: SpeciesDraft, path: Path) -> None:
    """Write the species file atomically, and the picture of a copied species if it is missing.

    UserError on failure.
    """
    text = to_toml(draft)
    if draft.sheet and (name := draft.species.skin.sheet):
        own = path.with_name(name)
        if not own.exists():
            with replacing(own) as temporary:
                copyfile(draft.sheet, temporary)
    with replacing(path) as temporary:
        temporary.write_bytes(text.encode("utf-8"))
        if load_toml(temporary, Species) != draft.species:
            raise UserError("its tables cannot be edited", file=path)
