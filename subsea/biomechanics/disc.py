"""A disc with two wings: a lattice of nodes in two layers, with muscles along the span.

A column of nodes lies along each of several chords, a row at each share of the chord. Units join
neighbours along chord and span, the two layers, and the diagonals of all faces. The spanwise units
are muscles: those of the back raise the wing while those of the belly give way, and the reverse.

The water is that of a slender body (Lighthill 1971) for each chord. Up to the share s of its chord
c a section carries the added mass ½πρsc per chord and span. It moves at u t + w n: t points to the
front edge, n out of the back. The momentum w n of the water flows to the rear and is shed at the
rear edge: the force on a section is

    - d/dt (M w n) + Φ_front - Φ_rear - C |w| w n - S |v| v,   Φ = m (u w n - w² t / 2).

The velocity v lies in the plane of the section. Water that flows along the span is neglected. A
step is symplectic Euler with the added mass of a section in the mass of its two nodes. So body and
water exchange exactly what the one loses and the other gains.

In straight swimming the body keeps any pitch and bank that it has: it is stable, but does not come
back. A weak couple on the trunk, as of small fins, holds the depth and the bank.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.biomechanics.body import Floats, Ints
from subsea.biomechanics.reactive_water import DENSITY
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, STRAIN_LIMITS
from subsea.kernels import kernel

LAYERS = 2  # back and belly
LEVER_SHARE = 0.7  # distance of the layers, as a share of the thickness
LEAST_LEVER = 0.8  # least distance of the layers, over the greatest: a thin wing gives no lever
LEAST_FIRM = 0.15  # least stiffness of a part for its length, over that of the thickest part
PITCH_RATE, BANK_RATE = 0.25, 0.5  # 1/tu, at which the posture returns
MOST_AIM = 0.2  # pitch, rad
SHEAR = 0.15  # stiffness of the diagonals of a layer: a wing twists easily
LEAST_MASS = 0.05  # least mass of a node, over the greatest
GAIN_OF_DEPTH, GAIN_OF_CLIMB = 0.002, 0.03  # aim of the pitch, rad per cm and per cm/tu of sinking
SAFETY = 0.7  # step of the solver over the longest stable one


class DiscOutline(NamedTuple):
    """The shape of a disc at J columns from the left tip to the right one, and I rows; cm."""

    right: Array  # (J,) of the spine
    front: Array  # (J,) behind the snout
    chord: Array  # (J,)
    chords: Array  # (J,) cm², integral of the chord over the span of a column
    squares: Array  # (J,) cm³, the same of its square
    thick: Array  # (J, I)
    side: Array  # (I,) height of the trunk at the middle column
    fin: float  # height of the edge that sheds water that flows aside, at the rear of the trunk
    tail: float  # wetted area of the tail, cm²


class DiscWater(NamedTuple):
    """Coefficients of the sections (J, I); g and cm."""

    added: Array  # g
    plane: Array  # g/cm, added mass per length behind each section, at last at the rear edge
    cross: Array  # g/cm, ½ρ C_d times the area
    skin: Array  # g/cm, ½ρ C_f times the wetted area
    side: Array  # (I,) g/cm, ½ρ C_d times the area of the trunk from the side
    fin: float  # g/cm, added mass per length that is shed behind the trunk


class Hold(NamedTuple):
    """Couples on the trunk that hold its posture, each as a damped spring."""

    pitch: float  # g cm²/tu², per rad
    pitch_rate: float  # g cm²/tu
    bank: float
    bank_rate: float


class Disc(NamedTuple):
    """A disc at rest, and how to simulate it; muscles are the first units."""

    rest: Floats  # (n, 3) cm: ahead, up, right
    mass: Floats  # (n,) g
    units: Ints  # (m, 2) pairs of nodes
    length: Floats  # (m,) cm
    stiffness: Floats  # (m,) g/tu²
    viscosity: Floats  # (m,) g/tu
    water: DiscWater
    hold: Hold
    substeps: int  # steps of the solver in a step of a fish

    @property
    def columns(self) -> int:
        """Number of columns J."""
        return len(self.water.added)

    @property
    def rows(self) -> int:
        """Number of rows I."""
        return self.water.added.shape[1]


class DiscState(NamedTuple):
    """A moving disc."""

    x: Floats  # (n, 3) cm
    v: Floats  # (n, 3) cm/tu
    normal: Floats  # (J, I, 3) of the last step: the momentum of the water
    watch: Floats  # (2,) least and greatest length of a unit over its rest length
    lost: Floats  # (3,) g cm/tu, momentum given to the water behind the disc


def build_disc(
    outline: DiscOutline,
    stiffness: float,
    viscosity: float,
    cross_drag: float,
    skin_drag: float,
) -> Disc:
    """Join nodes of two layers to a disc of the density of water.

    ``stiffness``, g/tu², and ``viscosity``, g/tu, are those of units where the disc is thickest.
    """
    columns, rows = outline.thick.shape
    share = np.linspace(0.0, 1.0, rows)
    hat = np.full(rows, 1.0 / (rows - 1))
    hat[[0, -1]] *= 0.5
    lever = LEVER_SHARE * outline.thick
    lever = np.maximum(lever, LEAST_LEVER * lever.max())
    rest = np.empty((columns, rows, LAYERS, 3))
    rest[..., 0] = -(outline.front[:, None] + outline.chord[:, None] * share)[..., None]
    rest[..., 1] = 0.5 * lever[..., None] * np.array([1.0, -1.0])
    rest[..., 2] = outline.right[:, None, None]
    area = outline.chords[:, None] * hat
    mass = DENSITY * area * outline.thick / LAYERS
    mass = np.maximum(mass, LEAST_MASS * mass.max())
    units, shear = _connect(columns, rows)
    nodes = rest.reshape(-1, 3)
    firm = np.maximum(outline.thick / outline.thick.max(), LEAST_FIRM)
    length = np.linalg.norm(nodes[units[:, 1]] - nodes[units[:, 0]], axis=1)
    sized = np.repeat(firm.ravel(), LAYERS)[units].mean(axis=1) * length.mean() / length
    water = _coefficients(outline, area, share, hat, cross_drag, skin_drag)
    disc = Disc(
        rest=nodes,
        mass=np.repeat(mass.ravel(), LAYERS),
        units=units,
        length=length,
        stiffness=sized * shear * stiffness,
        viscosity=sized * shear * viscosity,
        water=water,
        hold=_hold_of(nodes, np.repeat(mass.ravel() + 0.5 * water.added.ravel(), LAYERS)),
        substeps=1,
    )
    return disc._replace(substeps=int(np.ceil(STEP / (SAFETY * _longest_step(disc)))))


def _hold_of(nodes: Floats, mass: Floats) -> Hold:
    """Couples of a critically damped return to the posture, with the inertia of body and water."""
    arm = nodes - mass @ nodes / mass.sum()
    pitch, bank = (float(mass @ arm[:, axis] ** 2) for axis in (0, 2))
    return Hold(
        pitch * PITCH_RATE**2, 2.0 * pitch * PITCH_RATE, bank * BANK_RATE**2, 2.0 * bank * BANK_RATE
    )


def _coefficients(
    outline: DiscOutline, area: Array, share: Array, hat: Array, cross_drag: float, skin_drag: float
) -> DiscWater:
    per = 0.5 * np.pi * DENSITY
    gap = share[1]
    moment = share * hat
    moment[0], moment[-1] = gap**2 / 6.0, 0.5 * gap - gap**2 / 6.0
    edges = np.append(0.5 * (share[1:] + share[:-1]), 1.0)
    half = 0.5 * DENSITY
    skin = 2.0 * area
    middle = len(area) // 2
    skin[middle, -1] += outline.tail
    side = outline.side * hat * outline.chord[middle]
    return DiscWater(
        added=per * outline.squares[:, None] * moment,
        plane=per * outline.chords[:, None] * edges,
        cross=half * cross_drag * area,
        skin=half * skin_drag * skin,
        side=half * cross_drag * side,
        fin=0.25 * np.pi * DENSITY * outline.fin**2,
    )


def _connect(columns: int, rows: int) -> tuple[Ints, Floats]:
    """Pairs of nodes (m, 2), muscles by column, row and layer first, and shares of stiffness."""
    node = np.arange(columns * rows * LAYERS).reshape(columns, rows, LAYERS)
    back, belly = node[..., 0], node[..., 1]
    pairs = [(node[:-1], node[1:]), (node[:, :-1], node[:, 1:]), (back, belly)]
    for one, other in ((back, belly), (belly, back)):
        pairs += [(one[:-1], other[1:]), (one[:, :-1], other[:, 1:])]
    sheared = [(node[:-1, :-1], node[1:, 1:]), (node[:-1, 1:], node[1:, :-1])]
    firm, soft = (
        np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b in some])
        for some in (pairs, sheared)
    )
    share = np.concatenate([np.ones(len(firm)), np.full(len(soft), SHEAR)])
    return np.concatenate([firm, soft]), share


def _longest_step(disc: Disc) -> float:
    """The longest stable step, tu, of the body without water, which only slows it."""
    i, j = disc.units.T
    along = (disc.rest[j] - disc.rest[i]) / disc.length[:, None]
    root = np.repeat(1.0 / np.sqrt(disc.mass), 3)
    matrices = []
    for modulus in (disc.stiffness, disc.viscosity):
        block = modulus[:, None, None] * along[:, :, None] * along[:, None, :]
        matrix = np.zeros((len(disc.mass), len(disc.mass), 3, 3))
        for a, b, sign in ((i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)):
            np.add.at(matrix, (a, b), sign * block)
        size = 3 * len(disc.mass)
        matrices.append(np.outer(root, root) * matrix.transpose(0, 2, 1, 3).reshape(size, size))
    k, c = (float(np.linalg.eigvalsh(matrix)[-1]) for matrix in matrices)
    return float((np.sqrt(c * c + 4.0 * k) - c) / k)


def disc_at_rest(disc: Disc, speed: float = 0.0) -> DiscState:
    """The disc at rest, its head towards x, or moving ahead at ``speed`` cm/tu."""
    shape = disc.rest.shape
    v = np.zeros(shape)
    v[:, 0] = speed
    normal = np.zeros((disc.columns, disc.rows, 3))
    normal[..., 1] = 1.0
    return DiscState(disc.rest.copy(), v, normal, np.array([np.inf, 0.0]), np.zeros(3))


def copy_disc(state: DiscState) -> DiscState:
    """A state that changes alone."""
    return DiscState(*(part.copy() for part in state))


def kept_shape(state: DiscState) -> bool:
    """True if all units kept their length within limits."""
    low, high = STRAIN_LIMITS
    least, greatest = state.watch
    return bool(np.isfinite(state.x).all() and low <= least and greatest <= high)


def water_momentum(disc: Disc, state: DiscState) -> Array:
    """Momentum (3,) of the water that moves with the disc, g cm/tu."""
    v = state.v.reshape(disc.columns, disc.rows, LAYERS, 3).mean(axis=2)
    w = (v * state.normal).sum(axis=-1)
    return np.einsum("ji,ji,jic->c", disc.water.added, w, state.normal)


def flap(disc: Disc, state: DiscState, raising: Array, bank: Array) -> Floats:
    """Advance ``state`` and return its nodes after every tick, (T, n, 3) in cm.

    ``raising`` (T × steps, J - 1, I) are the contractions of the muscles of the back in each step
    of the solver. Those of the belly give way by as much. The fish holds its depth and the
    ``bank`` (T × steps,), the sine of its lean to the left.
    """
    per_tick = STEPS_PER_TICK * disc.substeps
    frames = np.empty((len(raising) // per_tick, *state.x.shape))
    for tick in range(len(frames)):
        part = slice(tick * per_tick, (tick + 1) * per_tick)
        advance_disc(state, disc, raising[part], bank[part], STEP / disc.substeps)
        frames[tick] = state.x
    return frames


@kernel
def advance_disc(state: DiscState, disc: Disc, raising: Array, bank: Array, step: float) -> None:
    """Advance a disc by steps of ``step`` tu, one for each of ``raising`` (steps, J - 1, I)."""
    water = disc.water
    columns, rows = water.added.shape
    load = np.empty(state.x.shape)
    tangent = np.empty((columns, rows, 3))
    normal = np.empty((columns, rows, 3))
    push = np.empty((columns, rows, 3))
    for k in range(len(raising)):
        load[:] = 0.0
        _hold(state, disc, bank[k], load)
        _pull(state, disc, raising[k], load)
        _frames(state.x, tangent, normal)
        _push_sections(state, water, tangent, normal, push)
        _move(state, disc, load, push, normal, step)
        state.normal[:] = normal


@kernel
def _hold(state: DiscState, disc: Disc, bank: float, load: Floats) -> None:
    """Add couples on the trunk to ``load`` that hold the depth and the sine ``bank`` of a lean."""
    x, v, mass, hold = state.x, state.v, disc.mass, disc.hold
    columns, rows = disc.water.added.shape
    height, climb, total = 0.0, 0.0, 0.0
    for node in range(len(x)):
        total += mass[node]
        height += mass[node] * x[node, 1]
        climb += mass[node] * v[node, 1]
    aim = -(GAIN_OF_DEPTH * height + GAIN_OF_CLIMB * climb) / total
    aim = min(max(aim, -MOST_AIM), MOST_AIM)
    middle = columns // 2
    front, rear = 2 * middle * rows, 2 * (middle * rows + rows - 1)
    long = disc.rest[front, 0] - disc.rest[rear, 0]
    pitch, pitched = 0.0, 0.0
    for layer in range(2):
        pitch += 0.5 * (x[front + layer, 1] - x[rear + layer, 1]) / long
        pitched += 0.5 * (v[front + layer, 1] - v[rear + layer, 1]) / long
    push = 0.5 * (hold.pitch * (aim - pitch) - hold.pitch_rate * pitched) / long
    for layer in range(2):
        load[front + layer, 1] += push
        load[rear + layer, 1] -= push
    left, right = 2 * (middle - 1) * rows, 2 * (middle + 1) * rows
    wide = disc.rest[right, 2] - disc.rest[left, 2]
    lean, leaned = 0.0, 0.0
    for k in range(2 * rows):
        lean += 0.5 / rows * (x[right + k, 1] - x[left + k, 1]) / wide
        leaned += 0.5 / rows * (v[right + k, 1] - v[left + k, 1]) / wide
    push = 0.5 / rows * (hold.bank * (bank - lean) - hold.bank_rate * leaned) / wide
    for k in range(2 * rows):
        load[right + k, 1] += push
        load[left + k, 1] -= push


@kernel
def _pull(state: DiscState, disc: Disc, raising: Array, load: Floats) -> None:
    """Add the forces of the units to ``load`` (n, 3)."""
    x, v = state.x, state.v
    columns, rows = disc.water.added.shape
    muscles = 2 * (columns - 1) * rows
    for m in range(len(disc.units)):
        a, b = disc.units[m, 0], disc.units[m, 1]
        rest = disc.length[m]
        if m < muscles:
            segment, i = m // 2 // rows, m // 2 % rows
            pull = raising[segment, i]
            rest *= 1.0 - pull if m % 2 == 0 else 1.0 + pull
        dx, dy, dz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        size = np.sqrt(dx * dx + dy * dy + dz * dz)
        rate = dx * (v[b, 0] - v[a, 0]) + dy * (v[b, 1] - v[a, 1]) + dz * (v[b, 2] - v[a, 2])
        force = (disc.stiffness[m] * (size - rest) + disc.viscosity[m] * rate / size) / size
        load[a, 0] += force * dx
        load[a, 1] += force * dy
        load[a, 2] += force * dz
        load[b, 0] -= force * dx
        load[b, 1] -= force * dy
        load[b, 2] -= force * dz
        state.watch[0] = min(state.watch[0], size / disc.length[m])
        state.watch[1] = max(state.watch[1], size / disc.length[m])


@kernel
def _middle_of(x: Array, j: int, i: int, rows: int, c: int) -> float:
    """Coordinate c of the mean of the two nodes of a section."""
    a = 2 * (j * rows + i)
    return 0.5 * (x[a, c] + x[a + 1, c])


@kernel
def _frames(x: Array, tangent: Array, normal: Array) -> None:
    """Write the unit vectors t and n (J, I, 3) of the sections."""
    columns, rows = tangent.shape[:2]
    for j in range(columns):
        for i in range(rows):
            front, rear = max(i - 1, 0), min(i + 1, rows - 1)
            left, right = max(j - 1, 0), min(j + 1, columns - 1)
            tx = _middle_of(x, j, front, rows, 0) - _middle_of(x, j, rear, rows, 0)
            ty = _middle_of(x, j, front, rows, 1) - _middle_of(x, j, rear, rows, 1)
            tz = _middle_of(x, j, front, rows, 2) - _middle_of(x, j, rear, rows, 2)
            sx = _middle_of(x, right, i, rows, 0) - _middle_of(x, left, i, rows, 0)
            sy = _middle_of(x, right, i, rows, 1) - _middle_of(x, left, i, rows, 1)
            sz = _middle_of(x, right, i, rows, 2) - _middle_of(x, left, i, rows, 2)
            scale = 1.0 / np.sqrt(tx * tx + ty * ty + tz * tz)
            tangent[j, i, 0], tangent[j, i, 1], tangent[j, i, 2] = (
                tx * scale,
                ty * scale,
                tz * scale,
            )
            nx, ny, nz = sy * tz - sz * ty, sz * tx - sx * tz, sx * ty - sy * tx
            scale = 1.0 / np.sqrt(nx * nx + ny * ny + nz * nz)
            normal[j, i, 0], normal[j, i, 1], normal[j, i, 2] = nx * scale, ny * scale, nz * scale


@kernel
def _push_sections(
    state: DiscState, water: DiscWater, tangent: Array, normal: Array, push: Array
) -> None:
    """Write the forces (J, I, 3) of flux, drag and shed water on the sections."""
    columns, rows = water.added.shape
    push[:] = 0.0
    now, before = np.empty(3), np.empty(3)
    flow, along = np.empty(3), np.empty(3)
    for j in range(columns):
        for i in range(rows):
            t, n = tangent[j, i], normal[j, i]
            u, w = 0.0, 0.0
            for c in range(3):
                flow[c] = _middle_of(state.v, j, i, rows, c)
                u += flow[c] * t[c]
                w += flow[c] * n[c]
            speed = 0.0
            for c in range(3):
                now[c] = u * w * n[c] - 0.5 * w * w * t[c]
                along[c] = flow[c] - w * n[c]
                speed += along[c] * along[c]
            speed = np.sqrt(speed)
            for c in range(3):
                if i > 0:  # from the section in front to this one
                    passed = 0.5 * water.plane[j, i - 1] * (before[c] + now[c])
                    push[j, i - 1, c] -= passed
                    push[j, i, c] += passed
                if i == rows - 1:
                    push[j, i, c] -= water.plane[j, i] * now[c]
                before[c] = now[c]
                push[j, i, c] -= water.cross[j, i] * abs(w) * w * n[c]
                push[j, i, c] -= water.skin[j, i] * speed * along[c]
            if j == columns // 2:
                aside = 0.0
                sx, sy, sz = (
                    t[1] * n[2] - t[2] * n[1],
                    t[2] * n[0] - t[0] * n[2],
                    t[0] * n[1] - t[1] * n[0],
                )
                aside = flow[0] * sx + flow[1] * sy + flow[2] * sz
                drag = water.side[i] * abs(aside) * aside
                if i == rows - 1:
                    drag += water.fin * abs(u) * aside
                push[j, i, 0] -= drag * sx
                push[j, i, 1] -= drag * sy
                push[j, i, 2] -= drag * sz


@kernel
def _move(
    state: DiscState, disc: Disc, load: Floats, push: Array, normal: Array, step: float
) -> None:
    """Give forces, and the changed momentum of the water, to the nodes, and move them."""
    x, v, added = state.x, state.v, disc.water.added
    columns, rows = added.shape
    mean, force = np.empty(3), np.empty(3)
    for j in range(columns):
        for i in range(rows):
            a = 2 * (j * rows + i)
            b = a + 1
            mass = disc.mass[a]
            n, old = normal[j, i], state.normal[j, i]
            held = 0.0
            for c in range(3):
                held += 0.5 * (v[a, c] + v[b, c]) * old[c]
            lead = 0.0
            for c in range(3):
                force[c] = load[a, c] + load[b, c] + push[j, i, c]
                state.lost[c] -= step * push[j, i, c]
                # Momentum that both nodes and their water shall have.
                mean[c] = mass * (v[a, c] + v[b, c]) + added[j, i] * held * old[c] + step * force[c]
                lead += mean[c] * n[c]
            w = lead / (2.0 * mass + added[j, i])
            for c in range(3):
                new = (mean[c] - added[j, i] * w * n[c]) / (2.0 * mass)
                apart = 0.5 * (v[a, c] - v[b, c]) + 0.5 * step * (load[a, c] - load[b, c]) / mass
                v[a, c], v[b, c] = new + apart, new - apart
                x[a, c] += step * v[a, c]
                x[b, c] += step * v[b, c]
