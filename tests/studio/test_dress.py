"""`subsea skin PHOTO --auto`, from the command line."""

import json
import re
import shutil
import sys

import numpy as np
import pytest
from PIL import Image

from subsea.cli.main import main
from subsea.fish import sheet_layout
from subsea.fish.species import load_species, own_species, species_file
from subsea.studio import dress
from subsea.studio.deformable_mesh import copy_meshes
from subsea.studio.fitting import silhouette
from subsea.studio.photograph import read_photograph
from subsea.studio.side_view import centred_matrix, make_fish_meshes

NAME = "my_wrasse"


@pytest.fixture
def own():
    path = own_species() / f"{NAME}.toml"
    path.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(species_file("moon_wrasse"), path)
    yield path
    path.unlink()
    path.with_suffix(".png").unlink(missing_ok=True)


@pytest.fixture(scope="module")
def photo(tmp_path_factory):
    """An orange fish that is cut out: quickly found."""
    plan = load_species("moon_wrasse").surface
    mask = silhouette(plan, centred_matrix(300, 200, plan), (200, 300))
    pixels = np.full((200, 300, 4), (230, 120, 30, 255), np.uint8)
    pixels[~mask] = (0, 0, 255, 0)
    path = tmp_path_factory.mktemp("photo") / "wrasse.png"
    Image.fromarray(pixels).save(path)
    return path


def run(capsys, *arguments):
    code = main(["skin", *map(str, arguments)])
    said = capsys.readouterr()
    assert "Traceback" not in said.err
    return code, said.out, said.err


def test_a_species_of_ones_own_is_dressed(capsys, own, photo):
    before = own.read_text()
    code, out, err = run(capsys, photo, "--species", NAME, "--auto")
    assert (code, err) == (0, "")
    assert str(own.with_suffix(".png")) in out and "skin.sheet" in out and "outline: 0." in out
    assert "heading: left" in out and f"fish.0.species={NAME}" in out
    assert own.read_text().replace(f'sheet = "{NAME}.png"\n', "") == before
    with Image.open(own.with_suffix(".png")) as image:
        sheet = np.asarray(image)
    assert sheet.shape == (*sheet_layout.SIZE[::-1], 4)
    body = sheet[round(0.2 * 640) :]
    assert np.abs(body[..., :3].astype(int) - (230, 120, 30)).max() < 6  # nowhere is it blue


def test_a_sheet_alone_and_meshes_that_are_used_again(capsys, own, photo, climb, tmp_path):
    before = own.read_text()
    sheet, mesh = tmp_path / "sheet.png", tmp_path / "mesh.json"
    command = photo, "--species", NAME, "--auto", "--out", sheet, "--mesh", mesh
    code, out, _ = run(capsys, *command)
    assert code == 0 and sheet.exists() and str(mesh) in out and "that is much" not in out
    assert own.read_text() == before and not own.with_suffix(".png").exists()
    photograph, species = read_photograph(photo), load_species(NAME)
    meshes = dress.load_mesh(mesh, photograph, species)
    other = tmp_path / "other.json"
    dress.save_mesh(other, photograph, meshes)
    both = [json.loads(path.read_text())["meshes"] for path in (mesh, other)]
    for name in both[0]:
        np.testing.assert_allclose(both[1][name]["nodes"], both[0][name]["nodes"], atol=3e-6)
    # The command says that a body reaches into a fin, though the silhouette fits.
    climb(meshes, "dorsal", 0.6)
    dress.save_mesh(mesh, photograph, meshes)
    code, out, _ = run(capsys, *command)
    assert code == 0 and "outline: 0." in out and "that is much" in out
    [off] = re.findall(r"dorsal fin: root (.+)% of the length", out)
    assert 100.0 * dress.GOOD < float(off) < 10.0
    # Meshes that are there are used as they are: this one is half a picture off.
    for one in meshes.parts.values():
        one.nodes[:] += (0.0, 60.0)
    meshes.body.anchors[0, 3] = 20.0, 30.0
    dress.save_mesh(mesh, photograph, meshes)
    again = dress.load_mesh(mesh, photograph, species)
    np.testing.assert_allclose(again.body.anchors[0, 3], (20.0, 30.0), atol=1e-3)
    told, first = mesh.read_bytes(), sheet.read_bytes()
    code, out, _ = run(capsys, *command)
    assert code == 0 and mesh.read_bytes() == told and sheet.read_bytes() != first
    assert "that is much" in out


def test_faults_are_one_line_and_change_nothing(capsys, own, photo, tmp_path, monkeypatch):
    def fails(*arguments):
        code, out, err = run(capsys, *arguments)
        assert code == 2 and out == "" and err.count("\n") == 1, err
        return err

    before = own.read_text()
    assert "unknown species" in fails(photo, "--species", "nobody", "--auto")
    assert "no.png" in fails(tmp_path / "no.png", "--species", NAME, "--auto")
    assert ".png" in fails(photo, "--species", NAME, "--auto", "--out", tmp_path / "sheet.jpg")
    assert "from above" in fails(
        photo, "--species", "spotted_eagle_ray", "--auto", "--out", tmp_path / "ray.png"
    )
    mesh = tmp_path / "mesh.json"
    far = json.dumps({"meshes": {"body": {"nodes": [[[1e300, 0]] * 21] * 9, "anchors": []}}})
    photograph, species = read_photograph(photo), load_species(NAME)
    fresh = make_fish_meshes(species.surface, centred_matrix(300, 200, species.surface))

    def changed(act):
        meshes = copy_meshes(fresh)
        for one in meshes.parts.values():
            act(one.nodes)
        dress.save_mesh(mesh, photograph, meshes)
        return mesh.read_text()

    point = changed(lambda nodes: nodes.fill(100.0))
    beside = changed(lambda nodes: nodes.__iadd__((900.0, 0.0)))
    large = far.replace("1e+300", "9" * 400)
    deep = "[" * 100_000
    for text in ("", "[]", "{}", '{"meshes": {"body": 3}}', far, large, deep, point, beside):
        mesh.write_text(text)
        assert "mesh.json" in fails(photo, "--species", NAME, "--auto", "--mesh", mesh)
    dress.save_mesh(mesh, photograph, fresh)
    told = fails(photo, "--species", NAME, "--auto", "--flip", "--mesh", mesh)
    assert "mesh.json" in told and "--flip" in told
    monkeypatch.setattr(dress, "ROOT", tmp_path)  # as if it were installed
    told = fails(photo, "--species", "clownfish", "--auto")
    assert "--out" in told
    assert own.read_text() == before and not own.with_suffix(".png").exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mesh.json"]


def test_neither_the_photograph_nor_a_foreign_picture_is_replaced(capsys, own, photo, tmp_path):
    def stays(picture, words, *arguments):
        before = picture.read_bytes(), own.read_text()
        code, out, err = run(capsys, *arguments, "--species", NAME, "--auto")
        assert (code, out) == (2, "") and str(picture) in err and words in err, err
        assert (picture.read_bytes(), own.read_text()) == before

    beside = own.with_suffix(".png")  # the natural name for a photograph, too
    shutil.copy(photo, beside)
    stays(beside, "photograph", beside)
    stays(beside, "photograph", beside, "--out", beside)
    stays(beside, f"not the sheet of {own.name}", photo)
    beside.unlink()
    link = tmp_path / "link.png"
    link.symlink_to(photo)
    stays(link, "photograph", photo, "--out", link)


def test_what_is_not_installed_is_named(capsys, photo, monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    code, out, err = run(capsys, photo, "--species", "clownfish", "--auto")
    assert (code, out, err) == (2, "", "subsea: skin needs OpenCV: run `make bench`\n")


def test_an_interrupted_one_leaves_nothing(capsys, own, photo, tmp_path, monkeypatch):
    def interrupted(*unused):
        raise KeyboardInterrupt

    before = own.read_text()
    monkeypatch.setattr(dress, "lift_sheet", interrupted)
    code, _, err = run(capsys, photo, "--species", NAME, "--auto", "--mesh", tmp_path / "m.json")
    assert code == 130 and err.startswith("subsea: interrupted")
    assert own.read_text() == before and not own.with_suffix(".png").exists()
    assert not list(tmp_path.iterdir())
