"""Write learned controllers to a species file; only their numbers change."""

import tomllib
from pathlib import Path

import msgspec

from subsea.biomechanics.body_plan import SwimPlan, TurnPlan
from subsea.core.atomic_io import replacing
from subsea.core.errors import UserError
from subsea.core.toml_edit import edit_toml
from subsea.core.toml_files import load_toml
from subsea.fish.species import Species


def write_controllers(source: Path, target: Path, swim: SwimPlan, turn: TurnPlan) -> None:
    """Write the species file ``source`` to ``target`` with other tables [swim] and [turn].

    Comments and order are kept; UserError on failure.
    """
    text = source.read_bytes().decode("utf-8")
    content = tomllib.loads(text)
    for name, plan in (("swim", swim), ("turn", turn)):
        old = content.get(name, {})
        text = edit_toml(text, old, old | msgspec.to_builtins(plan), (name,), source)
    with replacing(target) as temporary:
        temporary.write_bytes(text.encode("utf-8"))
        written = load_toml(temporary, Species)
        if (written.swim, written.turn) != (swim, turn):
            raise UserError("its tables [swim] and [turn] cannot be edited", file=source)
