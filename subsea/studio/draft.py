"""Edit a species file as immutable drafts, with undo history and a drag in progress.

Every edit returns another valid draft or raises EditError, so a saved file always loads.
"""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from shutil import copyfile
from typing import Any

import numpy as np
from msgspec import structs

from subsea.base.errors import UserError
from subsea.base.files import read_input, read_text, replacing, text_of
from subsea.base.toml_edit import edit_toml
from subsea.base.toml_files import load_toml
from subsea.base.validation import convert
from subsea.fish.species import Species, UnstableSpecies, own_species_file
from subsea.ui.undo import History

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
    """Read a species file, also with a body that is unstable; UserError for a faulty one."""
    try:
        species = load_toml(path, Species)
    except UserError:
        species = load_toml(path, UnstableSpecies)
    text = read_text(path)
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
    """Set several values at once; EditError if the result is not a species.

    An unstable body may stay unstable, so that it can be mended by more than one edit.
    """
    content = draft.content
    for path, value in values.items():
        content = _replaced(content, path, value)
    kinds: set[type[Species]] = {Species, type(draft.species)}
    reason = ""
    for kind in sorted(kinds, key=lambda kind: kind is not Species):
        try:
            return replace(draft, content=content, species=convert(content, kind))
        except UserError as fault:
            reason = str(fault)
    raise EditError(reason)


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
        return text_of(read_input(path), path, foreign=True) != (known.text if known else None)
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
        if load_toml(temporary, type(draft.species)) != draft.species:
            raise UserError("its tables cannot be edited", file=path)


class EditState:
    """Drafts with undo, and a drag in progress."""

    def __init__(self, draft: SpeciesDraft, new: bool = False) -> None:
        """Begin with a draft; a `new` one counts as unsaved."""
        self.history = History(draft)
        self.history.saved(not new)
        self.selected: KeyPath | None = None  # a point of a view
        self.hovered: KeyPath | None = None  # the point under the pointer
        self.refused = ""  # why the last edit was refused
        self._dragged: SpeciesDraft | None = None

    @property
    def present(self) -> SpeciesDraft:
        """The draft that is shown."""
        return self._dragged or self.history.present

    @property
    def dragging(self) -> bool:
        """True if a drag is in progress."""
        return self._dragged is not None

    def drag(self, edit: Callable[[SpeciesDraft], SpeciesDraft]) -> None:
        """Show an edit of the present draft that `commit` will put into the history."""
        self._dragged = self._tried(edit) or self._dragged

    def commit(self) -> None:
        """End the drag: its result can be undone."""
        if self._dragged is not None:
            self.history.do(self._dragged)
        self._dragged = None

    def do(self, edit: Callable[[SpeciesDraft], SpeciesDraft]) -> bool:
        """Make an edit; return False if it is refused."""
        draft = self._tried(edit)
        if draft is not None:
            self._dragged = None
            self.history.do(draft)
        return draft is not None

    def undo(self) -> None:
        """Go back by one edit, a drag in progress first."""
        self._deselect()
        self.history.undo()

    def redo(self) -> None:
        """Go forward by one edit."""
        self._deselect()
        self.history.redo()

    def _deselect(self) -> None:
        self.commit()
        self.selected = None  # the point may not exist in the other draft

    def _tried(self, edit: Callable[[SpeciesDraft], SpeciesDraft]) -> SpeciesDraft | None:
        try:
            draft = edit(self.present)
        except EditError as fault:
            self.refused = str(fault)
            return None
        self.refused = ""
        return draft
