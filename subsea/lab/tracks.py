"""Write the fishes of a record as tracks that other programs read (docs/how-to/convert.md).

movement and trajr get places in the sea, in cm. DeepLabCut and idtracker.ai read places in pictures
of one camera, in pixels. Here that is a camera without perspective, which sees the whole sea.
"""

import csv
import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from subsea import __version__
from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.file_kinds import check_result, csv_file, signed
from subsea.base.files import check_folder, replacing
from subsea.base.hdf5 import writing
from subsea.base.system import require
from subsea.geometry.periodic import in_box
from subsea.geometry.walls import tank_of
from subsea.media.record import STATIONS, Record

SCORER = "subsea"
DIGITS = 3  # after the point, of coordinates in tables
CIRCLE = 36  # points of the sea's border
TRACKER_VERSION = "6.0.14"  # of idtracker.ai, whose tables these are
FULL_BYTES = 2**20  # with less room, a library's failure is that of a full disk
TRACK = ("x", "y", "z", "time")
LIST, LISTED = "fishes.csv", ("file", "fish", "species", "length_cm", "male")
HDF5 = signed("an HDF5 file", b"\x89HDF\r\n\x1a\n")
NUMPY = signed("a NumPy file", b"\x93NUMPY")


@dataclass(frozen=True)
class FlatView:
    """A picture of the whole sea without perspective."""

    name: str = "top"  # or "side"
    px_per_cm: float = 1.0

    def __post_init__(self) -> None:
        """Refuse an unknown view; a UserError."""
        if self.name not in VIEWS:
            raise UserError(f"--view {self.name}: expected {' or '.join(VIEWS)}")

    def pixels(self, places: Array, record: Record) -> Array:
        """Place points (..., 3), cm, in the picture (..., 2): x to the right and y down, px."""
        right = places[..., 0] + record.radius_cm
        down = record.radius_cm - places[..., 1] if self.name == "top" else -places[..., 2]
        return self.px_per_cm * np.stack([right, down], axis=-1).astype(np.float64)

    def size(self, record: Record) -> tuple[int, int]:
        """Width and height of the picture, px."""
        high = 2.0 * record.radius_cm if self.name == "top" else -float(record.heights.min())
        return (
            int(np.ceil(2.0 * record.radius_cm * self.px_per_cm)),
            int(np.ceil(high * self.px_per_cm)),
        )


VIEWS = ("top", "side")


def write_movement(record: Record, out: Path, force: bool = False) -> None:
    """Write the dataset of `Record.to_movement` as netCDF."""
    check_result(out, HDF5, force)
    dataset = record.to_movement()
    import xarray

    with _writing(out) as temporary:
        dataset.to_netcdf(temporary, engine="netcdf4", format="NETCDF4")
        with xarray.open_dataset(temporary, engine="netcdf4") as stored:
            if not stored.load().identical(dataset):
                raise OSError(errno.EIO, os.strerror(errno.EIO))


def write_deeplabcut(record: Record, out: Path, view: FlatView, force: bool = False) -> None:
    """Write the points of all fishes as DeepLabCut does: CSV, or HDF5 by pandas.

    A table of one fish lacks the row of individuals, as that of a project with one animal.
    """
    table = out.suffix == ".csv"
    check_result(out, csv_file("a table of DeepLabCut", "scorer", SCORER) if table else HDF5, force)
    names, points = record.body_points
    inside = in_box(points, record.position[:, :, None], record.period)  # as a camera sees it
    places = view.pixels(inside, record)  # (T, n, k, 2)
    sure = np.broadcast_to(record.alive[..., None, None], (*places.shape[:3], 1))
    values = np.concatenate([np.where(sure, places, np.nan), np.where(sure, 1.0, np.nan)], axis=3)
    values = values.reshape(len(values), -1)
    levels = {
        "scorer": [SCORER], "individuals": record.individuals, "bodyparts": [*names],
        "coords": ["x", "y", "likelihood"],
    }  # fmt: skip
    if len(record.individuals) == 1:
        del levels["individuals"]
    columns = [*_product(*levels.values())]
    if table:
        with _writing(out) as temporary:
            _write_rows(temporary, levels, columns, values)
        return
    require("tracks", "HDF5 of DeepLabCut (without it: a name that ends in .csv)")
    import pandas

    frame = pandas.DataFrame(
        values, columns=pandas.MultiIndex.from_tuples(columns, names=[*levels])
    )
    with _writing(out) as temporary:
        # In memory, as PyTables says nothing of a disk that is full when it closes a file.
        memory = {"driver": "H5FD_CORE", "driver_core_backing_store": 0}
        with pandas.HDFStore("tracks", "w", **memory) as store:
            store.put("df_with_missing", frame, track_times=False)
            image = store._handle.get_file_image()
        temporary.write_bytes(image)


def _product(*levels: list[str]) -> Iterator[tuple[str, ...]]:
    from itertools import product

    yield from product(*levels)


def _write_rows(
    path: Path, levels: dict[str, list[str]], columns: list[tuple[str, ...]], values: Array
) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        for k, level in enumerate(levels):
            writer.writerow([level, *(column[k] for column in columns)])
        for number, row in enumerate(values):
            writer.writerow([number, *("" if value != value else _short(value) for value in row)])


def _short(value: float) -> str:
    return f"{value:.{DIGITS}f}"


def write_trajr(record: Record, out: Path, force: bool = False) -> None:
    """Write a CSV file of each fish's centre of mass into a folder, and a list of the files."""
    check_folder(out)
    files = [out / f"{name}.csv" for name in record.individuals]
    kinds = {path: csv_file("a track", *TRACK) for path in files}
    kinds[out / LIST] = csv_file("a list of tracks", *LISTED)
    for path, kind in kinds.items():
        check_result(path, kind, force)
    for i, path in enumerate(files):
        there = record.alive[:, i]
        rows = np.column_stack([record.centre[there, i], record.time[there]])
        with _writing(path) as temporary:
            np.savetxt(
                temporary, rows, f"%.{DIGITS + 1}f", ",", header=",".join(TRACK), comments=""
            )
    with (
        _writing(out / LIST) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(LISTED)
        for i, path in enumerate(files):
            kind = record.keys[record.species[i]]
            male = str(bool(record.male[i])).upper()  # as R writes it
            writer.writerow([path.name, i, kind, _short(record.length[i]), male])


def write_idtrackerai(record: Record, out: Path, view: FlatView, force: bool = False) -> None:
    """Write the centres of mass as idtracker.ai writes trajectories: .h5, or .npy for NumPy."""
    numpy = out.suffix == ".npy"
    check_result(out, NUMPY if numpy else HDF5, force)
    found = tracker_table(record, view, out.stem)
    if numpy:
        with _writing(out) as temporary, temporary.open("wb") as file:
            np.save(file, np.array(found), allow_pickle=True)
        return
    with writing(out) as file:
        for name, value in found.items():
            if isinstance(value, dict):
                group = file.create_group(name)
                for key, one in value.items():
                    group[key] = np.asarray(one)
            elif isinstance(value, np.ndarray):
                file.create_dataset(name, data=value, compression="gzip")
            else:
                file.attrs[name] = value


def tracker_table(record: Record, view: FlatView, title: str) -> dict[str, Any]:
    """Make the dictionary of idtracker.ai's trajectories; all identities are certain."""
    width, height = view.size(record)
    alive = record.alive
    inside = in_box(record.centre, record.position, record.period)  # as a camera sees it
    places = np.where(alive[..., None], view.pixels(inside, record), np.nan)
    outline = record.half_width if view.name == "top" else record.half_height
    share = 2.0 * np.asarray(np.trapezoid(outline, dx=1.0 / (STATIONS - 1), axis=1))
    areas = share[record.species] * (record.length * view.px_per_cm) ** 2
    return {
        "trajectories": places,
        "id_probabilities": alive[..., None].astype(np.float64),
        "version": TRACKER_VERSION,
        "source": f"subsea {__version__}, view {view.name}",
        "height": height,
        "width": width,
        "video_paths": [f"{title}.h5"],
        "frames_per_second": 1.0 / record.tick_s,
        "body_length": float(np.median(record.length) * view.px_per_cm),
        "estimated_accuracy": 1.0,
        "areas": {"mean": areas, "median": areas, "std": np.zeros_like(areas)},
        "setup_points": {"border": _border(record, view)} if view.name == "top" else {},
        "identities_labels": record.individuals,
        "identities_groups": {
            key: [int(i) + 1 for i in np.flatnonzero(record.species == k)]
            for k, key in enumerate(record.keys)
        },
        "length_unit": float(view.px_per_cm),
        "fraction_identified": float(alive.mean()),
    }


def _border(record: Record, view: FlatView) -> Array:
    """List the points (k, 2) around the tank or box, or the sea, seen from the top, px."""
    sides = tuple(record.period) if record.period[0] else tank_of(record.pillars)
    if sides:
        corners = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]) * sides / 2
    else:
        angle = np.linspace(0.0, 2.0 * np.pi, CIRCLE, endpoint=False)
        corners = record.radius_cm * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return view.pixels(corners, record)


@contextmanager
def _writing(out: Path) -> Iterator[Path]:
    """Write a file that is whole, by a library whose errors are of any kind."""
    with replacing(out) as temporary:
        try:
            yield temporary
        except (OSError, UserError):
            raise
        except Exception as fault:  # of PyTables and netCDF4, which tell no reason
            if shutil.disk_usage(temporary.parent).free < FULL_BYTES:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) from fault
            raise OSError(f"{type(fault).__name__}: {fault}") from fault


SUFFIXES = {
    "movement": (".nc",),
    "deeplabcut": (".h5", ".csv"),
    "trajr": (),
    "idtrackerai": (".h5", ".npy"),
}
"""Ends of the name of a file for each target; none is a folder."""


def convert(
    record: Record, target: str, out: Path, view: FlatView | None = None, force: bool = False
) -> None:
    """Write a record for a target of `SUFFIXES`.

    A UserError for a wrong name, and for a view of targets that get places in the sea.
    """
    suffixes = SUFFIXES[target]
    if suffixes and out.suffix not in suffixes:
        raise UserError(f"expected a name that ends in {' or '.join(suffixes)}", file=out)
    flat = {"deeplabcut": write_deeplabcut, "idtrackerai": write_idtrackerai}
    if target in flat:
        flat[target](record, out, view or FlatView(), force)
        return
    if view is not None:
        raise UserError(f"--view and --px-per-cm: {target} gets places in the sea, in cm")
    write = write_movement if target == "movement" else write_trajr
    write(record, out, force)
