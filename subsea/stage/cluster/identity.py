"""Check that two computers have equal worlds and views, so that they can show one dive.

They are compared part by part: the code of a dive by package, the files that it draws with, the
packages that compute, the scenario and all that it is made of, and the view. No part is a version:
a number says nothing of a file that somebody changed.
"""

import hashlib
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

import msgspec
import numba
import numpy as np
from msgspec import structs

from subsea import __version__
from subsea.base.source_stamp import ROOT, package_stamps
from subsea.base.system import resource_path
from subsea.fish.species import Species
from subsea.stage.cluster.messages import HASH, MAX_PART, Identity
from subsea.world import snapshot
from subsea.world.world import World

DIVE = "subsea/ui/dive.py"  # imports all that makes and shows a sea
SEA = "the sea"  # made of the other parts
OPENED = (
    "scenario", "contents of the scenario", "seed", "species", "pictures of species",
    "repertoires", SEA,
)  # fmt: skip
"""The parts that opening another scenario changes."""
SHORT = 5  # bytes of a hash: it finds accidents, keys keep out who means harm
MOST_NAMED = 6  # differences in a message
NO_VIEW: Mapping[str, str] = MappingProxyType({})
UNPRINTED = re.compile(r"[^\w .,:'()/+-]")


def identity_of(world: World, view: Mapping[str, str] = NO_VIEW) -> Identity:
    """The parts that make this world and its picture, each with its value or its hash.

    ``view`` adds parts of the theatre and the display.
    """
    library, recorded = world.library, len(world.library.entry)
    tables = {
        name: getattr(library, name)[:recorded]
        for name in ("rotation", "translation", "nodes", "entry", "glide", "leave")
    }
    tables |= {name: getattr(library, name) for name in ("first", "length", "cyclic", "speed")}
    sheets = [Path(kind.skin.sheet) for kind in world.species if kind.skin.sheet]
    parts = {
        "scenario": UNPRINTED.sub("?", world.scenario.title)[:MAX_PART],
        "contents of the scenario": hashed(msgspec.json.encode(world.scenario)),
        "seed": str(world.state.seed),
        "species": hashed(msgspec.json.encode([_anywhere(kind) for kind in world.species])),
        "pictures of species": hashed(*(sheet.read_bytes() for sheet in sheets)),
        "repertoires": hashed(snapshot.checksum_of(tables).encode()),
        **view,
        **_program(),
        SEA: hashed(snapshot.checksum_of(snapshot.constant(world)).encode()),
    }
    return Identity(__version__, parts)


@cache
def _program() -> dict[str, str]:
    """Hashes of code and shaders, and versions of the packages that compute."""
    shaders = sorted(path for path in resource_path("shaders").rglob("*") if path.is_file())
    return {
        "numpy": np.__version__,
        "numba": numba.__version__,
        **code_parts(),
        "shaders": hashed(*(path.read_bytes() for path in shaders)),
    }


def code_parts(root: Path = ROOT) -> dict[str, str]:
    """Hash the code of a dive by package, each with the `__init__.py` files that an import runs."""
    parts = {}
    for name, stamp in package_stamps(root / DIVE, root).items():
        package = root / name
        files = package.rglob("__init__.py") if "/" in name else package.glob("__init__.py")
        parts[name] = hashed(stamp.encode(), *(file.read_bytes() for file in sorted(files)))
    return parts


def hashed(*contents: bytes) -> str:
    """The value of a part that a message can only call another."""
    whole = hashlib.blake2b(digest_size=SHORT)
    for content in contents:
        whole.update(hashlib.blake2b(content).digest())
    return HASH + whole.hexdigest()


def _anywhere(species: Species) -> Species:
    """A species without the folder of its colour sheet."""
    if not (sheet := species.skin.sheet):
        return species
    return structs.replace(species, skin=structs.replace(species.skin, sheet=Path(sheet).name))


def difference(theirs: Identity, ours: Identity) -> str:
    """Describe how another computer differs from this one; empty if they match."""
    names = dict.fromkeys([*ours.parts, *theirs.parts])
    other = [name for name in names if theirs.parts.get(name) != ours.parts.get(name)]
    if not other:
        return ""
    if len(other) > 1 and SEA in other:
        other.remove(SEA)  # a consequence of the rest
    told = [_told(name, theirs, ours) for name in other[:MOST_NAMED]]
    if len(other) > MOST_NAMED:
        told.append(f"{len(other) - MOST_NAMED} more differences")
    version = theirs.version
    if version != ours.version:
        version += f" (expected {ours.version})"
    return f"has subsea {version} with {', '.join(told)}"


def may_open(theirs: Identity, ours: Identity) -> bool:
    """True if another computer differs in nothing that opening our scenario does not change."""
    names = {*ours.parts, *theirs.parts} - {*OPENED}
    return all(theirs.parts.get(name) == ours.parts.get(name) for name in names)


def _told(name: str, theirs: Identity, ours: Identity) -> str:
    value, expected = theirs.parts.get(name, "none"), ours.parts.get(name, "none")
    if name == SEA:
        return (
            "another sea, made of the same scenario: other fishes in number, or a processor that "
            "rounds otherwise"
        )
    if value.startswith(HASH) or expected.startswith(HASH):
        return f"other code in {name}" if name.startswith("subsea") else f"other {name}"
    return f"{name} {value} (expected {expected})"
