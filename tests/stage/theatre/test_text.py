"""Theatre files and meshes as other editors and programs save their text."""

import codecs
import io
import json
import zipfile

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.mesh_formats import parse_frustum, read_mesh
from subsea.stage.theatre.mpcdi import read_mpcdi
from tests.support import theatre_samples as samples

QUAD = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
OBJ = QUAD + "f 1/1 2/2 3/3 4/4\n"
DATA = "2\n2 2\n-1 -1 0 0 1\n1 -1 1 0 1\n-1 1 0 1 1\n1 1 1 1 1\n"
MESHES = {
    "a.obj": OBJ, "a.data": DATA, "a.csv": samples.csv().decode(), "a.ol": samples.ol().decode(),
    "a.skyskan": samples.skyskan().decode(), "a.simcad": samples.simcad().decode(),
}  # fmt: skip
SIZE = 640, 480


def latin(text):
    """Text with a comment in Latin-1."""
    begin, end = ("<!-- ", " -->") if "<GeometryFile>" in text else ("# ", "")
    head, _, rest = text.partition("\n")
    return f"{head}\n{begin}für Gäste{end}\n{rest}".encode("latin-1")


WAYS = {
    "utf-8": lambda text: codecs.BOM_UTF8 + text.encode(),
    "utf-16-le": lambda text: codecs.BOM_UTF16_LE + text.encode("utf-16-le"),
    "utf-16-be": lambda text: codecs.BOM_UTF16_BE + text.encode("utf-16-be"),
    "windows": lambda text: text.replace("\n", "\r\n").encode(),
    "old macintosh": lambda text: text.replace("\n", "\r").encode(),
    "latin-1": latin,
}


def written(folder, name, data):
    path = folder / name
    path.write_bytes(data)
    return path


def mesh_of(folder, name, text):
    return read_mesh(written(folder, name, text.encode()), SIZE)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", MESHES)
def test_meshes_are_the_same_in_any_encoding(name, way, tmp_path):
    plain = mesh_of(tmp_path, name, MESHES[name])
    other = read_mesh(written(tmp_path, name, WAYS[way](MESHES[name])), SIZE)
    np.testing.assert_array_equal(other.warp.vertices, plain.warp.vertices)
    np.testing.assert_array_equal(other.warp.triangles, plain.warp.triangles)
    assert (other.view, other.notes) == (plain.view, plain.notes)


@pytest.mark.parametrize("way", ["utf-8", "utf-16-le", "utf-16-be", "windows"])
def test_configurations_are_the_same_in_any_encoding(way, tmp_path):
    for name, content in (("a.json", samples.sgct()), ("a.ndisplay", samples.ndisplay())):
        text = json.dumps(content, indent=1)
        theatre, path = load_theatre(str(written(tmp_path, name, text.encode())))
        assert load_theatre(str(written(tmp_path, name, WAYS[way](text)))) == (theatre, path)
    names = parse_frustum(samples.frustum(), "x")
    assert parse_frustum(WAYS[way](samples.frustum().decode()), "x") == names


def test_names_may_be_latin_1(tmp_path):
    content = samples.sgct()
    content["nodes"][0]["windows"][0]["name"] = "Süd"
    text = json.dumps(content, ensure_ascii=False)
    theatre, path = load_theatre(str(written(tmp_path, "a.json", text.encode("latin-1"))))
    assert len(usable_channels(theatre, path)[0]) == 1
    packed = io.BytesIO(samples.mpcdi())
    with zipfile.ZipFile(packed) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    files["mpcdi.xml"] = files["mpcdi.xml"].replace(b'"b"', '"Süd"'.encode("latin-1"))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    read = read_mpcdi(written(tmp_path, "a.mpcdi", packed.getvalue()))
    assert [region.buffer for region in read.regions] == ["Süd"]


def test_lines_of_an_obj_go_on_and_its_other_statements_are_passed_over(tmp_path):
    plain = mesh_of(tmp_path, "a.obj", OBJ)
    text = QUAD.replace("v 1 1 0", "v 1 \\\n1 0") + "cstype bezier\ndeg 3\nf 1/1 2/2 \\\n3/3 4/4\n"
    other = mesh_of(tmp_path, "a.obj", text)
    np.testing.assert_array_equal(other.warp.vertices, plain.warp.vertices)
    np.testing.assert_array_equal(other.warp.triangles, plain.warp.triangles)


def test_columns_of_a_table_are_read_by_their_names(tmp_path):
    plain = mesh_of(tmp_path, "a.csv", MESHES["a.csv"])
    rows = [line.split(";") for line in MESHES["a.csv"].splitlines()]
    turned = [";".join([x.upper(), y, column, row, u, v]) for x, y, u, v, column, row in rows]
    other = mesh_of(tmp_path, "a.csv", "\n".join(turned))
    np.testing.assert_array_equal(other.warp.vertices, plain.warp.vertices)


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("a.csv", "column;row", "column;line", "no column 'row', expected x y u v column row"),
        ("a.ol", "ORTHO_RIGHT 1", "ORTHO_RIGHT 0,9", "expected the numbers of ORTHO_RIGHT"),
        ("a.ol", "[ 0 1 8 ]", "[ 0 1 8 7 ]", "a face of 4 nodes, expected 3"),
        ("a.obj", "f 1/1", "ff 1/1", "line 9: 'ff' is not a keyword of OBJ files"),
        ("a.obj", "f 1/1", "\0 1/1", "not text, expected lines"),
    ],
)
def test_lines_that_would_damage_a_mesh_are_refused(name, old, new, words, tmp_path):
    assert old in MESHES[name]
    with pytest.raises(UserError, match=words):
        mesh_of(tmp_path, name, MESHES[name].replace(old, new, 1))


def test_keywords_that_are_not_known_are_noted(tmp_path):
    sky = mesh_of(tmp_path, "a.skyskan", "Lens Shift=left\n" + MESHES["a.skyskan"])
    assert [note.partition(": line ")[2] for note in sky.notes] == [
        "1: 'Lens Shift', which may change the view"
    ]
    scalable = MESHES["a.ol"].replace("MAPPING", "PERSPECTIVE_XOFFSET 3\nMAPPING")
    (note,) = mesh_of(tmp_path, "a.ol", scalable).notes
    assert "PERSPECTIVE_XOFFSET, which may change the view" in note
    tight = MESHES["a.ol"].replace("[ ", "[").replace(" ]", "]")
    assert len(mesh_of(tmp_path, "a.ol", tight).warp.triangles) == 48
