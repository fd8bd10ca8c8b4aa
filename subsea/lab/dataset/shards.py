"""Make a set in shards: tar files of stable bytes, which are checked, and made again if damaged.

A shard is a tar file as WebDataset reads it: ``000012.jpg``, ``000012.json`` and the maps of each
picture. A file beside it has its checksum. Other formats are written from the shards.
"""

import hashlib
import io
import json
import tarfile
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from subsea.base.errors import UserError
from subsea.base.files import (
    check_folder,
    file_hash,
    read_input,
    remove_abandoned,
    replacing,
)
from subsea.base.progress import count_noun, progress, say
from subsea.jobs.workers import MAX_ATTEMPTS, Check, Pool, serial
from subsea.lab.dataset.scenes import (
    RANDOM,
    SUBMARINE,
    DatasetPlan,
    changes_at_ends,
    check_cameras,
    shots,
)
from subsea.lab.recording import provenance_of
from subsea.library import World
from subsea.scenario.load import LoadedScenario, load_scenario
from subsea.world.build import create_world

SHARDS = "shards"
MOST_IMAGES = 10_000_000
DIGITS = 7  # of the numbers of pictures in names


class _ShardJob(NamedTuple):
    """A shard for a worker, which may be another computer."""

    plan: DatasetPlan
    name: str  # of the scenario's file
    content: bytes
    inputs: str  # digest of everything that the pictures depend on
    first: int
    stop: int


def image_name(number: int) -> str:
    """Name a picture without the ending of its file."""
    return f"{number:0{DIGITS}}"


def make_shards(
    plan: DatasetPlan,
    images: int,
    out: Path,
    *,
    shard: int,
    pool: Pool[str] = serial,
    force: bool = False,
    check: Check = lambda: None,
) -> list[Path]:
    """Make the shards of a set that the folder `out` lacks; returns the paths of all.

    A shard whose bytes differ from its checksum is made again. `check` is called meanwhile and may
    raise; finished shards stay. Raises a UserError for invalid values before the first shard, and
    at the end if processes crashed.
    """
    check_folder(out)
    jobs = _jobs(plan, images, shard)
    paths = {name: out / SHARDS / f"{name}.tar" for name in jobs}
    _check_others(out, next(iter(jobs.values())).inputs, force)
    whole = {name for name, job in jobs.items() if not force and _is_whole(paths[name], job)}
    missing = {name: job for name, job in jobs.items() if name not in whole}
    crashed: list[str] = []
    if missing:
        remove_abandoned(out / SHARDS)
    try:
        done = sum(jobs[name].stop - jobs[name].first for name in whole)
        with progress(images, "image", done) as count:
            for name, data in pool(make_shard, missing, check):
                if data is None:
                    crashed.append(name)
                    continue
                _save(paths[name], jobs[name], data)
                count(jobs[name].stop - jobs[name].first)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"{out}: finished shards kept; run the same command to continue"
        ) from None
    if crashed:
        raise UserError(
            f"without {count_noun(len(crashed), 'shard', 'shards')} whose process crashed "
            f"{MAX_ATTEMPTS} times ({', '.join(crashed[:5])}); is there enough memory?",
            file=out,
        )
    return [*paths.values()]


def make_shard(job: _ShardJob) -> bytes:
    """Make a shard on any computer; returns its tar file."""
    file = io.BytesIO()
    with (
        TemporaryDirectory() as folder,
        tarfile.open(fileobj=file, mode="w", format=tarfile.USTAR_FORMAT) as tar,
    ):
        path = Path(folder) / job.name
        path.write_bytes(job.content)
        if _inputs(job.plan, load_scenario(str(path))) != job.inputs:
            raise UserError(
                "a worker has another version of subsea, numpy, numba or the species; install the "
                "same"
            )
        for shot in shots(job.plan, str(path), range(job.first, job.stop)):
            for ending, data in shot.files.items():
                info = tarfile.TarInfo(f"{image_name(shot.number)}.{ending}")
                info.size, info.mtime, info.mode = len(data), 0, 0o644
                tar.addfile(info, io.BytesIO(data))
    return file.getvalue()


def read_shard(path: Path) -> Iterator[tuple[dict[str, Any], dict[str, bytes]]]:
    """Read the pictures of a shard: what ``.json`` says, and the other files by their ending."""
    with tarfile.open(path) as tar:
        files: dict[str, bytes] = {}
        name = ""
        for info in tar:
            key, _, ending = info.name.partition(".")
            if key != name and files:
                yield json.loads(files.pop("json")), files
                files = {}
            content = tar.extractfile(info)
            assert content is not None
            name, files[ending] = key, content.read()
        if files:
            yield json.loads(files.pop("json")), files


def _jobs(plan: DatasetPlan, images: int, shard: int) -> dict[str, _ShardJob]:
    """List all shards; checks the scenario at the ends of all ranges, and fixed cameras."""
    if not 1 <= images <= MOST_IMAGES:
        raise UserError(f"{images:,} images, expected 1 to {MOST_IMAGES:,}")
    loaded = load_scenario(plan.scenario)
    for changes in changes_at_ends(plan.ranges):
        load_scenario(plan.scenario, changes)
    if not any(shoal.number for shoal in loaded.scenario.fish):
        raise UserError("has no fishes, nothing to label", file=loaded.path)
    if set(plan.cameras) - {RANDOM, SUBMARINE}:
        world = create_world(loaded.scenario, plan.seed, plan.fish, source=str(loaded.path))
        check_cameras(plan, World(world))
    content = read_input(loaded.path)
    inputs = _inputs(plan, loaded)
    ends = [(first, min(first + shard, images)) for first in range(0, images, shard)]
    name = loaded.path.name
    return {f"{k:05}": _ShardJob(plan, name, content, inputs, *end) for k, end in enumerate(ends)}


def _inputs(plan: DatasetPlan, loaded: LoadedScenario) -> str:
    """Hash everything that the pictures of a plan depend on, beside their numbers."""
    described = asdict(replace(plan, scenario=loaded.path.name))
    described["origin"] = provenance_of(*loaded, __file__)
    text = json.dumps(described, default=str, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _is_whole(path: Path, job: _ShardJob) -> bool:
    """True if a shard has the bytes of its checksum, and is of this set."""
    about = _about(path)
    if about is None:
        return False
    if about.get("inputs") != job.inputs or about.get("images") != [job.first, job.stop]:
        return False
    if path.is_file() and file_hash(path) == about.get("sha256"):
        return True
    say(f"{path}: damaged, it is made again")
    return False


def _about(path: Path) -> dict[str, Any] | None:
    """Read the file beside a shard; None if it is missing or damaged."""
    try:
        about = json.loads(read_input(path.with_suffix(".json")))
    except (UserError, ValueError, RecursionError):
        return None
    return about if isinstance(about, dict) else None


def _check_others(out: Path, inputs: str, force: bool) -> None:
    """Refuse a folder with shards of another set."""
    for path in sorted((out / SHARDS).glob("*.json")):
        about = _about(path)
        if about is not None and about.get("inputs") != inputs and not force:
            raise UserError(
                "holds another set, or one of another version; name another folder, or give "
                "--force to replace it",
                file=out,
            )


def _save(path: Path, job: _ShardJob, data: bytes) -> None:
    """Write a finished shard, and its checksum after it."""
    with replacing(path) as temporary:
        temporary.write_bytes(data)
    about = {
        "inputs": job.inputs,
        "images": [job.first, job.stop],
        "sha256": hashlib.sha256(data).hexdigest(),
    }
    with replacing(path.with_suffix(".json")) as temporary:
        temporary.write_text(json.dumps(about) + "\n", encoding="utf-8")
