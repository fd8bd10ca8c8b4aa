"""Check that two computers have equal worlds and views, so that they can show one dive."""

import hashlib
from pathlib import Path

import msgspec
from msgspec import structs

from subsea import __version__
from subsea.core.source_stamp import source_stamp
from subsea.dive.cluster.messages import Identity
from subsea.fish.species import Species
from subsea.world import snapshot, step
from subsea.world.world import World


def identity_of(world: World, view: str = "") -> Identity:
    """Hash the sources of this world, its constant state, and its `view`."""
    library, recorded = world.library, len(world.library.entry)
    tables = {
        name: getattr(library, name)[:recorded]
        for name in ("rotation", "translation", "nodes", "entry", "glide", "leave")
    }
    tables |= {name: getattr(library, name) for name in ("first", "length", "cyclic", "speed")}
    return Identity(
        version=__version__,
        code=source_stamp(Path(step.__file__).resolve()),
        title=world.scenario.title[:200],
        scenario=_hash(msgspec.json.encode(world.scenario)),
        seed=world.state.seed,
        species=_hash(msgspec.json.encode([_anywhere(one) for one in world.species])),
        repertoires=snapshot.checksum_of(tables),
        sea=snapshot.checksum_of(snapshot.constant(world)),
        view=_hash(view.encode()),
    )


def _anywhere(species: Species) -> Species:
    """A species without the folder of its colour sheet."""
    if not (sheet := species.skin.sheet):
        return species
    return structs.replace(species, skin=structs.replace(species.skin, sheet=Path(sheet).name))


def difference(theirs: Identity, ours: Identity) -> str:
    """Describe how another computer differs from this one; empty if they match."""
    if theirs.version != ours.version:
        return f"has subsea {theirs.version}, expected {ours.version}"
    if theirs.code != ours.code:
        return (
            f"has subsea {theirs.version} with other code (build {theirs.code[:8]}, expected "
            f"{ours.code[:8]})"
        )
    what = ""
    if theirs.scenario != ours.scenario:
        what = f"another scenario {theirs.title!r}"
        if theirs.title != ours.title:
            what = f"the scenario {theirs.title!r}, expected {ours.title!r}"
    elif theirs.seed != ours.seed:
        what = f"seed {theirs.seed}, expected {ours.seed}"
    elif theirs.species != ours.species:
        what = "other species of fishes (their files differ)"
    elif theirs.repertoires != ours.repertoires:
        what = "other repertoires of its fishes"
    elif theirs.sea != ours.sea:
        what = (
            "another sea, made of the same scenario: other fishes in number, other packages, or "
            "a processor that rounds otherwise"
        )
    elif theirs.view != ours.view:
        what = "another theatre file or calibration, --display, --eye-distance or --comfort"
    return f"has subsea {theirs.version} with {what}" if what else ""


def _hash(data: bytes) -> str:
    return hashlib.blake2b(data, digest_size=16).hexdigest()
