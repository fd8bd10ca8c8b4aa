"""Repertoire files: what is written is read back, and nothing damaged gets in."""

import dataclasses
import subprocess
import sys
import zlib

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.fish.skinning import couple
from subsea.repertoire import BASIC_SEGMENTS, SEGMENTS, read_repertoire, write_repertoire
from subsea.repertoire.library import pack
from subsea.repertoire.schema import SUBSTITUTES, VERSION
from subsea.repertoire.transitions import plan_transitions


@pytest.fixture
def path(tmp_path, known_repertoire):
    file = tmp_path / "known.h5"
    write_repertoire(file, known_repertoire)
    return file


def test_written_and_read_back(path, known_repertoire):
    back = read_repertoire(path)
    assert back.provenance == known_repertoire.provenance
    assert back.segments.keys() == known_repertoire.segments.keys()
    for name, segment in known_repertoire.segments.items():
        for field in dataclasses.fields(segment):
            np.testing.assert_array_equal(
                getattr(back.segments[name], field.name), getattr(segment, field.name)
            )


def test_transitions_are_planned_once_when_the_file_is_written(path, known_repertoire):
    planned = plan_transitions([known_repertoire.segments[name] for name in BASIC_SEGMENTS])
    stored = read_repertoire(path).transitions
    for here, there in zip(stored, planned, strict=True):
        np.testing.assert_array_equal(here, there)
    with h5py.File(path, "r+") as file:
        del file["transitions"]
    bare = read_repertoire(path)
    assert bare.transitions is None
    coupling = couple("sections", bare.rest_nodes, np.zeros((426, 3)))
    np.testing.assert_array_equal(pack([bare], [coupling]).entry[:84, :7], planned.entry)


def test_version_2_plays_on(path, known_repertoire):
    """It has the basic segments; the others are played as their substitutes."""
    with h5py.File(path, "r+") as file:
        file.attrs["version"] = 2
    old = read_repertoire(path)
    assert old.recorded_names() == list(BASIC_SEGMENTS)
    library = pack([old], [couple("sections", old.rest_nodes, np.zeros((426, 3)))])
    for name, substitute in SUBSTITUTES.items():
        here, there = SEGMENTS.index(name), SEGMENTS.index(substitute)
        assert library.has[0, there] and not library.has[0, here]
        for table in (library.first, library.length, library.cyclic, library.speed):
            assert table[0, here] == table[0, there]
        for table in (library.entry, library.glide, library.leave):
            np.testing.assert_array_equal(table[:, here], table[:, there])


def test_the_same_contents_are_the_same_bytes(path, tmp_path, known_repertoire):
    write_repertoire(tmp_path / "again.h5", known_repertoire)
    assert path.read_bytes() == (tmp_path / "again.h5").read_bytes()


def test_a_fault_while_writing_leaves_the_old_file(path, known_repertoire):
    before = path.read_bytes()
    segments = dict(known_repertoire.segments, broken=None)
    with pytest.raises(AttributeError):
        write_repertoire(path, dataclasses.replace(known_repertoire, segments=segments))
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def _set(key, value):
    def change(file):
        file.attrs[key] = value

    return change


def _replace(name, value):
    def change(file):
        del file[name]
        if value is not None:
            file[name] = value

    return change


def _borrowed(source):
    """Numbers that are in another file, or, of ".", that are themselves."""

    def change(file):
        name = "segments/swim_slow/nodes"
        layout = h5py.VirtualLayout((12, 23, 3), "f8")
        layout[...] = h5py.VirtualSource(source, name, (12, 23, 3))
        del file[name]
        file.create_virtual_dataset(name, layout)

    return change


def half_a_gigabyte():
    """Pack zeros."""
    return zlib.compress(bytes(2**29), 1)


def _packed(*more, **how):
    """Numbers that are packed somehow, and what their only piece holds instead of them."""

    def change(file):
        name = "segments/swim_slow/nodes"
        del file[name]
        made = file.create_dataset(name, (12, 23, 3), "f8", **how)
        for piece in more:
            made.id.write_direct_chunk((0, 0, 0), piece())

    return change


DAMAGE = {
    "another format": (_set("format", np.bytes_("movie")), "not a repertoire"),
    "a later version": (
        _set("version", 99),
        f"version 99, this program reads versions 2 to {VERSION}; update subsea or record it again",
    ),
    "an earlier version": (
        _set("version", 1),
        f"version 1, this program reads versions 2 to {VERSION}; record it again",
    ),
    "no length": (_set("body_length_cm", -1.0), "body_length_cm"),
    "provenance that is not JSON": (_set("provenance", np.bytes_("{")), "provenance"),
    "rest nodes of another fish": (_replace("rest/nodes", np.zeros((22, 3))), "22×3"),
    "no segments": (_replace("segments", None), "segments"),
    "numbers that are NaN": (
        _replace("segments/swim_slow/nodes", np.full((12, 23, 3), np.nan)),
        "not finite",
    ),
    "text for numbers": (_replace("segments/swim_slow/nodes", "abc"), "floating-point"),
    "rotations that stretch": (
        _replace("segments/swim_slow/increment_rotation", np.ones((12, 4))),
        "unit quaternions",
    ),
    "frames that do not match": (
        _replace("segments/swim_slow/increment_translation", np.zeros((11, 3))),
        "11×3",
    ),
    "a fish as large as a house": (
        _replace("segments/swim_slow/nodes", np.full((12, 23, 3), 1e4)),
        "body lengths",
    ),
    "a link to another file": (
        _replace("segments/swim_slow/nodes", h5py.ExternalLink("/etc/passwd", "/x")),
        "expected a dataset",
    ),
    "a string in the heap": (_set("source", "biomechanics"), "is not a text"),
    "a reference for a number": (_set("tick_s", h5py.Reference()), "is not a number"),
    "numbers for a number": (_set("tick_s", [0.033, 0.033]), "is not a number"),
    "a glide into another species": (
        _replace("transitions/entry", np.full((84, 7), 84, np.int16)),
        "transitions/entry: leads into swim_slow",
    ),
    "a glide into the middle of a sharp turn": (
        _replace("transitions/entry", np.tile(np.arange(0, 84, 12, np.int16) + 1, (84, 1))),
        "transitions/entry: leads into turn_left_sharp",
    ),
    "a glide that takes no time": (
        _replace("transitions/frames", np.zeros((84, 7), np.int16)),
        "transitions/frames: expected 1 to 14",
    ),
    "a swim without end": (
        _replace("transitions/leave", np.zeros((84, 7), np.int16)),
        "no way leads out of swim_slow",
    ),
    "halves for rows": (_replace("transitions/entry", np.full((84, 7), 0.5)), "84×7 whole"),
    "numbers of another file": (_borrowed("/etc/passwd"), "in other files"),
    "numbers of itself": (_borrowed("."), "in other files"),
    "a piece larger than all": (
        _packed(maxshape=(None,) * 3, chunks=(2**14, 2**10, 32), compression="gzip"),
        "packed in an unusual way",
    ),
    "more than its piece may hold": (
        _packed(half_a_gigabyte, chunks=(12, 23, 3), compression="gzip"),
        "packed in an unusual way",
    ),
    "packed by another way": (_packed(chunks=(12, 23, 3), compression="lzf"), "unusual way"),
    "JSON within JSON": (_set("provenance", np.bytes_(b"[" * 30_000)), "not JSON"),
    "a link to itself": (_replace("segments", h5py.SoftLink("/")), "expected a group"),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_refused_in_one_line_that_names_the_file(path, name):
    change, words = DAMAGE[name]
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(UserError) as caught:
        read_repertoire(path)
    message = str(caught.value)
    assert words in message
    assert str(path) in message
    assert "\n" not in message


def test_a_huge_claimed_size_is_refused_without_reading_it(path):
    with h5py.File(path, "r+") as file:
        del file["segments/swim_slow/increment_rotation"]
        file.create_dataset(
            "segments/swim_slow/increment_rotation", (10**9, 4), "f8", chunks=(1000, 4)
        )
    with pytest.raises(UserError, match="implausible"):
        read_repertoire(path)


def test_a_missing_file_is_one_line(tmp_path):
    with pytest.raises(UserError, match="no such file"):
        read_repertoire(tmp_path / "none.h5")


@given(cut=st.floats(0, 0.999), flips=st.lists(st.tuples(st.floats(0, 0.999), st.integers(0, 7))))
def test_truncated_or_flipped_files_are_read_or_refused(tmp_path_factory, damaged, cut, flips):
    data = bytearray(damaged)
    for place, bit in flips[:20]:
        data[int(place * len(data))] ^= 1 << bit
    file = tmp_path_factory.mktemp("damaged") / "x.h5"
    file.write_bytes(data if cut < 0.3 else data[: int(cut * len(data))])
    try:
        read_repertoire(file)
    except UserError as fault:
        assert "\n" not in str(fault)


ZEROED = """
import random, sys
from pathlib import Path
from subsea.base.errors import UserError
from subsea.repertoire import read_repertoire
whole, place = Path(sys.argv[1]).read_bytes(), Path(sys.argv[2])
rng = random.Random(6)
for _ in range(150):
    length = rng.choice([8, 16, 64, 256])
    start = rng.randrange(len(whole) - length)
    place.write_bytes(whole[:start] + bytes(length) + whole[start + length :])
    try:
        read_repertoire(place)
    except UserError as fault:
        assert "\\n" not in str(fault)
"""


@pytest.mark.nightly
def test_no_zeroed_piece_makes_the_reader_hang_or_crash(tmp_path, damaged):
    """In a process of its own, for a loop inside the HDF5 library cannot be interrupted."""
    (tmp_path / "whole.h5").write_bytes(damaged)
    subprocess.run(
        [sys.executable, "-c", ZEROED, tmp_path / "whole.h5", tmp_path / "zeroed.h5"],
        check=True,
        timeout=60,
    )


@pytest.fixture(scope="module")
def damaged(tmp_path_factory, known_repertoire):
    file = tmp_path_factory.mktemp("whole") / "known.h5"
    write_repertoire(file, known_repertoire)
    return file.read_bytes()
