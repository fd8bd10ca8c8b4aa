"""`subsea dataset`: labelled pictures for detectors, pose heads and trackers."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.dive import arguments as shared
from subsea.lab.sweep_command import add_jobs, check_jobs, pool_of

GROUP = "simulate and study"  # in the help


def names(text: str) -> tuple[str, ...]:
    """Read names that commas separate."""
    return tuple(part.strip() for part in text.split(",") if part.strip())


def add(commands: Any) -> None:
    """Add the command."""
    from subsea.jobs.dask_cluster import add_cluster

    parser = add_command(
        commands,
        "dataset",
        "make labelled pictures that train detectors",
        "Writes N pictures with boxes, masks and keypoints of all fishes to DIR, in shards. The\n"
        "same command continues an interrupted set; a damaged shard is made again.\n"
        "docs/how-to/dataset.md describes the formats. Nothing was tested on real images.",
        [
            "subsea dataset schooling --out fishes --images 1000 --format coco,yolo",
            "subsea dataset schooling --out many --images 500 --vary water.hour=7:17 "
            "--vary water.type=IB,II,III --vary sensor.noise=0:8",
            "subsea dataset schooling --out tracks --images 600 --format mot",
        ],
    )
    parser.add_argument("scenario", metavar="SCENARIO", help="name or .toml file")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the set")
    parser.add_argument(
        "--images", type=number_reader(int, 1, 10_000_000), required=True, metavar="N",
        help="number of pictures",
    )  # fmt: skip
    parser.add_argument(
        "--format",
        type=names,
        action="append",
        metavar="F,…",
        help="coco (default), yolo, mot, deeplabcut, webdataset",
    )
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="KEY=LOW:HIGH",
        help="range, or KEY=A,B,C: of the scenario's keys for each scene, of camera.field_deg, "
        "camera.distance, camera.lamps, sensor.noise, sensor.blur_px, jpeg.quality … for each "
        "picture",
    )
    parser.add_argument(
        "--ranges", type=Path, metavar="FILE.toml", help='file of lines "KEY" = "LOW:HIGH"'
    )
    parser.add_argument(
        "--camera",
        action="append",
        metavar="C",
        help="random (default: near a fish), submarine, or X,Y,Z,HEADING,PITCH in cm and degrees; "
        "of several one is drawn for each picture",
    )
    parser.add_argument(
        "--maps", type=names, default=(), metavar="M,…",
        help="also write maps of each pixel: identity, depth, normal, flow",
    )  # fmt: skip
    parser.add_argument(
        "--sequence",
        type=number_reader(int, 2, 100_000),
        metavar="N",
        help="take N pictures with one camera in successive ticks, then another scene",
    )
    parser.add_argument(
        "--per-scene", type=number_reader(int, 1, 100_000), default=20, metavar="N",
        help="pictures of one world (default 20)",
    )  # fmt: skip
    parser.add_argument(
        "--every", type=number_reader(float, 0.033, 3600), metavar="S",
        help="seconds between pictures of a scene (default 0.5, in a sequence one tick)",
    )  # fmt: skip
    parser.add_argument(
        "--val", type=number_reader(float, 0, 1), default=0.1, metavar="SHARE",
        help="share of the scenes for validation (default 0.1)",
    )  # fmt: skip
    parser.add_argument(
        "--shard", type=number_reader(int, 1, 100_000), default=20, metavar="N",
        help="pictures of a shard (default 20)",
    )  # fmt: skip
    shared.add(parser, "fish")
    parser.add_argument("--size", **shared.OPTIONS["size"] | {"help": "pixels (default 640x480)"})
    parser.add_argument(
        "--seed", type=number_reader(int, 0, 2**32 - 1), default=0, metavar="N",
        help="seed of all that is drawn (default 0)",
    )  # fmt: skip
    shared.add_quality(parser, "medium", automatic=False)
    add_jobs(parser)
    add_cluster(parser)
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Make the set."""
    from subsea.base.interrupts import deferred_interrupts
    from subsea.lab.dataset.make import make_dataset
    from subsea.lab.dataset.ranges import read_ranges
    from subsea.lab.dataset.scenes import RANDOM, DatasetPlan
    from subsea.world.world import TICK_S

    check_jobs(options)
    every_s = options.every or (TICK_S if options.sequence else 0.5)
    plan = DatasetPlan(
        scenario=options.scenario,
        seed=options.seed,
        fish=options.fish,
        size=options.size or (640, 480),
        cameras=tuple(options.camera or (RANDOM,)),
        ranges=read_ranges(options.vary, options.ranges),
        per_scene=options.sequence or options.per_scene,
        every=max(round(every_s / TICK_S), 1),
        sequence=options.sequence is not None,
        maps=options.maps,
        quality=options.quality,
        val=options.val,
    )
    pool = pool_of(options)
    with deferred_interrupts() as check:
        card = make_dataset(
            plan,
            options.images,
            options.out,
            formats=[name for some in options.format or [("coco",)] for name in some],
            shard=options.shard,
            pool=pool,
            force=options.force,
            check=check,
        )
    print(card)
    return 0
