"""`subsea dataset`: make a set of labelled pictures with its formats and its card."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from subsea.base.errors import UserError, unknown
from subsea.base.progress import say
from subsea.jobs.workers import Check, Pool, serial
from subsea.lab.dataset.card import write_card
from subsea.lab.dataset.formats import FORMATS, remove_formats, write_images
from subsea.lab.dataset.ranges import fitted
from subsea.lab.dataset.scenes import MAPS, DatasetPlan
from subsea.lab.dataset.shards import SHARDS, make_shards
from subsea.scenario.load import load_scenario
from subsea.world.build import create_world

SEQUENCE = 60  # pictures of a sequence


def make_dataset(
    plan: DatasetPlan,
    images: int,
    out: Path,
    *,
    formats: Sequence[str] = ("coco",),
    shard: int = 20,
    pool: Pool[str] = serial,
    force: bool = False,
    check: Check = lambda: None,
) -> Path:
    """Make a set in a folder, or what is missing there; returns the path of its card.

    Raises a UserError for values that cannot be, before the first picture.
    """
    for name in formats:
        if name not in FORMATS:
            raise unknown("format", name, list(FORMATS))
    for name in plan.maps:
        if name not in MAPS:
            raise unknown("map", name, list(MAPS))
    if "mot" in formats and not plan.sequence:
        plan = replace(plan, sequence=True, per_scene=SEQUENCE, every=1)
    loaded = load_scenario(plan.scenario)

    def accepts(change: str) -> bool:
        try:
            load_scenario(plan.scenario, [change])
        except UserError:
            return False
        return True

    plan = replace(plan, ranges=fitted(plan.ranges, accepts))
    if force and (out / SHARDS).is_dir():
        remove_formats(out)
    paths = make_shards(plan, images, out, shard=shard, pool=pool, force=force, check=check)
    species = tuple(one.name for one in create_world(loaded.scenario, plan.seed, plan.fish).species)
    say(f"writing {', '.join(formats)}")
    if set(formats) - {"webdataset"}:
        write_images(out, paths)
    for name in formats:
        check()
        FORMATS[name](out, plan, species, paths)
    write_card(out, plan, formats, species, paths)
    return out / "README.md"
