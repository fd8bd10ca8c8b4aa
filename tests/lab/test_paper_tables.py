"""The paper's tables compare like with like."""

from types import SimpleNamespace

import numpy as np
import pytest

from subsea import __version__
from subsea.dive.start import start_world
from subsea.frame.packet import pack
from subsea.lab import paper_tables
from subsea.motor.pose import nodes_world


def test_playback_is_timed_on_the_real_nodes():
    world = start_world("peaceful", fish=9)
    fishes, library = world.state.fishes, world.library
    nodes = np.empty((9, 23, 3), np.float32)
    paper_tables.place_nodes(fishes, library.nodes, nodes)
    for i in range(9):
        assert nodes[i] == pytest.approx(nodes_world(fishes, library, i), abs=1e-3)


def test_a_view_with_a_number_of_fishes_is_found():
    world = start_world("peaceful")
    found = [len(pack(world, paper_tables.view_of(world, n), 1.0).instances) for n in (0, 10, 60)]
    assert found[0] <= found[1] <= found[2]
    assert abs(found[1] - 10) <= 6


@pytest.mark.nightly
def test_the_tables_print_both_machines(capsys, monkeypatch):
    for name, small in (("SIMULATED_TICKS", 20), ("PLAYED_TICKS", 3), ("REDUCED_PICTURES", 1)):
        monkeypatch.setattr(paper_tables, name, small)
    monkeypatch.setattr(paper_tables, "SIZE", (160, 120))
    monkeypatch.setattr(paper_tables, "RENDERED", ("peaceful",))
    assert paper_tables.paper_tables() == 0
    out = capsys.readouterr().out
    assert f"subsea {__version__}, " in out
    for figure in ("40", "0.01", "4000", "2340", "85", "27.53"):
        assert figure in out.split()


def test_a_slow_machine_draws_once(monkeypatch):
    drawn = []
    renderer = SimpleNamespace(draw=drawn.append)
    context = SimpleNamespace(finish=lambda: None)
    assert min(paper_tables.drawing_ms(renderer, context, "packet", 5)) > 0.0
    assert len(drawn) == 6
    monkeypatch.setattr(paper_tables, "MAX_DRAWING_S", 0.0)
    assert min(paper_tables.drawing_ms(renderer, context, "packet", 5)) > 0.0
    assert len(drawn) == 7
