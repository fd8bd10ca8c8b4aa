"""The page of a scene, in a real browser, beside the picture of the dive at the same moment."""

import base64
import functools
import hashlib
import http.server
import json
import re
import shutil
import threading
from dataclasses import replace
from html import unescape
from io import BytesIO
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import binary_erosion

from subsea.base.errors import UserError
from subsea.dive.directed_camera import tour_steering
from subsea.dive.start import headless, picture_maker, start_world
from subsea.export import web
from subsea.export.options import SceneOptions
from subsea.export.recording import SceneFilmOptions, make_scene
from subsea.export.scene import SceneExtent
from subsea.export.statics import static_meshes
from subsea.export.take import record_frames
from subsea.export.web import WORDS
from subsea.frame.packet import PackOptions, pack
from subsea.media.film import instants
from subsea.rendering.gl.id_buffer import FISH
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.load import load_scenario
from subsea.view.display_rigs import cockpit, display_rig
from subsea.view.rig import views
from tests.support.browser import browser
from tests.support.scenes import BARE

SIZE = 640, 360
FPS, FRAMES, START_S = 10, 6, 0.4
STEP = 20  # of the red of silhouettes, from fish to fish
# Each fish in a red of its own with green, all else black: at smoothed edges their ratio stays.
SILHOUETTES = (
    """(async () => {
  const THREE = await import("three");
  const flat = (map, grey) => {
    const material = new THREE.MeshBasicMaterial({ map, alphaTest: 0.5, side: THREE.DoubleSide });
    material.onBeforeCompile = shader => {
      shader.fragmentShader = shader.fragmentShader.replace("#include <opaque_fragment>",
        `gl_FragColor = vec4(${grey.toFixed(1)} / 255.0, ${grey > 0 ? "1.0" : "0.0"}, 0.0, 1.0);`)
        .replace("#include <colorspace_fragment>", "");
    };
    material.customProgramCacheKey = () => String(grey);
    return material;
  };
  viewer.fishes.all.forEach((fish, k) => {
    for (const mesh of fish.meshes) mesh.material = flat(mesh.material.map, STEP * (k + 1));
  });
  for (const mesh of viewer.fishes.others) mesh.material = flat(null, 0);
  viewer.scene.children.find(one => one.renderOrder < 0).visible = false;
  viewer.draw();
  return true;
})()"""
).replace("STEP", str(STEP))
PLACES = (
    "viewer.fishes.all.map(fish => { const p = viewer.fishes.place(fish).project(viewer.camera);"
)
PLACES += "return [(p.x + 1) / 2 * innerWidth, (1 - p.y) / 2 * innerHeight, p.z]; })"


class Written(NamedTuple):
    """A page and what the dive shows at the last moment of its scene."""

    folder: object
    scene: object
    number: np.ndarray  # (h, w) of the fish at a pixel, -1: none
    picture: Image.Image
    shafts: np.ndarray  # (16, 320) the map of light shafts about the sun


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    try:
        web.find_three()
    except UserError as fault:
        pytest.skip(str(fault))
    out = tmp_path_factory.mktemp("web") / "page"
    options = SceneFilmOptions(
        out=out, loaded=load_scenario(str(BARE)), start=START_S, size=SIZE, detail=1, groups=()
    )
    world = start_world(str(BARE))
    rig = display_rig("mono", SIZE)
    times = instants(START_S, FRAMES / FPS, FPS)
    takes, camera = record_frames(world, times, tour_steering(world, "auto"), None, FPS, SIZE)
    statics = static_meshes(world, ("sand", "stone"), 2, camera.position[0])
    scene = make_scene("bare", world, takes, camera, statics, options, FPS)
    scene = replace(scene, captions=("", *["Here they come"] * (FRAMES - 1)))
    web.WRITER.check(out, SceneOptions())
    web.WRITER.write(scene, out, SceneOptions())
    with headless() as context, picture_maker(context, world, rig, PRESETS["medium"]) as renderer:
        alpha = times[-1] / 0.033 % 1.0
        seen = views(rig, cockpit(world.state.submarine, alpha))
        packet = pack(world, seen, alpha, PackOptions(culling=False, lod=False))
        renderer.draw(packet)
        picture = Image.fromarray(renderer.read_pixels())
        maps = renderer.id_maps(packet)
        shafts = np.frombuffer(renderer._shafts._map.read(), np.float16).reshape(16, 320)
    numbers = np.where(maps.kind == FISH, maps.number, -1)
    return Written(out, scene, numbers, picture, shafts.astype(float))


@pytest.fixture(scope="module")
def site(written):
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *words):
            pass

    handler = functools.partial(Quiet, directory=written.folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.05,))
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}/index.html"
        server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def page():
    if not any(map(shutil.which, ("chromium", "chromium-browser"))):
        pytest.skip("chromium is missing: `apt install chromium`")
    with browser(webgl=True) as one:
        one.size(*SIZE)
        one.call("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-reduced-motion", "value": "reduce"}])  # fmt: skip
        yield one


@pytest.fixture
def opened(page, site):
    page.logged.clear()
    page.open(site)
    page.until("window.viewer !== undefined")
    yield page
    assert not page.logged, page.logged


def picture_of(page):
    data = page.call("Page.captureScreenshot", format="png", captureBeyondViewport=False)["data"]
    return np.asarray(Image.open(BytesIO(base64.b64decode(data))).convert("RGB"))


def hide_controls(page):
    page.run(
        "for (const one of document.querySelectorAll('header, nav, footer')) one.hidden = true"
    )


def test_fishes_and_water_are_where_the_dive_has_them(written, opened):
    opened.run(f"viewer.seek({(FRAMES - 1) / FPS})")
    hide_controls(opened)
    opened.run("viewer.draw(); document.getElementById('caption').hidden = true")
    shown, dive = picture_of(opened).astype(float), np.asarray(written.picture, float)
    water = written.number < 0
    assert water.mean() > 0.5
    # The page has no sand, stone and shafts of light: only the upper corners are water in both.
    for columns in (slice(0, 60), slice(-60, None)):
        corner = slice(0, 60), columns
        assert np.abs(shown[corner].mean((0, 1)) - dive[corner].mean((0, 1))).max() < 30
    opened.run(SILHOUETTES)
    red, green, _ = np.moveaxis(picture_of(opened).astype(float), 2, 0)
    nearest = np.where(green > 127, np.round(red / np.maximum(green, 1) * 255 / STEP) - 1, -1)
    compared = 0
    for k, fish in enumerate(written.scene.fishes):
        mine, theirs = nearest == k, written.number == fish.number
        if theirs.sum() < 150:
            continue
        compared += 1
        overlap = (mine & theirs).sum() / (mine | theirs).sum()
        middles = [np.argwhere(mask).mean(0) for mask in (mine, theirs)]
        print(fish.name, theirs.sum(), overlap, middles[0] - middles[1])
        # An outline that is off by a pixel matters more to a small fish.
        assert overlap > 1.0 - 3.5 / np.sqrt(theirs.sum()), fish.name
        assert np.abs(middles[0] - middles[1]).max() < 1.5, fish.name
        inside = binary_erosion(mine & theirs, iterations=2)
        colours = [picture[inside].mean(axis=0) for picture in (shown, dive)]
        print(fish.name, *colours)
        assert np.abs(colours[0] - colours[1]).max() < 14, fish.name
    assert compared >= 2


@pytest.mark.nightly
def test_a_click_a_tap_and_the_list_choose_a_fish(written, opened):
    opened.run(f"viewer.seek({(FRAMES - 1) / FPS}); viewer.draw()")
    counts = np.bincount(written.number[written.number >= 0])
    hide_controls(opened)
    number = int(counts.argmax())
    name = next(fish.name for fish in written.scene.fishes if fish.number == number)
    rows, columns = np.nonzero(written.number == number)
    middle = int(np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2))
    x, y = int(columns[middle]), int(rows[middle])
    for kind in ("mousePressed", "mouseReleased"):
        opened.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
    assert opened.until("viewer.chosen && viewer.chosen.about.node") == name
    title = opened.run("document.getElementById('chosen').textContent")
    assert re.match(r"(Yellowback fusilier|.*clownfish.*) \d · \w+ \w+ · [\d.]+ cm$", title), title
    opened.run("viewer.choose(null)")
    opened.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
    opened.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    assert opened.until("viewer.chosen && viewer.chosen.about.node") == name


def test_the_list_of_fishes_works_by_keyboard_and_is_read_aloud(written, opened):
    for _ in range(20):
        opened.press("Tab")
        if opened.run("document.activeElement.closest('#fish-list') !== null"):
            break
    opened.press("Enter", "\r")  # opens the list, then its first species
    opened.press("Tab")
    opened.press("Enter", "\r")
    opened.press("Tab")
    first = opened.run("document.activeElement.textContent")
    opened.press("Enter", "\r")
    opened.until("document.getElementById('chosen').textContent !== ''")
    assert opened.run("document.activeElement.ariaPressed") == "true"
    assert opened.run("document.getElementById('chosen').textContent").startswith(first)
    buttons = [one for one in opened.tree() if one["role"] == "button"]
    assert {"role", "name"} <= buttons[0].keys()
    assert first in {one["name"] for one in buttons} and WORDS["play"] in {
        one["name"] for one in buttons
    }
    assert any(one["role"] == "slider" and one["name"] == WORDS["time"] for one in opened.tree())
    opened.press("Escape")
    opened.until("document.getElementById('chosen').textContent === ''")


@pytest.mark.nightly
def test_it_plays_shows_captions_and_looks_from_other_places(opened):
    assert opened.run("document.getElementById('caption').textContent") == ""
    opened.run("document.getElementById('play').click()")
    opened.until("document.getElementById('caption').textContent === 'Here they come'")
    opened.run("document.getElementById('play').click()")
    opened.run("var time = document.getElementById('time'); time.value = 0.3;"
               "time.dispatchEvent(new Event('input'))")  # fmt: skip
    assert opened.run("document.getElementById('clock').textContent") == "0.3 / 0.5 s"
    eye = "viewer.camera.position.toArray()"
    filmed = opened.run(f"viewer.draw(), {eye}")
    for view, key in (("orbit", "ArrowLeft"), ("fly", "w")):
        opened.run(f"document.querySelector('input[value={view}]').click()")
        opened.run("document.getElementById('sea').focus()")
        code = {"ArrowLeft": "ArrowLeft", "w": "KeyW"}[key]
        before = opened.run(eye)
        opened.call("Input.dispatchKeyEvent", type="rawKeyDown", key=key, code=code)
        opened.until(f"viewer.camera.position.distanceTo({{x: {before[0]}, y: {before[1]}, "
                     f"z: {before[2]}}}) > 0.05")  # fmt: skip
        opened.call("Input.dispatchKeyEvent", type="keyUp", key=key, code=code)
    before = opened.run("viewer.camera.quaternion.toArray()")
    for kind, x in (("mousePressed", 300), ("mouseMoved", 360), ("mouseReleased", 360)):
        opened.call("Input.dispatchMouseEvent", type=kind, x=x, y=120, button="left", buttons=1)
    assert opened.run("viewer.camera.quaternion.toArray()") != before
    opened.run("document.querySelector('input[value=film]').click()")
    opened.until("!viewer.dirty")
    assert opened.run(eye) == pytest.approx(filmed)


@pytest.mark.nightly
def test_in_a_frame_it_has_no_bars(page, site):
    page.open(f"{site}?embed")
    page.until("window.viewer !== undefined")
    for one in ("header", "nav", "footer"):
        assert page.run(f"document.querySelector('{one}').offsetParent === null"), one
        assert page.run(f"document.querySelector('{one}').getBoundingClientRect().height") == 0
    assert page.run("document.getElementById('sea').clientHeight") == SIZE[1]


def test_a_scene_that_is_no_loop_fades_over_its_seam(opened):
    opened.run("viewer.length = 4; viewer.playing = true")
    shown = [float(opened.run(f"viewer.seconds = {at}, viewer.shown()")) for at in (0, 0.25, 2, 4)]
    assert shown == [0.0, 0.5, 1.0, 0.0]
    opened.run("viewer.playing = false")
    assert float(opened.run("viewer.seconds = 4, viewer.shown()")) == 1.0


def test_a_loop_goes_on_without_a_seam(opened):
    """Neither the picture fades, nor does the water's light jump."""
    opened.run("viewer.about.loop = true; viewer.playing = true")
    assert opened.run("viewer.seconds = 4, viewer.shown()") == 1
    opened.run("viewer.playing = false")
    length = (FRAMES - 1) / FPS
    opened.run(f"viewer.seek({length - 0.1}); viewer.before = 0; viewer.go(0.3); viewer.draw()")
    assert opened.run("viewer.seconds") == pytest.approx(0.2)
    assert opened.run("viewer.water.uniforms.u_time.value") == pytest.approx(START_S + length + 0.2)


@pytest.mark.nightly
def test_light_falls_in_the_shafts_of_the_dive(written, opened):
    """With as many samples, the map of light about the sun is the one of the dive's renderer."""
    samples = PRESETS["medium"].shafts
    opened.run(f"viewer.water.uniforms.u_samples.value = {samples}; 0")
    opened.run(f"viewer.seek({(FRAMES - 1) / FPS}); viewer.draw()")
    values = opened.run(
        """(async () => {
      const raw = new Uint16Array(4 * 320 * 16), THREE = await import("three");
      viewer.renderer.readRenderTargetPixels(viewer.water.map, 0, 0, 320, 16, raw);
      return [...raw].filter((_, k) => k % 4 === 0).map(one => THREE.DataUtils.fromHalfFloat(one));
    })()"""
    )
    shafts = np.array(values).reshape(16, 320)
    assert np.ptp(written.shafts) > 0.05
    # Browsers and drivers make their own mipmaps of the light that waves gather.
    assert np.abs(shafts - written.shafts).mean() < 0.05 * np.abs(written.shafts).mean()


BOXES = """JSON.stringify(["header", "nav", "#caption", "footer"].map(one => {
  const part = document.querySelector(one), box = part.getBoundingClientRect();
  return [box.left, box.top, box.right, box.bottom, part.scrollWidth - part.clientWidth];
}))"""


def test_nothing_covers_anything_else_in_a_small_window(opened):
    """On a phone, upright and on its side, and on a tablet, with all that can be unfolded."""
    opened.run("document.querySelectorAll('details').forEach(one => { one.open = true; })")
    opened.run(f"document.getElementById('caption').textContent = '{'Here they come. ' * 5}'")
    try:
        for width, height in ((390, 844), (844, 390), (1024, 768)):
            opened.size(width, height)
            opened.until(f"innerWidth === {width}")
            boxes = np.array(json.loads(opened.run(BOXES)))
            assert (boxes[:, :2] >= 0).all() and (boxes[:, 4] <= 0).all()
            assert (boxes[:, 2] <= width).all() and (boxes[:, 3] <= height).all()
            first, other = (np.array(pair) for pair in zip(*combinations(boxes, 2), strict=True))
            least = np.minimum(first[:, 2:4], other[:, 2:4])
            gaps = np.maximum(first[:, :2], other[:, :2]) - least
            assert (gaps.max(axis=1) >= 0).all()
            # A window narrower than the film shows more above and below.
            seen = opened.run("[viewer.camera.aspect, viewer.camera.fov, viewer.filmed.fov]")
            aspect, shown, filmed = seen[0], *np.tan(np.radians(seen[1:]) / 2)
            narrow = SIZE[0] / SIZE[1] / aspect
            assert shown / filmed == pytest.approx(np.sqrt(max(narrow, 1.0)), rel=1e-3)
    finally:
        opened.size(*SIZE)


def test_it_speaks_the_language_of_the_browser(page, site):
    agent = page.run("navigator.userAgent")
    try:
        page.call("Emulation.setUserAgentOverride", userAgent=agent, acceptLanguage="de-AT,en")
        page.open(site)
        page.until("window.viewer !== undefined")
        assert page.run("document.documentElement.lang") == "de"
        assert page.run("document.getElementById('play').textContent") == "Abspielen"
        assert page.run("viewer.fishes.all.map(one => one.title).join()").count("Füsilier") > 1
    finally:
        page.call("Emulation.setUserAgentOverride", userAgent=agent, acceptLanguage="en")


@pytest.mark.nightly
def test_it_says_what_is_wrong(page, site, written, tmp_path):
    text = "document.getElementById('message').textContent"
    hook = page.call("Page.addScriptToEvaluateOnNewDocument",
                     source="HTMLCanvasElement.prototype.getContext = () => null")  # fmt: skip
    page.open(site)
    page.until("document.getElementById('message').className === 'alarm'")
    assert page.run(text) == WORDS["webgl"]
    page.call("Page.removeScriptToEvaluateOnNewDocument", identifier=hook["identifier"])
    whole = written.folder / web.SCENE
    kept = whole.read_bytes()
    try:
        whole.write_bytes(kept[:1000])
        page.open(site)
        page.until("document.getElementById('message').className === 'alarm'")
        assert page.run(text).startswith(WORDS["failed"])
    finally:
        whole.write_bytes(kept)


def test_the_page_runs_only_its_own_files_and_works_offline(written):
    index = (written.folder / "index.html").read_text("utf-8")
    policy = unescape(re.search(r'Policy" content="([^"]*)"', index)[1])
    [inline] = re.findall(r"<script type=\"importmap\">(.*?)</script>", index)
    digest = base64.b64encode(hashlib.sha256(inline.encode()).digest()).decode()
    assert f"script-src 'self' 'sha256-{digest}'" in policy and "unsafe" not in policy
    assert policy.startswith("default-src 'none'")
    for path in written.folder.rglob("*"):
        if path.parent == written.folder and path.suffix in (".html", ".css", ".js"):
            assert "://" not in path.read_text("utf-8"), path
    for target in json.loads(inline)["imports"].values():
        assert (written.folder / target).exists()
    assert "MIT" in (written.folder / "three/LICENSE").read_text("utf-8")
    about = json.loads((written.folder / "scene.json").read_text("utf-8"))
    assert about["bytes"] == (written.folder / "scene.glb").stat().st_size
    assert "MIT licence" in about["licence"] and "MIT licence" in index
    assert {fish["node"] for fish in about["fishes"]} == {one.name for one in written.scene.fishes}


def test_options_of_other_formats_and_other_folders_are_refused(written, tmp_path):
    check = web.WRITER.check
    with pytest.raises(UserError, match="--morph is not for --to web"):
        check(tmp_path / "page", SceneOptions(morph=True))
    with pytest.raises(UserError, match="--compress meshopt is not for --to web"):
        check(tmp_path / "page", SceneOptions(compress="meshopt"))
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(UserError, match="holds other files; give --force"):
        check(tmp_path, SceneOptions())
    check(tmp_path, SceneOptions(force=True))
    check(written.folder, SceneOptions())
    with pytest.raises(UserError, match="is a file, expected a folder"):
        check(tmp_path / "thesis.txt", SceneOptions())
    extent = SceneExtent(frames=10, fps=15.0, fishes=4, species=1, vertices=600, triangles=1000)
    assert web.WRITER.estimate(extent, SceneOptions()) > web.PAGE_BYTES


def test_without_three_js_one_line_says_what_to_type(monkeypatch, tmp_path):
    monkeypatch.setattr("sys.prefix", str(tmp_path))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "own files"))
    with pytest.raises(UserError, match=r"needs three.js [\d.]+; type `npm install .*'.* three@"):
        web.find_three()
    folder = tmp_path / "own files/subsea/web/node_modules/three"
    folder.mkdir(parents=True)
    (folder / "package.json").write_text('{"version": "0.1.0"}')
    with pytest.raises(UserError, match="the page needs"):
        web.find_three()
    version = json.loads((web.resource_path("assets/web/package.json")).read_text())
    wanted = version["dependencies"]["three"]
    (folder / "package.json").write_text(json.dumps({"version": wanted}))
    assert web.find_three() == folder
