"""The score: quiet, repeatable, and after the mood of the sea."""

import numpy as np
import pytest

from subsea.sound.mixer import Mixer, SoundLevels
from subsea.sound.moment import BED_COLUMNS, BEDS, GROUPS, SCORE, SURF, Moment
from subsea.sound.score import CALM, COURTSHIP, HUNT, SCALES, Mood, Score, mood_of
from subsea.sound.space import BLOCK, LAYOUTS, RATE
from subsea.state import LOOPING, STALKING

SECONDS = 60


def played(mood, seed=1, first=1):
    """The samples (2, n) of a minute of the score alone."""
    score = Score()
    blocks = [score.play(first + k, seed, mood) for k in range(int(SECONDS / 0.033))]
    return np.concatenate(blocks, axis=1)


def tones(samples, low=20.0, high=1000.0):
    """Strong tones, semitones above 110 Hz, of the sum of two channels."""
    power = np.abs(np.fft.rfft(samples.sum(axis=0) * np.hanning(samples.shape[1]))) ** 2
    hz = np.fft.rfftfreq(samples.shape[1], 1.0 / RATE)
    peaks = (power[1:-1] > power[:-2]) & (power[1:-1] > power[2:])
    strong = peaks & (power[1:-1] > 0.05 * power.max()) & (hz[1:-1] > low) & (hz[1:-1] < high)
    return 12.0 * np.log2(hz[1:-1][strong] / 110.0)


def test_the_same_dive_has_the_same_score():
    calm = played(Mood())
    assert (calm == played(Mood())).all()
    assert not np.allclose(calm, played(Mood(), seed=2))
    assert np.abs(calm).max() > 0.02


@pytest.mark.parametrize("kind", [CALM, HUNT, COURTSHIP])
def test_each_mood_keeps_to_its_scale(kind):
    found = np.round(tones(played(Mood(kind)))) % 12
    allowed = {*SCALES[kind].tolist(), *((SCALES[kind] + 7) % 12).tolist()}  # third overtones
    assert set(found.astype(int)) <= allowed


def test_depth_and_night_lower_the_score():
    day, deep, night = (
        np.average(tones(played(mood))) for mood in (Mood(), Mood(CALM, 1.0), Mood(CALM, 0.0, 0.0))
    )
    assert deep < day - 3.0
    assert night < day - 2.0


def test_notes_begin_and_end_without_a_click():
    samples = played(Mood(COURTSHIP))
    # No sine below 1 kHz steps farther than this from one sample to the next.
    assert np.abs(np.diff(samples)).max() < 2.0 * np.pi * 1000.0 / RATE * np.abs(samples).max()
    assert np.abs(samples[:, :10]).max() < 1e-3


def sea(level, tick, kind=CALM):
    beds = np.zeros((len(BEDS), len(BED_COLUMNS)))
    beds[SURF] = level, 0.0, 0.0, 0.0, 1.0
    return Moment(tick, 1, np.zeros((0, 10)), beds, (), 0.0, Mood(kind))


def test_the_score_stays_below_the_sea_and_steps_back_for_loud_sounds():
    mixer = Mixer(LAYOUTS["stereo"])
    loud = 0.03 * 0.1 ** np.clip((np.arange(1500) - 600) / 300.0, 0.0, 1.0)  # down in ten seconds
    stems = np.concatenate(
        [mixer.stems(sea(level, k + 1), scored=True) for k, level in enumerate(loud)], axis=1
    )
    assert len(stems) == len(GROUPS)
    window = 90 * BLOCK  # three seconds
    power = (stems**2).sum(axis=2)
    rms = [
        np.sqrt(one[: len(one) // window * window].reshape(-1, window).mean(axis=1))
        for one in (power[SCORE], power[:SCORE].sum(axis=0))
    ]
    assert (rms[0] < 0.75 * rms[1]).all()
    assert rms[0][2:10].mean() > 3.0 * rms[0][-4:].mean() > 0.0


def test_the_score_is_added_only_if_asked_for_and_ends_without_a_click():
    plain, scored = (Mixer(LAYOUTS["stereo"]) for _ in range(2))
    quiet, full = SoundLevels(1.0), SoundLevels(1.0, score=1.0)
    blocks = [
        (plain.mix(sea(0.03, k), quiet), scored.mix(sea(0.03, k), full if k < 600 else quiet))
        for k in range(1, 640)
    ]
    bare, both = (np.concatenate(part) for part in zip(*blocks, strict=True))
    added = both - bare
    assert np.abs(added[: 599 * BLOCK]).max() > 0.002
    steps = np.abs(np.diff(added, axis=0)).max(axis=1)
    assert steps[598 * BLOCK :].max() <= steps[: 598 * BLOCK].max()
    assert both[605 * BLOCK :] == pytest.approx(bare[605 * BLOCK :], abs=1e-4)


def test_moods_follow_hunts_and_courtships(heard):
    world, _ = heard
    minds, near = world.state.minds, np.full(len(world.state.fishes.alive), 500.0)
    kept = minds.hunt.copy(), minds.courtship.copy()
    minds.hunt[:], minds.courtship[:] = 0, 0
    found = [mood_of(world, 300.0, near).kind]
    minds.courtship[1] = LOOPING
    found.append(mood_of(world, 300.0, near).kind)
    minds.hunt[0] = STALKING
    found += [mood_of(world, 300.0, near).kind, mood_of(world, 300.0, 10.0 * near).kind]
    minds.hunt[:], minds.courtship[:] = kept
    assert found == [CALM, COURTSHIP, HUNT, CALM]
