"""The HDF5 library on a disk without room."""

import numpy as np

from subsea.base.hdf5 import _Disk
from tests.support.commands import full_disk


def test_what_a_full_disk_refused_is_read_again_as_it_was_written(tmp_path):
    """The library would take what it finds in its buffer instead, and crash."""
    rng = np.random.default_rng(5)
    whole = np.zeros(4000, np.uint8)
    with (tmp_path / "file").open("w+b", buffering=0) as raw, full_disk(1000):
        disk = _Disk(raw)
        for _ in range(60):
            begin, size = rng.integers(3000), rng.integers(1, 1000)
            block = rng.integers(0, 256, size, np.uint8)
            whole[begin : begin + size] = block
            disk.seek(begin)
            assert disk.write(block) == size
            low, size = rng.integers(begin + 1), rng.integers(1, 900)
            end = min(low + size, begin + len(block))
            found = np.full(end - low, 255, np.uint8)
            disk.seek(low)
            assert disk.readinto(found) == len(found)
            np.testing.assert_array_equal(found, whole[low:end])
        assert disk.fault
    assert (tmp_path / "file").stat().st_size <= 1000
