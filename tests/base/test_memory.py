"""Memory of the process: what is free goes back to the system."""

import weakref

from subsea.base import memory


def test_gaps_between_blocks_in_use_go_back_to_the_system():
    blocks = [bytes(1000) for _ in range(100_000)]
    kept = blocks[::100]  # pins the heap
    del blocks
    (before,) = memory.resident_mb()
    memory.give_back_memory()
    assert memory.resident_mb()[0] < before - 50.0
    assert len(kept) == 1000


def test_objects_that_only_hold_each_other_are_freed():
    class Knot:
        pass

    knot = Knot()
    knot.itself = knot
    gone = weakref.ref(knot)
    del knot
    memory.give_back_memory()
    assert gone() is None


def test_a_system_without_figures_is_no_fault(monkeypatch, tmp_path):
    monkeypatch.setattr(memory, "STATUS", tmp_path / "status")
    assert memory.resident_mb() == []
