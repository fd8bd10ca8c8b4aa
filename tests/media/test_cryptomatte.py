"""Cryptomatte, against the examples of its specification and counts of samples."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.media.cryptomatte import NOTHING, RANKS, hashed, id_of, matte, murmur3, ranked


@pytest.mark.parametrize(
    ("data", "bits"),
    [(b"", 0), (b"a", 0x3C2569B2), (b"ab", 0x9BBFD75F), (b"abc", 0xB3DD93FA), (b"abcd", 0x43ED676A),
     (b"Hello, world!", 0xC0363E43),
     (b"The quick brown fox jumps over the lazy dog", 0x2E4FF723)],
)  # fmt: skip
def test_the_hash_is_murmur3(data, bits):
    assert murmur3(data) == bits


# The manifest of the specification: https://github.com/Psyop/Cryptomatte/tree/master/specification
@pytest.mark.parametrize(("name", "bits"), [("bunny", "13851a76"), ("default", "42c9679f")])
def test_names_have_the_ids_of_other_programs(name, bits):
    assert f"{hashed(name):08x}" == bits


@given(st.text(max_size=12))
def test_an_id_is_a_normal_number_with_the_bits_of_the_hash(name):
    found = id_of(name)
    assert np.isfinite(found)
    assert abs(found) >= np.finfo(np.float32).tiny
    assert found.view(np.uint32) == hashed(name)


@given(st.integers(1, 20), st.integers(0, 2**31))
def test_shares_count_the_samples(count, seed):
    dice = np.random.default_rng(seed)
    thing = np.array([NOTHING, 0, 1, 2, 2, 3, 4, 5, 6, 7])
    samples = dice.integers(0, dice.integers(1, 11), (count, 3, 5)).astype(np.uint16)
    number, share = ranked(thing, samples)
    assert (np.diff(share, axis=0) <= 0.0).all()
    for row, column in np.ndindex(3, 5):
        shown = thing[samples[:, row, column]]
        counts = np.sort([(shown == k).sum() for k in range(8)])[::-1]
        assert share[:, row, column] * count == pytest.approx(counts[:RANKS], abs=1e-4)
        for k, part in zip(number[:, row, column], share[:, row, column], strict=True):
            assert (k == NOTHING) == (part == 0.0)
            assert k == NOTHING or part * count == pytest.approx((shown == k).sum(), abs=1e-4)


def test_channels_and_manifest_belong_together():
    fishes = matte("CryptoFish", {10_000: "clownfish:0", 10_001: "ray:0"}, 10_002)
    samples = np.array([10_000, 10_000, 10_001, 0], np.uint16).reshape(4, 1, 1)
    channels = fishes.channels(samples)
    assert sorted(channels) == sorted(f"CryptoFish0{k}.{c}" for k in range(3) for c in "RGBA")
    header = fishes.header()
    (key,) = {name.rpartition("/")[0] for name in header}
    assert key == f"cryptomatte/{murmur3(b'CryptoFish'):08x}"[:-1]
    manifest = json.loads(header[f"{key}/manifest"])
    shown = {f"{np.float32(channels[f'CryptoFish00.{c}'][0, 0]).view(np.uint32):08x}" for c in "RB"}
    assert shown == set(manifest.values())
    assert channels["CryptoFish00.G"][0, 0] == 0.5
    assert channels["CryptoFish00.A"][0, 0] == 0.25
    assert channels["CryptoFish01.R"][0, 0] == 0.0 == channels["CryptoFish01.G"][0, 0]
