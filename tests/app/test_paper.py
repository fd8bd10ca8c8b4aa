"""The paper's tables compare like with like."""

import numpy as np
import pytest

from subsea.app import paper
from subsea.app.start import start_world
from subsea.body.pose import nodes_world


def test_playback_is_timed_on_the_real_nodes():
    world = start_world("peaceful", fish=9)
    fishes, library = world.state.fishes, world.library
    nodes = np.empty((9, 23, 3), np.float32)
    paper.place_nodes(fishes, library.nodes, nodes)
    for i in range(9):
        assert nodes[i] == pytest.approx(nodes_world(fishes, library, i), abs=1e-3)


def test_the_time_to_draw_counts_the_upload():
    stages = {"cull": 64.0, "upload": 2.0, "draw": 8.0, "present": 32.0}
    assert paper.draw_ms({"stages_ms": stages}) == 10.0


def test_the_tables_print_both_machines(capsys, monkeypatch):
    for name, small in (("SIMULATED_TICKS", 4), ("PLAYED_TICKS", 3), ("RENDERED_FRAMES", 2)):
        monkeypatch.setattr(paper, name, small)
    monkeypatch.setattr(paper, "SIZE", (160, 120))
    assert paper.paper_tables() == 0
    out = capsys.readouterr().out
    for figure in ("40", "0.01", "4000", "2340", "85", "27.53"):
        assert figure in out.split()
