"""The card of a set: what it holds, how it was made, and what it lacks."""

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from subsea import __version__
from subsea.base.files import replacing
from subsea.lab.dataset.formats import LEAST_PX, annotated
from subsea.lab.dataset.keypoints import NAMES
from subsea.lab.dataset.labelling import VISIBLE
from subsea.lab.dataset.ranges import picture_ranges, scene_ranges
from subsea.lab.dataset.scenes import DatasetPlan
from subsea.lab.dataset.shards import read_shard

LICENCE = (
    "The pictures are made by subsea, whose licence is MIT, from its own models. You may use them "
    "as you like. Skins that you made from photographs keep the licence of the photographs."
)
LACKS = (
    "Nothing here was compared with real images: how well a model trained on it does in the sea is "
    "not known.",
    "There are no divers, nets, boats, turtles, jellyfishes, crabs or litter, and no fishes other "
    "than the species below.",
    "The water scatters light by a formula: no sediment clouds, no bubbles on the lens, no dirt on "
    "the port, no rolling shutter, no motion blur.",
    "Fishes of one species differ in size, tint and small marks only; none is young, sick or hurt "
    "beyond torn fins and scars.",
)


def write_card(
    out: Path, plan: DatasetPlan, formats: Sequence[str], species: Sequence[str],
    shards: Iterable[Path],
) -> None:  # fmt: skip
    """Write ``README.md`` and ``card.json``."""
    counts, splits, scenes, keypoints = Counter[str](), Counter[str](), set[int](), Counter[str]()
    sizes: list[int] = []
    for shard in shards:
        for about, _ in read_shard(shard):
            splits[about["split"]] += 1
            scenes.add(about["scene"])
            for fish in annotated(about):
                counts[fish["species"]] += 1
                sizes.append(fish["pixels"])
                for name, (_, _, state, *_) in zip(NAMES, fish["keypoints"], strict=True):
                    keypoints[name] += state == VISIBLE
    sizes.sort()
    ranges = scene_ranges(plan.ranges) | picture_ranges(plan.ranges)
    card: dict[str, Any] = {
        "made_by": f"subsea {__version__}",
        "scenario": plan.scenario,
        "seed": plan.seed,
        "pictures": dict(splits),
        "scenes": len(scenes),
        "pictures_per_scene": plan.per_scene,
        "ticks_between_pictures": plan.every,
        "size": list(plan.size),
        "quality": plan.quality,
        "cameras": list(plan.cameras),
        "formats": list(formats),
        "maps": list(plan.maps),
        "ranges": {
            key: list(one.choices) or {"low": one.low, "high": one.high}
            for key, one in ranges.items()
        },
        "species": list(species),
        "fishes": {name: counts[name] for name in species},
        "least_pixels": LEAST_PX,
        "median_pixels": sizes[len(sizes) // 2] if sizes else 0,
        "visible_keypoints": {name: keypoints[name] for name in NAMES},
        "licence": LICENCE,
        "lacks": list(LACKS),
    }
    with replacing(out / "card.json") as temporary:
        temporary.write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")
    with replacing(out / "README.md") as temporary:
        temporary.write_text(_page(card), encoding="utf-8")


def _page(card: dict[str, Any]) -> str:
    """Write a card as a page."""
    pictures = ", ".join(f"{n} for {split}" for split, n in sorted(card["pictures"].items()))
    ranges = "".join(f"| `{key}` | {_words(value)} |\n" for key, value in card["ranges"].items())
    fishes = "".join(f"| {name} | {n} |\n" for name, n in card["fishes"].items())
    return f"""# Labelled pictures of {card["scenario"]}

Made by {card["made_by"]} from the scenario `{card["scenario"]}` with the seed {card["seed"]}.
**{LACKS[0]}**

- Pictures: {pictures}, {card["size"][0]}×{card["size"][1]} pixels, from {card["scenes"]} scenes.
  A scene is wholly in one of the two parts.
- Cameras: {", ".join(card["cameras"])}. Quality: {card["quality"]}.
- Formats: {", ".join(card["formats"])}. Maps: {", ".join(card["maps"]) or "none"}.
- Fishes with fewer than {LEAST_PX} visible pixels, or beyond the visibility of their water, are not
  annotated. Half of those annotated have at least {card["median_pixels"]} pixels.

| drawn | values |
| --- | --- |
{ranges}
| species | annotated fishes |
| --- | --- |
{fishes}
## Licence

{LICENCE}

## Not in this set

{"".join(f"- {one}{chr(10)}" for one in LACKS)}"""


def _words(value: Any) -> str:
    if isinstance(value, dict):
        return f"{value['low']:g} to {value['high']:g}"
    return ", ".join(str(one) for one in value)
