"""Fit a fish to its outline: scaffold, gaits and turns, in one search.

The scaffold follows from the outline (`subsea.fish.scaffold`). The search of `whole` begins at the
material and fast gait of that shipped species which suits the new body best.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import msgspec
import numpy as np

from capture.learning.batch import Plan, journal_path, learn_plans
from capture.learning.body_space import GAIT_SIZE, at_mass, body_at, gait_at, species_point
from capture.learning.improve import writable_source
from capture.learning.lifelike import wave_course
from capture.learning.whole import LearningTask, without_grades
from subsea.base.errors import UserError
from subsea.base.file_kinds import check_result, toml_file
from subsea.base.files import read_text, replacing
from subsea.base.system import is_path, require, resource_path
from subsea.base.toml_edit import edit_toml
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body import build_body
from subsea.biomechanics.body_plan import BodyPlan, SwimPlan
from subsea.biomechanics.together import swim_together
from subsea.fish.forms import Form
from subsea.fish.outline_file import OutlinePlan, has_tail_fin, read_outline
from subsea.fish.scaffold import fit_scaffold, three_digits, volumes_at
from subsea.fish.species import (
    Species,
    load_species,
    muscular_names,
    own_species_file,
    species_file,
)
from subsea.fish.surface import SurfacePlan

PLAIN = "assets/outline_species.toml"  # all that an outline does not tell
FIRMNESS = (0.5, 1.0, 2.0)  # factors of the stiffness that are tried ...
NARROWNESS = (0.7, 1.0)  # ... and of the widths of a slender body, which hardly bends at usual ones
YOUNGEST, OLDEST = 0.8, 1.1  # sizes of adults over the given length
NO_TAIL_FIN = (
    "it has no tail fin: nothing at its rear is higher than the narrowest place before it, so "
    "bending cannot drive it; give --form boxfish for a stiff fish that rows with its pectoral fins"
)
ROW = {"ticks_per_stroke": 12, "amplitude": 45.0}  # of a boxfish without strokes of its own
OVER_GROUND = (0.3, 2.0)  # at which a flatfish cruises, body lengths


@dataclass(frozen=True)
class FitRequest:
    """A fish to fit, and the options of the command."""

    source: str  # an outline or a species: a name, or the path of a .toml file
    name: str | None  # of the new species; None: the species itself
    out: Path | None = None
    length_cm: float | None = None
    mass_g: float | None = None
    form: Form | None = None  # None: that of the species, of an outline a fish that bends
    budget: int = 800
    seed: int = 1
    dry_run: bool = False
    force: bool = False
    progress: bool = False


def fit_species(request: FitRequest) -> Path | None:
    """Fit a fish and write its file; the path, or None where no gait was found.

    UserError before the search for a fish that cannot swim by bending its body.
    """
    require("learn", "fitting")
    source = species_file(request.source) if not is_path(request.source, ".toml") else None
    source = source or Path(request.source)
    text, surface = _begin(request, source)
    target = _target(request, source)
    content = tomllib.loads(text)
    form: Form = request.form or content.get("form", "fish")
    if form != "boxfish" and not has_tail_fin(surface):
        raise UserError(NO_TAIL_FIN, file=source)
    try:
        body = fit_scaffold(surface)
    except ValueError as fault:
        raise UserError(f"no scaffold fits this outline: {fault}", file=source) from None
    if form == "boxfish":  # nothing bends: there is no gait to search
        shaped = _shaped(content, form, body=body)
        return _write(target, edit_toml(text, content, shaped, (), source), request)
    body, swim = first_guess(surface, body)
    with TemporaryDirectory() as scratch:
        draft = Path(scratch) / f"{target.stem}.toml"
        shaped = _shaped(content, form, body=body, swim=swim)
        draft.write_text(edit_toml(text, content, shaped, (), source), encoding="utf-8")
        species = load_toml(draft, Species)
        journal = journal_path(Path(scratch) / target.name if request.dry_run else target)
        task = LearningTask(
            target.stem, species, True, request.budget, request.seed, journal, quick=True
        )
        plan = Plan(task, draft, None if request.dry_run else target)
        found = learn_plans(
            {target.stem: plan}, 1, request.dry_run, request.force, request.progress
        )
    return target if found else None


def _shaped(content: dict[str, Any], form: Form, **tables: msgspec.Struct) -> dict[str, Any]:
    """The content of a species file with other tables, and what its form needs."""
    shaped = content | {key: _plain(table) for key, table in tables.items()}
    if form != content.get("form", "fish"):
        shaped["form"] = form
    if form == "boxfish":
        shaped["row"] = content.get("row", ROW)
    if form == "flatfish":
        shaped.setdefault("cruise_height", OVER_GROUND)
        shaped["surface"] = {k: v for k, v in content["surface"].items() if k != "pectoral"}
    return shaped


def _write(target: Path, text: str, request: FitRequest) -> Path | None:
    """Write a species file, whole or not at all."""
    check_result(target, toml_file("a species", "surface", "skin"), request.force)
    if request.dry_run:
        return None
    with replacing(target) as temporary:
        temporary.write_text(text, encoding="utf-8")
        load_toml(temporary, Species)
    print(f"{target}: a stiff body that rows: no gait is searched")
    return target


def first_guess(surface: SurfacePlan, fitted: BodyPlan) -> tuple[BodyPlan, SwimPlan]:
    """The fitted body with the material and fast gait of the shipped species that suit it best.

    Their stiffness is scaled with the mass, and tried at each of FIRMNESS. A body that is wider
    than high is tried at each of NARROWNESS.
    """
    volumes = volumes_at(surface, fitted.stations)
    slender = max(fitted.half_heights) < max(fitted.half_widths)
    tried = []
    for narrow, name in product(NARROWNESS if slender else (1.0,), muscular_names()):
        species = load_species(name)
        plan, swim = species.body, species.swim
        assert plan and swim
        widths: Any = tuple(three_digits(narrow * width) for width in fitted.half_widths)
        scaffold = msgspec.structs.replace(fitted, half_widths=widths)
        point = species_point(plan, swim, volumes_at(species.surface, plan.stations))
        for factor in FIRMNESS:
            place = at_mass(point, factor * fitted.mass / plan.mass)
            body = body_at(scaffold, place[GAIT_SIZE:], volumes)
            tried.append((body, gait_at(build_body(body), without_grades(swim), "fast", place)))
    losses = swim_together(
        [wave_course(build_body(body), swim, "fast", seed=1) for body, swim in tried]
    )
    return tried[int(np.argmin(losses))]


def _begin(request: FitRequest, source: Path) -> tuple[str, SurfacePlan]:
    """The text of the species file to begin with, and its surface."""
    text = read_text(source)
    if _is_outline(source, text):
        if request.name is None:
            raise UserError("an outline needs the name of its species: --name NAME")
        surface = read_outline(source, request.length_cm, request.mass_g)
        length = request.length_cm or load_toml(source, OutlinePlan).length_cm
        return _plain_species(request.name, surface, length), surface
    for option in ("length", "mass"):
        if getattr(request, "length_cm" if option == "length" else "mass_g") is not None:
            raise UserError(f"--{option} is for outlines: change the species file")
    species = load_toml(source, Species)
    if species.muscles is None:
        raise UserError("driven by its spine; expected a species with muscles", file=source)
    if request.name is None:
        return text, species.surface
    content = tomllib.loads(text)
    return edit_toml(text, content, content | {"name": _title(request.name)}), species.surface


def _is_outline(source: Path, text: str) -> bool:
    """True for a file with an outline; a file that is not TOML is reported as a species."""
    try:
        return "outline" in tomllib.loads(text)
    except (tomllib.TOMLDecodeError, ValueError, RecursionError):
        return False


def _target(request: FitRequest, source: Path) -> Path:
    """The file to write; UserError where that cannot be."""
    if request.out:
        return request.out
    return own_species_file(request.name) if request.name else writable_source(source)


def _plain_species(name: str, surface: SurfacePlan, length_cm: float | None) -> str:
    """The text of a plain species with an outline."""
    path = resource_path(PLAIN)
    text = read_text(path)
    content = tomllib.loads(text)
    new = content | {"name": _title(name), "surface": _plain(surface)}
    if length_cm:
        low, high = (round(share * length_cm, 1) for share in (YOUNGEST, OLDEST))
        new["size_cm"] = [max(low, 2.0), min(high, 300.0)]
    for fin in ("dorsal", "ventral"):
        if getattr(surface, fin) is None:
            new["skin"] = {key: value for key, value in new["skin"].items() if key != fin}
    return edit_toml(text, content, new, (), path)


def _plain(plan: msgspec.Struct) -> dict[str, Any]:
    """The table of a plan without the keys that have their defaults."""
    table: Mapping[str, Any] = msgspec.to_builtins(plan)
    defaults = {one.name: one.default for one in msgspec.structs.fields(plan)}
    return {key: value for key, value in table.items() if value != defaults[key]}


def _title(name: str) -> str:
    """The name that people see, of a file name."""
    return name.replace("_", " ").replace("-", " ").capitalize()
