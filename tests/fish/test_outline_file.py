"""Surfaces from side outlines: back, belly, tail and width, and lines that cannot be a fish."""

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.base.toml_files import load_toml
from subsea.fish.outline_file import OutlinePlan, has_tail_fin, make_surface, read_outline
from subsea.fish.scaffold import DENSITY, volumes_at
from subsea.fish.surface import along, rest_surface

OUTLINES = sorted(resource_path("docs/outlines").glob("*.toml"))
NAMES = [path.stem for path in OUTLINES]


@pytest.fixture(scope="module")
def tuna():
    """The points (n, 2) of a tuna."""
    return np.array(load_toml(resource_path("docs/outlines/tuna.toml"), OutlinePlan).outline)


def surface_of(points, **fins):
    return make_surface(OutlinePlan(outline=[tuple(point) for point in points], **fins))


@pytest.mark.parametrize("path", OUTLINES, ids=NAMES)
def test_a_surface_has_the_points_of_its_outline(path):
    points = np.array(load_toml(path, OutlinePlan).outline) / 100.0
    surface = read_outline(path, None, None)
    assert has_tail_fin(surface) == (path.stem != "seahorse")
    begin = surface.tail.begin
    for curve, side in ((surface.back, 1.0), (surface.belly, -1.0)):
        mine = points[(side * points[:, 1] > 0.01) & (points[:, 0] < begin)]
        heights = along(curve, mine[:, 0])
        slope = np.polyfit(mine[:, 0], heights - mine[:, 1], 1)[0]  # of the axis, if it is tilted
        np.testing.assert_allclose(heights, mine[:, 1] + slope * mine[:, 0], atol=0.004)
    mesh = rest_surface(surface)
    assert np.isfinite(mesh).all() and np.ptp(mesh[:, 0]) == pytest.approx(1.0, abs=0.01)


def test_unit_direction_and_first_point_of_an_outline_do_not_matter(tuna):
    expected = surface_of(tuna)
    moved = np.roll(0.37 * tuna[::-1] + (5.0, -8.0), 11, axis=0)
    found = surface_of([*moved, moved[0]])  # closed by its first point again
    for name in ("back", "belly", "width"):
        at = np.linspace(0.0, 1.0, 50)
        ours, others = (along(getattr(one, name), at) for one in (found, expected))
        np.testing.assert_allclose(ours, others, atol=2e-4)
    assert found.tail.begin == expected.tail.begin
    # An outline that climbs to the rear lies along its axis.
    climbing = surface_of(np.stack([tuna[:, 0], tuna[:, 1] + 0.1 * tuna[:, 0]], axis=1))
    root = np.array([expected.tail.begin])
    assert abs(along(climbing.back, root) + along(climbing.belly, root))[0] < 0.003


def test_fins_are_in_the_axes_of_the_outline(tuna):
    edge = [(30.0, 12.4), (33.0, 18.0), (40.0, 13.0), (45.0, 12.6)]
    fin = surface_of(tuna, dorsal=edge).dorsal
    assert fin.base == (0.3, 0.45)
    np.testing.assert_allclose(fin.edge, np.array(edge) / 100.0, atol=0.002)
    with pytest.raises(ValueError, match="dorsal fin must run from front to rear"):
        surface_of(tuna, dorsal=edge[::-1])


def test_the_width_follows_from_the_mass(tuna):
    plan = OutlinePlan(outline=[tuple(point) for point in tuna])
    for grams in (20_000.0, 30_000.0):
        surface = make_surface(plan, 120.0, grams)
        volume = volumes_at(surface, (0.0, 10.0, 30.0, 60.0, 90.0, 105.0, 120.0)).sum()
        assert DENSITY * volume == pytest.approx(grams, rel=0.01)
    with pytest.raises(ValueError, match=r"of 3 cm .* cannot weigh 1000 g; expected .* to .* g"):
        make_surface(plan, 3.0, 1000.0)


def test_lines_that_are_no_fish_are_refused(tuna):
    crossing = tuna.copy()
    crossing[[3, 28]] = crossing[[28, 3]]
    with pytest.raises(ValueError, match=r"crosses itself, between points \d+ and \d+"):
        surface_of(crossing)
    with pytest.raises(ValueError, match="the tail comes first: mirror"):
        surface_of(tuna * (-1.0, 1.0))
    with pytest.raises(ValueError, match="lengths high"):
        surface_of(tuna * (1.0, 0.01))
    with pytest.raises(ValueError, match="different points, expected 12"):
        surface_of(np.repeat(tuna[::4], 4, axis=0))


def test_a_faulty_file_is_one_line_with_its_key(tmp_path):
    path = tmp_path / "fish.toml"
    text = resource_path("docs/outlines/tuna.toml").read_text(encoding="utf-8")

    def told(change):
        path.write_text(change(text), encoding="utf-8")
        with pytest.raises(UserError) as fault:
            read_outline(path, None, None)
        assert "\n" not in str(fault.value) and str(path) in str(fault.value)
        return str(fault.value)

    assert "a mass needs a length" in told(lambda text: text.replace("length_cm = 120\n", ""))
    assert "cannot weigh 5 g" in told(lambda text: text.replace("30000", "5"))
    assert "`outlin`" in told(lambda text: text.replace("outline = ", "outlin = "))
    assert "nan" in told(lambda text: text.replace("[5, 4.2]", "[nan, 4.2]"))
