"""Write learned plans to a species file; only their numbers change."""

import tomllib
from pathlib import Path

import msgspec

from subsea.base.atomic_io import replacing
from subsea.base.errors import UserError
from subsea.base.toml_edit import edit_toml
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body_plan import BodyPlan, Muscles, SwimPlan, TurnPlan
from subsea.fish.species import Species


def write_controllers(source: Path, target: Path, swim: SwimPlan, turn: TurnPlan) -> None:
    """Write the species file ``source`` to ``target`` with other tables [swim] and [turn].

    Comments and order are kept; UserError on failure.
    """
    _write(source, target, {"swim": swim, "turn": turn})


def write_plans(source: Path, target: Path, muscles: Muscles) -> None:
    """The same with all three tables: [body], [swim] and [turn]."""
    _write(source, target, muscles._asdict())


def _write(source: Path, target: Path, plans: dict[str, BodyPlan | SwimPlan | TurnPlan]) -> None:
    text = source.read_bytes().decode("utf-8")
    content = tomllib.loads(text)
    for name, plan in plans.items():
        old, new = content.get(name, {}), msgspec.to_builtins(plan)
        # Keys that the file omits and the plan has at their default stay omitted.
        defaults = {one.name: one.default for one in msgspec.structs.fields(plan)}
        kept = {key: value for key, value in new.items() if key in old or value != defaults[key]}
        text = edit_toml(text, old, old | kept, (name,), source)
    with replacing(target) as temporary:
        temporary.write_bytes(text.encode("utf-8"))
        written = load_toml(temporary, Species)
        if any(getattr(written, name) != plan for name, plan in plans.items()):
            tables = " and ".join(f"[{name}]" for name in plans)
            raise UserError(f"its tables {tables} cannot be edited", file=source)
