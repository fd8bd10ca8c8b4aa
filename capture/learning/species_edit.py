"""Write learned controllers to a species file; only their numbers change."""

from pathlib import Path
from typing import Any

import msgspec

from subsea.biomechanics.body_plan import SwimPlan, TurnPlan
from subsea.core.atomic_io import replacing
from subsea.core.errors import UserError
from subsea.core.toml_files import load_toml
from subsea.fish.species import Species


def write_controllers(source: Path, target: Path, swim: SwimPlan, turn: TurnPlan) -> None:
    """Write the species file ``source`` to ``target`` with these tables [swim] and [turn].

    Comments and order are kept. The file is written whole or not at all; UserError on failure.
    """
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(source.read_bytes().decode("utf-8"))
        for name, plan in (("swim", swim), ("turn", turn)):
            _change(document[name], msgspec.to_builtins(plan))
    except TOMLKitError as fault:
        raise UserError(f"its tables cannot be edited ({fault})", file=source) from fault
    with replacing(target) as temporary:
        temporary.write_bytes(tomlkit.dumps(document).encode("utf-8"))
        written = load_toml(temporary, Species)
        if (written.swim, written.turn) != (swim, turn):
            raise UserError("its tables [swim] and [turn] cannot be edited", file=source)


def _change(table: Any, new: dict[str, Any]) -> None:
    """Set the values of ``table`` that differ from ``new``."""
    for key, value in new.items():
        if isinstance(value, list | tuple) and value and isinstance(value[0], dict):
            for row, values in zip(table[key], value, strict=True):
                _change(row, values)
        elif key not in table or table[key] != value:
            table[key] = list(value) if isinstance(value, tuple) else value
