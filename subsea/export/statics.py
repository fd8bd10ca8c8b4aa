"""Make meshes of what does not move, as the renderer does: sand, stone, corals and seaweed.

The shaders' colours come without fine textures and without water. The shade of stones and growths
darkens them as in the renderer.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.base.disk_cache import cached
from subsea.export.clips import turned_to_normals
from subsea.export.plant_motion import BentLeaves
from subsea.export.scene import SceneMesh
from subsea.fish.raster import smoothstep
from subsea.frame.in_sight import leaf_texels
from subsea.frame.packet import RenderScene, make_scene
from subsea.habitat.reef import KINDS
from subsea.habitat.seaweed import KINDS as SEAWEED
from subsea.habitat.stone import sun_at
from subsea.habitat.terrain import variant_of
from subsea.rendering.gl.textures import tileable_noise
from subsea.rendering.reef import rocks as rock_mesh
from subsea.rendering.reef.coral import ALGAE, DULL, LOOKS, PlacedGrowths, contact, tints
from subsea.rendering.reef.coral_kinds import forms
from subsea.rendering.reef.coral_mesh import CoralMesh, unit
from subsea.rendering.reef.rocks import overgrown
from subsea.rendering.reef.seaweed import BentFronds, bent_fronds
from subsea.rendering.sea.ground_map import with_growths
from subsea.rendering.sea.seabed import standing, surface, surroundings
from subsea.world.world import TICK_S, World

USUAL_CM = 30.0  # radius of the growths whose sway `CoralLook` gives
ONCE = np.eye(4)[None]
WHITE = np.ones((1, 3))
SHADE = 0.45  # light that is left where the sky is hidden
# From `seabed.frag`.
PALE, TAN, FILM = np.array([[0.62, 0.475, 0.30], [0.33, 0.215, 0.11], [0.17, 0.135, 0.06]])
BROAD_CM, NOISE_SEED = 870.0, 2  # width of the slow noise, and its seed in the renderer
# From `solid.frag`.
DARK, OCHRE, CREAM = np.array([[0.23, 0.17, 0.13], [0.56, 0.40, 0.22], [0.70, 0.60, 0.45]])
TURF, CORALLINE, VIOLET = np.array([[0.20, 0.21, 0.05], [0.70, 0.30, 0.40], [0.42, 0.24, 0.44]])
LEAST_CM = 0.01  # extent of a frond: fronds of a missing canopy are points
# From `seaweed.frag`: darker roots and paler tips.
ROOT, TIP = np.array([0.75, 0.8, 0.8]), np.array([1.35, 1.15, 1.0])
SPONGE, LEMON = np.array([[0.86, 0.33, 0.06], [0.78, 0.62, 0.12]])


class StillMoment(NamedTuple):
    """When and from where the seaweed is shown: its stems are ribbons that face the eye."""

    time_s: float
    alpha: float  # share of the present tick
    eye: Array  # (3,) cm


def static_meshes(
    world: World, groups: Sequence[str], detail: int, moment: StillMoment
) -> list[SceneMesh]:
    """Make the meshes of some GROUPS at a level of detail, seaweed as at a moment."""
    scene = make_scene(world)
    makers: dict[str, Callable[[], Iterator[SceneMesh]]] = {
        "sand": lambda: _sand(scene),
        "stone": lambda: _stone(scene, detail),
        "corals": lambda: _corals(scene, detail),
        "seaweed": lambda: _seaweed(world, detail, moment),
    }
    return [mesh for name in groups for mesh in makers[name]()]


def _sand(scene: RenderScene) -> Iterator[SceneMesh]:
    """Make the seabed with its apron, which goes on into the haze."""
    places, slopes = surface(scene.terrain, scene.terrain_half_width_cm)
    rows, columns = places.shape[:2]
    points = places.reshape(-1, 3)
    normals = np.concatenate([-slopes.reshape(-1, 2), np.ones((len(points), 1))], axis=1)
    corner = np.arange(rows * columns).reshape(rows, columns)[:-1, :-1].ravel()
    east, north = corner + 1, corner + columns
    triangles = np.stack([corner, east, north, north, east, north + 1], axis=1).reshape(-1, 3)
    noise = tileable_noise(NOISE_SEED)
    broad = _sampled(noise, points[:, :2] / BROAD_CM * len(noise), wrap=True)
    ground = cached(
        surroundings, scene.terrain, scene.terrain_half_width_cm, scene.pillars, scene.rocks,
        scene.water.hour, scene.reef,
    )  # fmt: skip
    growths, _ = standing(scene.reef, scene.terrain, scene.terrain_half_width_cm)
    light = with_growths(ground, growths, sun_at(scene.water.hour)[0])[0] / 255.0
    texels = np.array([light.shape[1], light.shape[0]])
    at = (points[:, :2] - ground.corner) / ground.size * texels - 0.5
    sky, rubble = (_sampled(light[..., k], at, wrap=False) for k in (1, 2))
    colours = _mix(TAN, PALE, np.clip(0.60 + 0.13 * broad, 0.0, 1.0))
    film = 0.30 * smoothstep(-broad, 0.2, 1.6) + 0.9 * rubble
    colours = _mix(colours, FILM, np.clip(film, 0.0, 0.85))
    yield SceneMesh(
        "sand", "sand", "sand", points, unit(normals), colours * _shade(sky),
        triangles.astype(np.int32), False, ONCE, WHITE,
    )  # fmt: skip


def _stone(scene: RenderScene, detail: int) -> Iterator[SceneMesh]:
    """Make the pieces of all formations."""
    pieces = cached(
        overgrown, scene.terrain, scene.terrain_half_width_cm, scene.pillars, scene.rocks,
        scene.water.hour, scene.reef,
    )  # fmt: skip
    for number, levels in enumerate(pieces):
        mesh = levels[min(detail, len(levels) - 1)]
        vertices = mesh.vertices.astype(np.float64)
        yield SceneMesh(
            f"stone_{number:03}", "stone", "stone", vertices[:, :3], unit(vertices[:, 3:6]),
            _stone_colours(vertices), mesh.triangles.astype(np.int32), False, ONCE, WHITE,
        )  # fmt: skip


def _stone_colours(vertices: Array) -> Array:
    """Compute colours (n, 3) of stone, as `solid.frag` does where the relief is flat."""
    columns = rock_mesh.HOLLOW, rock_mesh.TURF, rock_mesh.CORALLINE, rock_mesh.SPONGE
    hollow, turf, algae, sponge = (vertices[:, k] for k in columns)
    up = vertices[:, 5]
    bare = _mix(OCHRE, CREAM, np.clip(0.5 + 1.2 * algae, 0.0, 1.0))
    stone = _mix(DARK, bare, np.clip(0.62 - 0.35 * hollow, 0.0, 1.0))
    crust = _mix(CORALLINE, VIOLET, smoothstep(turf + 0.4 * hollow - 0.3 * up, -0.1, 0.5))
    stone = _mix(stone, 0.8 * crust, 0.8 * smoothstep(algae - 0.15 * up + 0.04, -0.02, 0.25))
    stone = _mix(stone, TURF, 0.8 * smoothstep(0.75 * turf + 0.55 * up - 0.34, 0.0, 0.32))
    living = 0.55 * _mix(SPONGE, LEMON, smoothstep(turf, -0.1, 0.1))
    stone = _mix(stone, living, smoothstep(sponge - 0.12 * up, 0.40, 0.50))
    return np.asarray(0.85 * stone * _shade(vertices[:, rock_mesh.SKY]))


def _corals(scene: RenderScene, detail: int) -> Iterator[SceneMesh]:
    """Make a mesh of each kind, form and pair of colours of the growths, at its places."""
    reef = scene.reef
    if not len(reef.kind):
        return
    names = list(KINDS)
    variant = variant_of(reef.own)
    pairs = np.array([len(LOOKS[name].colours) for name in names])[reef.kind]
    pair = (reef.hue * pairs).astype(int)
    groups = np.unique(np.stack([reef.kind, variant, pair], axis=1), axis=0)
    wanted = np.unique(groups[:, :2], axis=0)
    shapes = forms([(names[kind], int(number)) for kind, number in wanted])
    levels = {tuple(key): shape for key, shape in zip(wanted.tolist(), shapes, strict=True)}
    for kind, form, number in groups.tolist():
        mine = (reef.kind == kind) & (variant == form) & (pair == number)
        growths, look = reef.taken(mine), LOOKS[names[kind]]
        placed = PlacedGrowths(names[kind], growths)
        mesh = levels[kind, form][min(detail + 1, len(levels[kind, form]) - 1)]
        places = np.tile(np.eye(4), (len(growths.kind), 1, 1))
        places[:, :3, :3] = np.swapaxes(placed.axes, 1, 2)
        places[:, :3, 3] = placed.place
        body, tips = (np.array(colour) for colour in look.colours[number])
        both = tints(look, growths.own.astype(np.float64), growths.hue.astype(np.float64))
        tint = np.mean([both[0] / body, both[1] / tips], axis=0)
        yield SceneMesh(
            f"{names[kind]}_{form}_{number}", names[kind], "corals", mesh.place.astype(np.float64),
            mesh.normal.astype(np.float64), _coral_colours(mesh, body, tips),
            mesh.triangles.astype(np.int32), True, places, tint * placed.light[:, None],
            sway=look.sway_cm / USUAL_CM * mesh.sway if look.sway_cm else None,
        )  # fmt: skip


def _coral_colours(mesh: CoralMesh, body: Array, tips: Array) -> Array:
    """Compute colours (n, 3) of a growth, as `PlacedGrowths.vertices` does, without patches."""
    colour = _mix(np.sqrt(body), np.sqrt(tips), mesh.tip)
    # Parts in the dark are dead and overgrown.
    dead = DULL * np.clip(1.3 - 2.2 * mesh.light - mesh.tip, 0.0, 1.0)
    colour = _mix(colour, np.sqrt(ALGAE), dead)
    light = np.minimum(mesh.light, 1.0) * contact(mesh.place[:, 2])
    return np.asarray(np.clip(colour, 0.0, 1.0) ** 2 * light[:, None])


def _seaweed(world: World, detail: int, moment: StillMoment) -> Iterator[SceneMesh]:
    """Make a mesh of each kind of seaweed."""
    number = len(world.state.seaweed.kind)
    leaves = leaf_texels(
        world.state.seaweed, np.arange(number), np.zeros(number, np.float32), moment.alpha
    )
    fronds = bent_fronds(leaves, detail > 1, moment.eye, moment.time_s)
    shown = np.ptp(fronds.places, axis=1).max(axis=1, initial=0.0) > LEAST_CM
    for kind, name in enumerate(SEAWEED):
        mine = shown & (fronds.kind == kind)
        if not mine.any():
            continue
        points, normals, colours = (
            part[mine].reshape(-1, 3).astype(np.float64)
            for part in (fronds.places, fronds.normals, fronds.colours)
        )
        colours *= ROOT + (TIP - ROOT) * fronds.along[mine].reshape(-1, 1)
        first = np.arange(mine.sum())[:, None, None] * fronds.places.shape[1]
        triangles = turned_to_normals((first + fronds.triangles).reshape(-1, 3), points, normals)
        yield SceneMesh(
            f"seaweed_{name}", f"seaweed_{name}", "seaweed", points, normals, colours, triangles,
            True, ONCE, WHITE, bent=_bent(fronds, mine),
        )  # fmt: skip


def _bent(fronds: BentFronds, mine: Bools) -> BentLeaves:
    """Find the leaves that the vertices of some fronds follow, and where on these they grow."""
    places = fronds.chain[mine]
    return BentLeaves(np.repeat(fronds.leaf[mine], places.shape[1]), places.ravel())


def moment_of(world: World, alpha: float, eye: Array) -> StillMoment:
    """Return the moment `alpha` of the way from the last tick to the present tick."""
    return StillMoment((world.state.tick - 1 + alpha) * TICK_S, alpha, eye)


def _sampled(image: Array, at: Array, wrap: bool) -> Array:
    """Interpolate values (n,) of an image at columns and rows `at` (n, 2)."""
    rows, columns = image.shape
    low = np.floor(at).astype(int)
    share = at - low
    out = np.zeros(len(at))
    for i in (0, 1):
        for j in (0, 1):
            column, row = low[:, 0] + i, low[:, 1] + j
            if wrap:
                column, row = column % columns, row % rows
            column, row = np.clip(column, 0, columns - 1), np.clip(row, 0, rows - 1)
            weight = np.abs(1 - i - share[:, 0]) * np.abs(1 - j - share[:, 1])
            out += weight * image[row, column]
    return out


def _shade(sky: Array) -> Array:
    """Compute the factor (n, 1) of colours that see a share (n,) of the sky."""
    return np.asarray(SHADE + (1.0 - SHADE) * np.clip(sky, 0.0, 1.0))[:, None]


def _mix(a: Array, b: Array, share: Array) -> Array:
    """Mix two colours by shares (n,)."""
    return np.asarray(a + share[:, None] * (b - a))
