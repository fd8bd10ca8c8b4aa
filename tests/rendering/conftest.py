"""A small sea in closed form, a context without a window, and stored pictures."""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from PIL import Image

from subsea.fish.skinning import couple, place
from subsea.fish.species import load_species
from subsea.fish.surface import rest_control_points
from subsea.frame.packet import INSTANCE_COLUMNS, Batch, Packet, RenderScene
from subsea.geometry.rotation import from_matrix
from subsea.rendering.gl.context import headless_context
from subsea.rendering.output.quality import PRESETS, on_software
from subsea.rendering.renderer import Renderer
from subsea.scenario.schema import Water
from subsea.state import FINS_AT_EASE
from subsea.view.display_rigs import display_rig, views_for
from subsea.view.levels import SPECK
from subsea.view.rig import pose_from_angles, views

PICTURES = Path(__file__).parent / "pictures"
SIZE = (320, 180)
# Edges of triangles may fall on the other side of a pixel's centre on another processor, so one
# pixel in two hundred may differ freely; all others by one grey level at most.
TOLERANCE_LEVELS = 1
TOLERANCE_SHARE = 0.005
# GPUs sample edges and fine textures at other points than the software rasteriser.
GPU_SHARE, GPU_MEAN_LEVELS = 0.2, 0.75

SPECIES = ("fusilier", "emperor_angelfish")
LENGTH = 20.0
HALF_WIDTH = 900.0


class Fish(NamedTuple):
    """Fields of an instance record, with defaults that suit most tests."""

    species: int
    position: tuple[float, float, float]
    heading: float = np.pi
    level: int = 0
    weight: float = 0.3
    identity: float = 0.4
    pectoral: tuple[float, float] = (0.5, 0.7)
    scale: float = 1.0
    fade: float = 0.0
    display: float = 0.0
    number: int | None = None  # its index in the packet, in the order of its levels


@pytest.fixture(scope="session")
def lasting_context():
    """One context for all modules: the first renderer of each context takes half a second."""
    context = headless_context()
    with context:
        pass  # leaves the thread: no window could open otherwise
    yield context
    context.release()


@pytest.fixture(scope="module")
def context(lasting_context):
    """The context, current for one module: other tests make contexts too."""
    with lasting_context:
        yield lasting_context


@pytest.fixture(scope="module")
def own_context():
    """A context of one module, which counts its objects or makes others beside it."""
    context = headless_context()
    with context:
        yield context
    context.release()


@pytest.fixture(autouse=True)
def as_if_first(request):
    """Check and clear the OpenGL error, which a freed framebuffer in use causes.

    So no test finds an error that another one left.
    """
    if "context" in request.fixturenames:
        context = request.getfixturevalue("context")
        context.detect_framebuffer(0).use()
        assert context.error is not None  # reading the error clears it


@pytest.fixture(scope="session")
def directions_on():
    """(rig, observer) -> a canvas whose pixels have the colours of their directions."""

    def canvas_of(rig, observer):
        """(h, w, 3): directions in the observer's axes, as 0 to 1."""
        canvas = np.zeros((rig.canvas[1], rig.canvas[0], 3))
        axes = np.stack([np.cross(observer.forward, observer.up), observer.up, observer.forward])
        for view in views(rig, observer):
            x, y, w, h = view.viewport
            row, column = np.mgrid[:h, :w]
            ndc = np.stack([2 * (column + 0.5) / w - 1, 2 * (row + 0.5) / h - 1], axis=-1)
            far = np.concatenate([ndc, np.ones((h, w, 2))], axis=-1)
            matrix = view.projection.astype(float) @ view.view.astype(float)
            place = far @ np.linalg.inv(matrix).T
            d = (place[..., :3] / place[..., 3:] - view.eye) @ axes.T
            canvas[y : y + h, x : x + w] = 0.5 + 0.5 * d / np.linalg.norm(d, axis=-1, keepdims=True)
        return canvas

    return canvas_of


@pytest.fixture(scope="session")
def scene(known_repertoire):
    """Two species, two bent poses each; dunes of one sine."""
    nodes = known_repertoire.rest_nodes
    rows = []
    for name in SPECIES:
        rest = rest_control_points(load_species(name).surface, LENGTH, nodes[0, 0])
        coupling = couple("sections", nodes, rest)
        back = (nodes[0, 0] - nodes[:, 0]) / LENGTH
        for phase in (0.5, 2.0):
            bent = nodes.copy()
            bent[:, 2] += 1.2 * back**2 * np.sin(phase - 5.0 * back)
            rows.append(place(coupling, bent))
    axis = np.linspace(-HALF_WIDTH, HALF_WIDTH, 61)
    x, y = np.meshgrid(axis, axis)
    return RenderScene(
        species=tuple(load_species(name) for name in SPECIES),
        control_points=np.array(rows, np.float32),
        recorded_length_cm=(LENGTH, LENGTH),
        terrain=(-300.0 + 25.0 * np.sin(x / 90.0 + y / 140.0)).astype(np.float32),
        terrain_half_width_cm=HALF_WIDTH,
        water=Water(fog=(0.012, 0.115, 0.20), visibility_cm=900.0),
    )


@pytest.fixture(scope="module")
def make_renderer(context, scene):
    """(size, values other than the default ones) -> a renderer, one for equal values."""
    made = {}

    def make(size=SIZE, *, display="mono", quality=PRESETS["medium"], scene=scene):
        key = size, display, quality, id(scene)
        if key not in made:
            made[key] = Renderer(context, scene, display_rig(display, size), quality), scene
        return made[key][0]

    yield make
    for renderer, _ in made.values():
        renderer.release()


@pytest.fixture(scope="module")
def counted(make_renderer):
    """(packet, options of `make_renderer`) -> picture (h, w, 3), whole numbers; triangles."""

    def counted(packet, size=None, **options):
        whole = SIZE if "display" in options else packet.views[0].viewport[2:]
        renderer = make_renderer(size or whole, **options)
        renderer.draw(packet)
        return renderer.read_pixels().astype(int), renderer.triangles

    return counted


@pytest.fixture(scope="module")
def drawn(counted):
    """As `counted`, without the number of triangles."""
    return lambda packet, size=None, **options: counted(packet, size, **options)[0]


@pytest.fixture(scope="session")
def make_packet():
    """(fishes, position and direction of the eye, or views) -> a packet."""

    def make(fishes, eye=(0.0, 0.0, -200.0), heading=np.pi / 2, pitch=0.0, **options):
        size = options.pop("size", SIZE)
        display = options.pop("display", "mono")
        fishes = sorted(fishes, key=_group)
        groups = [_group(fish) for fish in fishes]
        batches = [
            Batch(-group[1], groups.index(group), groups.count(group), group[0])
            for group in sorted({*groups})
        ]
        records = np.array(
            [
                record(fish._replace(number=k) if fish.number is None else fish)
                for k, fish in enumerate(fishes)
            ],
            np.float32,
        )
        views = options.pop("views", None)
        if views is None:
            views = views_for(display, size, pose_from_angles(np.array(eye), heading, pitch))
        return Packet(
            time_s=options.pop("time_s", 2.0),
            views=views,
            instances=records.reshape(-1, INSTANCE_COLUMNS),
            batches=(tuple(batches),) * len(views),
            plankton=options.pop("plankton", np.zeros((0, 3), np.float32)),
            hidden=0,
        )

    return make


def _group(fish):
    """True if the batch is of fading fishes, and its level, coarsest first."""
    return fish.fade != 0.0 and fish.level < SPECK, -fish.level


def record(fish):
    """The instance record (27,) of an upright fish; its species has rows 2s and 2s + 1."""
    c, s = np.cos(fish.heading), np.sin(fish.heading)
    axes = np.array([[c, 0.0, s], [s, 0.0, -c], [0.0, 1.0, 0.0]])
    rows = (2 * fish.species, 2 * fish.species + 1)
    turn = from_matrix(axes[None])[0]
    return np.array(
        [
            *fish.position, fish.scale, *turn, *rows, fish.weight, fish.identity,
            *fish.pectoral, *FINS_AT_EASE[2:], fish.species, fish.fade, fish.display, fish.number,
        ]
    )  # fmt: skip


@pytest.fixture(scope="session")
def fish():
    return Fish


@pytest.fixture
def same_picture(request, context, tmp_path):
    """Compare a picture (h, w, 3) with the stored one of that name; `--regenerate` stores it.

    On failure the picture, and ten times the difference, are left in the test's folder.
    """

    def check(name, picture):
        path, picture = PICTURES / f"{name}.png", np.asarray(picture, np.uint8)
        if request.config.getoption("--regenerate"):
            path.parent.mkdir(exist_ok=True)
            Image.fromarray(picture).save(path)
        stored = np.asarray(Image.open(path).convert("RGB")).astype(int)
        assert stored.shape == picture.shape
        difference = np.abs(stored - picture).max(axis=2)
        share = (difference > TOLERANCE_LEVELS).mean()
        mean = np.abs(stored - picture).mean()
        software = on_software(context.info["GL_RENDERER"])
        if listed := request.config.getoption("--differences"):
            found = json.loads(listed.read_text()) if listed.is_file() else {}
            found[name] = {
                "share": float(share),
                "most": int(difference.max()),
                "mean": float(mean),
            }
            listed.write_text(json.dumps(found))
        most = TOLERANCE_SHARE if software else GPU_SHARE
        if share > most or (not software and mean > GPU_MEAN_LEVELS):
            Image.fromarray(picture).save(tmp_path / f"{name}.png")
            Image.fromarray((10 * difference).clip(0, 255).astype(np.uint8)).save(
                tmp_path / f"{name}-difference.png"
            )
            pytest.fail(f"{share:.2%} of {name} differ; see {tmp_path}")

    return check
