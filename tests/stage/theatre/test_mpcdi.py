"""MPCDI archives: three projectors on a cylinder, there and back, and all that may be wrong."""

import io
import struct
import tracemalloc
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from subsea.base.errors import UserError
from subsea.stage.theatre import mpcdi
from subsea.stage.theatre.measured_mesh import ViewAngles
from subsea.stage.theatre.mpcdi import MpcdiRegion, mask, read_mpcdi
from subsea.view.rig import sources_at

FRUSTUM = """<frustum><yaw>38</yaw><pitch>-10</pitch><roll>0</roll><rightAngle>25</rightAngle>
<leftAngle>-26</leftAngle><upAngle>20</upAngle><downAngle>-21</downAngle></frustum>"""


@pytest.fixture(scope="module")
def files(making):
    return making.parts(making.cylinder())


@pytest.fixture
def read(tmp_path, making):
    def read(files):
        path = tmp_path / "theatre.mpcdi"
        path.write_bytes(files if isinstance(files, bytes) else making.zipped(files))
        return read_mpcdi(path)

    return read


def test_what_was_measured_is_read(read, files, projectors):
    archive = read(files)
    assert archive.profile == "2d"
    assert archive.faults == ()
    assert [region.name for region in archive.regions] == ["left", "middle", "right"]
    for region, one in zip(archive.regions, projectors, strict=True):
        assert (region.buffer, region.size, region.frustum) == ("cylinder", one.size, None)
        np.testing.assert_allclose(region.place, one.place)
        np.testing.assert_allclose(region.alpha, np.repeat(one.alpha[..., None], 3, 2), atol=2e-3)
        np.testing.assert_allclose(region.beta, np.repeat(one.beta[..., None], 3, 2), atol=2e-3)
        assert region.gamma == 2.2


def test_each_pixel_shows_what_was_measured_there(read, files, projectors, making):
    for region, one in zip(read(files).regions, projectors, strict=True):
        places = np.stack(making.grid_of(one.size), axis=-1).reshape(-1, 2)[::7]
        found = sources_at(region.warp, places)
        away = np.linalg.norm((found - one.sources.reshape(-1, 2)[::7]) * one.size, axis=1)
        assert np.nanmax(away) < 0.25
        measured = ~np.isnan(one.sources[..., 0])
        lost = np.isnan(found[:, 0]) & measured.ravel()[::7]
        assert lost.mean() < 0.05  # along the rim of the screen


def light_at(region, places, gamma):
    """A projector's share of full light, and its black, at places (k, 2)."""
    factors = mask(region, gamma, region.size)
    height, width = factors.shape[:2]
    column = np.clip((places[:, 0] * width).astype(int), 0, width - 1)
    row = np.clip(((1 - places[:, 1]) * height).astype(int), 0, height - 1)
    found = factors[row, column]
    return found[:, 0] ** gamma + found[:, 3], found[:, 3]


@pytest.mark.parametrize("gamma", [1.8, 2.2])
def test_where_projectors_overlap_their_light_adds_up_to_one(read, projectors, making, gamma):
    files = making.parts(projectors, bits=16)
    for one in projectors:
        files[f"maps/{one.name}-beta.png"] = making.png(one.beta * 0)
    regions = read(files).regions
    shares = np.random.default_rng(8).uniform([0.1, 0.2], [0.9, 0.8], (150, 2))
    total, count = np.zeros(len(shares)), np.zeros(len(shares), int)
    for region in regions:
        x, y, width, height = region.place
        places = making.places_of(region.warp, (shares - [x, y]) / [width, height])
        lit = ~np.isnan(places[:, 0])
        total[lit] += light_at(region, places[lit], gamma)[0]
        count += lit
    assert (count > 1).sum() > 30
    deep = np.abs(total - 1)
    assert np.quantile(deep, 0.95) < 0.03  # maps of 160 pixels, read without interpolation
    assert deep.max() < 0.1


def test_the_black_of_projectors_is_as_bright_everywhere(read, projectors, making):
    """Each leaks a little light; where one alone shines, its beta map makes up for the other."""
    leak = 0.05**making.gamma
    shares = np.random.default_rng(9).uniform([0.1, 0.2], [0.9, 0.8], (150, 2))
    black = np.zeros(len(shares))
    for region in read(making.parts(projectors)).regions:
        x, y, width, height = region.place
        places = making.places_of(region.warp, (shares - [x, y]) / [width, height])
        lit = ~np.isnan(places[:, 0])
        black[lit] += light_at(region, places[lit], 2.2)[1] + leak
    assert (np.abs(black / (2 * leak) - 1) < 0.05).mean() > 0.95


@pytest.mark.parametrize("beta", [0.0, 0.2])
def test_a_mask_is_the_standards_formula_for_all_light(beta):
    alpha = np.linspace(0, 1, 12, dtype=np.float32).reshape(3, 4, 1).repeat(3, axis=2)
    region = MpcdiRegion(
        "a", "b", (4, 3), (0, 0, 1, 1), None, None, alpha, np.full((6, 8, 3), beta, "f4"), 2.2
    )
    found = mask(region, 1.8, (999, 999))
    assert (found.shape, found.dtype) == ((6, 8, 4), np.float32)
    a, b = Image.fromarray(alpha[..., 0]).resize((8, 6), Image.Resampling.BILINEAR), beta**2.2
    for initial in (0.0, 0.1, 0.3, 0.6, 1.0):
        final = initial * np.asarray(a) ** 2.2 * (1 - b) + b
        shown = (found[..., 1] * initial ** (1 / 1.8)) ** 1.8 + found[..., 3]
        np.testing.assert_allclose(shown, final, atol=1e-6)


def test_a_region_without_maps_is_shown_as_it_is(read, projectors, making):
    files = making.parts(projectors)
    files["mpcdi.xml"] = files["mpcdi.xml"].split(b"<files>")[0] + b"</MPCDI>"
    archive = read(files)
    assert archive.faults == ()
    for region in archive.regions:
        assert (region.warp, region.alpha, region.beta) == (None, None, None)
        np.testing.assert_array_equal(mask(region, 2.2, region.size), [[[1, 1, 1, 0]]])


def test_maps_of_16_bits_and_of_colours_are_read(read, files, making):
    grey = np.linspace(0, 1, 160 * 120).reshape(120, 160)
    tint = np.stack([grey, grey**2, 1 - grey], axis=2)
    more = {"maps/left-alpha.png": making.png(grey, 16), "maps/right-alpha.png": making.png(tint)}
    left, _, right = read(files | more).regions
    np.testing.assert_allclose(left.alpha[..., 2], grey, atol=1e-5)
    np.testing.assert_allclose(right.alpha, tint, atol=0.003)


def test_capitals_and_slashes_may_differ(read, files):
    xml = files["mpcdi.xml"].replace(b"Xresolution", b"xResolution").replace(b"xsize", b"xSize")
    xml = xml.replace(b"<path>maps/", b"<path> .\\MAPS\\")
    named = {name.replace("mpcdi", "MPACS"): data for name, data in files.items()}
    assert read(named | {"MPACS.xml": xml}).faults == ()


def test_the_3d_profile_has_frusta(read, projectors, making):
    for one in projectors:
        one.frustum = FRUSTUM
    regions = read(making.parts(projectors, "3d")).regions
    assert regions[0].frustum == ViewAngles(38, -10, 0, -26, 25, -21, 20)


# A fault of one region: the others go on.


@pytest.mark.parametrize(
    ("change", "said", "left"),
    [
        ({"left.pfm": None}, "region 'left': 'left.pfm' is not in the archive", 2),
        ({"left.pfm": b"PF\n9 9\n-1.0\n"}, "'left.pfm': 9×9 points in 0 bytes of numbers", 2),
        ({"left.pfm": b"Pf\n2 2\n-1.0\n" + bytes(16)}, "one number a point", 2),
        ({"left.pfm": b"PF\n2 2\n-1.0\n" + bytes(48)}, "'left.pfm': an empty mesh", 2),
        (b'<region id="left" Xresolution="160"', "'xResolution' is missing", 2),
        (b'Xresolution="160"', "xResolution 'many', expected a number", 2),
        (b'Xresolution="160" ', "0×120 pixels, expected 1 to 16384", 2),
        (b'<region id="left"', "files for region 'left', which is not there", 3),
        ({"maps/left-alpha.png": None}, "is not in the archive; shown without it", 3),
        ({"maps/left-alpha.png": b"GIF89a"}, "not a readable PNG picture; shown without it", 3),
        (
            {"maps/left-beta.png": b"\x89PNG\r\n\x1a\n" + bytes(30)},
            "not a readable PNG picture; shown",
            3,
        ),
        (b"<gammaEmbedded>2.2", "gammaEmbedded 99 of its alpha map, expected 0.1 to 10", 3),
        (b"</region>", "region 'left': its 'coordinateframe' is not used", 3),
        (b"</buffer>", "'coordinateframe' of a buffer is not used", 3),
        (b"<betaMap>", "region 'left': its 'distortionmap' is not used", 3),
    ],
)
def test_one_wrong_projector_leaves_the_others(read, files, change, said, left):
    made = dict(files)
    if isinstance(change, dict):
        made |= change
    else:
        new = {
            b'<region id="left" Xresolution="160"': b'<region id="left"',
            b'Xresolution="160"': b'Xresolution="many"',
            b'Xresolution="160" ': b'Xresolution="0" ',
            b'<region id="left"': b'<region id="Left"',
            b"<gammaEmbedded>2.2": b"<gammaEmbedded>99",
            b"</region>": b"<coordinateFrame><posx>1</posx></coordinateFrame></region>",
            b"</buffer>": b"<coordinateFrame/></buffer>",
            b"<betaMap>": b"<distortionMap><path>a</path></distortionMap><betaMap>",
        }[change]
        made["mpcdi.xml"] = made["mpcdi.xml"].replace(change, new, 1)
    archive = read({name: data for name, data in made.items() if data is not None})
    assert len(archive.regions) == left
    [fault] = archive.faults
    assert said in fault and "\n" not in fault


def test_a_region_that_is_there_twice_is_taken_once(read, files):
    xml = files["mpcdi.xml"].replace(b'id="middle"', b'id="left"')
    archive = read(files | {"mpcdi.xml": xml})
    assert [region.name for region in archive.regions] == ["left", "right"]
    assert "region 'left': is there twice" in archive.faults[0]


def test_with_no_usable_projector_the_archive_is_refused_with_the_first_fault(read, files):
    with pytest.raises(UserError, match=r"region 'left': 'left.pfm' is not in.*and 2 more faults"):
        read({"mpcdi.xml": files["mpcdi.xml"]})


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (b'"2d"', b'"a3"', "profile 'a3' \\(advanced 3-D\\) has points in space, expected '2d'"),
        (b'"2d"', b'"sl"', "profile 'sl' \\(shader lamps\\) has points in space"),
        (b'"2d"', b'"4d"', "profile '4d', expected '2d' or '3d'"),
        (b'"2d"', b'"3d"', "no 'frustum', which profile '3d' needs"),
        (b"</MPCDI>", b"</MPCDJ>", "mpcdi.xml: not readable XML \\(mismatched tag"),
        (b"utf-8", b"klingon", "not readable XML \\(unknown encoding"),
        (b"MPCDI", b"Theatre", "root 'theatre' of the XML, expected 'MPCDI'"),
        (b"buffer", b"heap", "0 regions in its buffers, expected 1 to 256"),
        (b'xsize="', b'xsize="7', "of the buffer, expected shares of it"),
        (b'xsize="', b'xsize="nan', "xsize 'nan.*expected a number"),
    ],
)
def test_a_mislabelled_archive_is_one_line(read, files, old, new, said):
    with pytest.raises(UserError, match=said) as caught:
        read(files | {"mpcdi.xml": files["mpcdi.xml"].replace(old, new)})
    assert "theatre.mpcdi: " in str(caught.value)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "not a readable zip archive"),
        (b"<MPCDI/>", "not a readable zip archive"),
        (b"PK\x05\x06" + bytes(18), "no 'mpcdi.xml' in it"),
    ],
)
def test_a_file_that_is_not_an_archive_is_one_line(read, data, said):
    with pytest.raises(UserError, match=said):
        read(data)


def test_files_of_any_name_are_never_written(tmp_path, read, files, making):
    before = set(tmp_path.parent.rglob("*"))
    xml = files["mpcdi.xml"].replace(b"<path>left.pfm", b"<path>../../left.pfm")
    named = {name: data for name, data in files.items() if name != "left.pfm"}
    archive = read(named | {"mpcdi.xml": xml, "../../left.pfm": files["left.pfm"]})
    assert len(archive.regions) == 3
    assert {path.name for path in set(tmp_path.parent.rglob("*")) - before} <= {"theatre.mpcdi"}


def test_zip_and_picture_bombs_are_refused(read, files):
    zeros, huge = bytes(2**23), io.BytesIO()
    with pytest.raises(UserError, match=r"'mpcdi.xml': larger than 4 MiB"):
        read(files | {"mpcdi.xml": zeros})
    Image.new("1", (9000, 9000)).save(huge, "PNG")
    tracemalloc.start()
    archive = read(files | {"maps/left-alpha.png": huge.getvalue()})
    assert tracemalloc.get_traced_memory()[1] < 60e6
    tracemalloc.stop()
    assert "9000×9000 pixels, expected 16777216 at most; shown without it" in archive.faults[0]


def test_the_pixels_of_all_maps_are_limited(read, files, monkeypatch):
    two = 2 * 2 * 160 * 120
    for most, left in ((two, 3), (two - 1, 2)):
        monkeypatch.setattr(mpcdi, "MAX_PIXELS", most)
        archive = read(files)
        assert len(archive.regions) == left
    assert (
        f"region 'right': maps of those before it have more than {two - 1} p" in archive.faults[0]
    )


def test_a_mask_is_no_finer_than_the_window(read, files):
    region = read(files).regions[0]
    assert mask(region, 2.2, (999, 999)).shape == (120, 160, 4)
    small = mask(region, 2.2, (40, 999))
    assert small.shape == (120, 40, 4)
    wide = mask(region, 2.2, (999, 999)).reshape(120, 40, 4, 4).mean(axis=2)
    assert np.abs(small - wide).mean() < 0.02


@pytest.mark.parametrize(
    ("offset", "form", "value", "said"),
    [
        (8, "<H", 1, "cannot be unpacked"),
        (10, "<H", 99, "cannot be unpacked"),
        (16, "<I", 7, "cannot be unpacked (Bad CRC-32"),
        (24, "<I", 7, "cannot be unpacked"),
    ],
)
def test_a_false_zip_record_is_a_fault_of_its_file(read, files, making, offset, form, value, said):
    data = bytearray(making.zipped(files))
    record = data.rfind(b"left.pfm") - 46
    assert data[record : record + 4] == b"PK\x01\x02"
    struct.pack_into(form, data, record + offset, value)
    archive = read(bytes(data))
    assert len(archive.regions) == 2
    assert said in archive.faults[0]


@pytest.fixture(scope="module")
def small(making):
    """The files of an archive by name, and under no name the archive itself."""
    files = making.parts(making.cylinder((32, 24)))
    return {"": making.zipped(files), **files}


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from(["", "mpcdi.xml", "left.pfm", "maps/left-alpha.png"]),
    st.sampled_from(["cut", "flip", "junk"]),
    st.integers(0, 99_999),
    st.binary(min_size=1, max_size=20),
)
def test_mangled_archives_are_read_or_refused(read, small, name, kind, at, junk):
    whole, files = small[name], {other: data for other, data in small.items() if other}
    at %= len(whole)
    if kind == "cut":
        data = whole[:at]
    elif kind == "flip":
        data = whole[:at] + bytes([whole[at] ^ junk[0]]) + whole[at + 1 :]
    else:
        data = whole[:at] + junk + whole[at + 20 :]
    with suppress(UserError):
        archive = read(files | {name: data} if name else data)
        assert archive.regions and not any("\n" in line for line in archive.faults)
        for region in archive.regions:
            assert np.isfinite(mask(region, 2.2, region.size)).all()


def test_an_archive_that_is_not_there_is_one_line(tmp_path):
    for path in (tmp_path / "none.mpcdi", tmp_path):
        with pytest.raises(UserError, match=r"cannot read|no such file"):
            read_mpcdi(path)
