"""Results replace files of their own kind only."""

import json
import struct

import pytest

from subsea.base import hdf5
from subsea.base.errors import UserError
from subsea.base.file_kinds import (
    FILM,
    GLTF,
    MESH,
    PICTURE,
    check_result,
    csv_file,
    hdf5_file,
    json_file,
    toml_file,
)

RECORD = hdf5_file("a record", "subsea-record")
REPORT = json_file("a report", "frame_ms", "ladder")
TABLE = csv_file("a table", "fish", "frame")
SPECIES = toml_file("a species", "surface", "skin")
NOTES = b"# Notes\n\nMilk, bread.\n"
PNG = b"\x89PNG\r\n\x1a\n" + bytes(20)
MP4 = struct.pack(">I4s", 24, b"ftyp") + bytes(16)


def hdf5_bytes(path, form):
    with hdf5.writing(path) as file:
        file.attrs["format"] = hdf5.text(form)
    return path.read_bytes()


@pytest.mark.parametrize(
    ("kind", "own", "others"),
    [
        (FILM, MP4, [PNG, NOTES]),
        (PICTURE, PNG, [MP4, NOTES, b"x"]),
        (GLTF, b"glTF" + bytes(20), [PNG]),
        (MESH, b"# a fish\no fish\nv 1 2 3\nf 1 2 3\n", [NOTES, PNG, b"\n\n"]),
        (REPORT, b'{"ladder": []}', [b"[1]", b'{"name": "x"}', b"{", PNG, b"[" * 100_000]),
        (TABLE, b"fish,frame,frame_ms\n1,0,2\n", [b"frame,fish\n", NOTES, PNG]),
        (SPECIES, b"[surface]\n[skin]\n", [b"[skin]\n", b"= 3", PNG]),
    ],
)
def test_only_a_file_of_the_same_kind_is_replaced(tmp_path, kind, own, others):
    path = tmp_path / "result"
    check_result(path, kind)
    for content in (b"", own):
        path.write_bytes(content)
        check_result(path, kind)
    for content in others:
        path.write_bytes(content)
        with pytest.raises(UserError) as fault:
            check_result(path, kind)
        expected = f"{path}: exists and is not {kind.noun}; choose another name or give --force"
        assert str(fault.value) == expected
        check_result(path, kind, force=True)
        assert path.read_bytes() == content


def test_a_record_is_known_by_its_format(tmp_path):
    path = tmp_path / "run.h5"
    check_result(path, RECORD)
    hdf5_bytes(path, "subsea-record")
    check_result(path, RECORD)
    for content in (hdf5_bytes(path, "subsea-repertoire"), path.read_bytes()[:200], NOTES):
        path.write_bytes(content)
        with pytest.raises(UserError, match="is not a record"):
            check_result(path, RECORD)


def test_a_folder_is_refused_with_force_too(tmp_path):
    with pytest.raises(UserError, match="is a folder"):
        check_result(tmp_path, REPORT, force=True)


def test_a_report_is_read_whole(tmp_path):
    path = tmp_path / "report.json"
    path.write_text(json.dumps({"set": ["x" * 10_000], "frame_ms": {}}))
    check_result(path, REPORT)
