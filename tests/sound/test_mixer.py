"""The sound of a dive: levels, groups, and how it is cut."""

import numpy as np
import pytest

from subsea.base.system import resource_names
from subsea.dive.directed_camera import tour_steering
from subsea.rendering.sea.particles import slots
from subsea.scenario.load import load_scenario
from subsea.sound.ambience import HUSHED_CM, LARGE_CM, breathing
from subsea.sound.mixer import Mixer, SoundLevels, _breath, _swell
from subsea.sound.moment import (
    BED_COLUMNS,
    BEDS,
    BUBBLE,
    CRACKLE,
    EVENT_COLUMNS,
    GROUPS,
    LAP,
    LARGE,
    MOTOR,
    SAND,
    SNAP,
    SNAPS_S,
    STRIKE,
    WINCH,
    Moment,
    Sources,
    _event,
    hear,
    nearness_of,
    side_of,
    sources_of,
)
from subsea.sound.space import BLOCK, LAYOUTS, RATE, fading, listener_of
from subsea.sound.voices import KNOCK, WHOOSH, minnaert_hz
from subsea.world.build import create_world
from subsea.world.step import step
from tests.sound.conftest import ears, mixed
from tests.support.loudness import by_ffmpeg, loudness, true_peak

STEREO = LAYOUTS["stereo"]
SILENT = np.zeros((len(BEDS), len(BED_COLUMNS)))


def moment(*events, beds=SILENT, tick=1):
    return Moment(tick, 1, np.array(events).reshape(-1, len(EVENT_COLUMNS)), beds, ())


def event(voice, level=0.5, way=(0.0, 1.0, 0.0), when=0.0, size=1000.0, pitch=1.0, away=100.0):
    return (voice, when, level, *way, away, size, pitch, 7.0)


def bed(number, level, pitch=100.0, way=(0.0, 1.0, 0.0)):
    beds = SILENT.copy()
    beds[number] = (level, *way, pitch)
    return beds


def test_the_same_dive_sounds_the_same(heard):
    moments = heard[1][:40]
    assert (mixed(*moments) == mixed(*moments)).all()


def test_the_bay_is_heard_without_clicks_or_clipping(heard):
    samples = mixed(*heard[1])
    assert 0.002 < np.sqrt((samples**2).mean()) < 0.2
    assert np.abs(samples).max() < 1.0
    # A band up to 15 kHz cannot step farther than this from one sample to the next.
    assert np.abs(np.diff(samples, axis=0)).max() < 2.0 * np.abs(samples).max()
    voices = {int(voice) for one in heard[1] for voice in one.events[:, 0]}
    assert {SNAP, BUBBLE} <= voices


def test_borders_of_ticks_are_not_heard(heard):
    """Steps at the first samples of ticks are like all others."""
    beds = [one._replace(events=one.events[:0]) for one in heard[1][:60]]
    samples = mixed(*beds)[:, 0].astype(float)
    steps = np.abs(np.diff(samples))
    at_borders = steps[BLOCK - 1 :: BLOCK]
    assert np.median(at_borders) < 2.0 * np.median(steps)
    assert at_borders.max() <= 1.2 * np.delete(steps, slice(BLOCK - 1, None, BLOCK)).max()


def test_all_muted_is_silence(heard):
    for levels in (
        SoundLevels(mute=True),
        SoundLevels(volume=0.0),
        SoundLevels(1.0, 0.0, 0.0, 0.0),
    ):
        assert not mixed(*heard[1][:20], levels=levels).any()


@pytest.mark.nightly
def test_groups_add_up_to_the_whole(heard):
    moments, mixer = heard[1][:40], Mixer(STEREO)
    stems = np.concatenate([mixer.stems(one) for one in moments], axis=1)
    parts = dict(zip(GROUPS[:3], stems, strict=True))
    assert stems.sum(axis=0) == pytest.approx(mixed(*moments), abs=1e-5)
    sea = mixed(*moments, levels=SoundLevels(1.0, 1.0, 0.0, 0.0))
    assert sea == pytest.approx(parts["sea"], abs=1e-5)
    assert np.abs(parts["vessel"]).max() > 0.001


def test_levels_fall_with_distance():
    rms = []
    for away in (500.0, 1000.0):
        found = mixed(moment(event(KNOCK, fading(away), away=away), tick=1), moment(tick=2))
        rms.append(np.sqrt((found**2).mean()))
    assert rms[1] == pytest.approx(0.5 * rms[0], rel=0.05)


def test_pan_and_delay_of_an_event():
    right = mixed(moment(event(KNOCK, way=(1.0, 0.0, 0.0))), layout=LAYOUTS["binaural"])
    assert np.abs(right[:, 1]).max() > 1.5 * np.abs(right[:, 0]).max()
    first = [np.flatnonzero(np.abs(channel) > 1e-4)[0] for channel in right.T]
    assert 20 < first[0] - first[1] < 40  # 28 samples are 0.58 ms
    ahead = mixed(moment(event(KNOCK)), layout=LAYOUTS["binaural"])
    assert ahead[:, 0] == pytest.approx(ahead[:, 1])


def test_an_event_goes_on_in_later_ticks():
    found = mixed(moment(event(WHOOSH, when=0.5)), *(moment(tick=k) for k in range(2, 20)))
    assert not found[: BLOCK // 2].any()
    assert found[5 * BLOCK : 8 * BLOCK].any()
    assert not found[-BLOCK:].any()


@pytest.mark.parametrize(("number", "hz"), [(MOTOR, 60.0), (WINCH, 170.0)])
def test_tones_have_the_pitch_that_is_asked_for(number, hz):
    found = mixed(*(moment(beds=bed(number, 0.2, hz), tick=k) for k in range(1, 60)))[:, 0]
    power = np.abs(np.fft.rfft(found[BLOCK:] * np.hanning(len(found) - BLOCK), RATE)) ** 2
    assert power.argmax() == pytest.approx(hz, abs=1.5)


def test_a_bubble_is_heard_at_its_resonance():
    hz = minnaert_hz(0.25, 400.0)
    found = mixed(moment(event(BUBBLE, size=hz)), moment(tick=2), moment(tick=3))[:, 0]
    assert np.abs(np.fft.rfft(found, RATE)).argmax() == pytest.approx(hz, rel=0.02)


def test_a_source_that_passes_falls_in_pitch(heard):
    """Doppler, as an event's row has it."""
    world, _ = heard
    ahead, speed = np.array([300.0, 0.0, -300.0]), np.array([3000.0, 0.0, 0.0])
    comes, goes = (_event(world, ears(), STRIKE, ahead, way, 1) for way in (-speed, speed))
    pitch = EVENT_COLUMNS.index("pitch")
    assert comes[pitch] == pytest.approx(1.0 / 0.98)
    assert goes[pitch] == pytest.approx(1.0 / 1.02)


def test_volumes_change_without_a_step():
    beds = [moment(beds=bed(MOTOR, 0.5, 50.0), tick=k) for k in range(1, 5)]
    mixer = Mixer(STEREO)
    blocks = [
        mixer.mix(one, SoundLevels(volume)) for one, volume in zip(beds, (1, 1, 0, 0), strict=True)
    ]
    assert not blocks[3].any()
    whole = np.concatenate(blocks)[:, 0]
    assert np.abs(np.diff(whole)).max() < 1.2 * np.abs(np.diff(blocks[0][:, 0])).max()


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
def test_peaks_stay_below_full_scale(layout):
    """True peaks, between samples, of the whole and of each stem."""
    voices = (SNAP, STRIKE, KNOCK)
    crowd = [event(voices[k % 3], 1.0 + k % 4, when=k / 30, pitch=1.0 + k / 60) for k in range(30)]
    moments = [moment(*crowd), *(moment(tick=k) for k in range(2, 12))]
    mixer = Mixer(layout)
    stems = np.concatenate([mixer.stems(one) for one in moments], axis=1)
    peaks = [true_peak(part) for part in (*stems, mixed(*moments, layout=layout))]
    assert max(peaks) < -1.0
    assert min(peaks[0], peaks[1], peaks[-1]) > -8.0
    calm = mixed(*moments, layout=layout, levels=SoundLevels(1.0, night=True))
    assert np.abs(calm).max() < 0.3


def test_a_limited_sound_keeps_its_shape():
    soft, loud = (
        mixed(*(moment(beds=bed(MOTOR, level, 60.0), tick=k) for k in range(1, 12)))[2 * BLOCK :, 0]
        for level in (0.02, 1.0)
    )
    assert 0.5 < np.abs(loud).max() < 0.7
    assert np.corrcoef(soft, loud)[0, 1] > 0.99


def rhythm(levels):
    """The greatest autocorrelation of levels after its first minimum: 1 for a metronome."""
    levels = levels - levels.mean()
    turned = np.fft.rfft(levels, 2 * len(levels))
    likeness = np.fft.irfft(np.abs(turned) ** 2)[: len(levels) // 4] / (levels**2).sum()
    first = int(np.argmax(np.diff(likeness) > 0.0))
    return likeness[first:].max()


@pytest.mark.parametrize(("level", "most"), [(_swell, 0.3), (_breath, 0.4)])
def test_waves_and_breath_have_no_rhythm(level, most):
    times = np.arange(0.0, 600.0, 0.1)
    for seed in (1, 2):
        levels = np.array([level(seed, t) for t in times])
        assert levels.min() >= 0.0 and 0.9 < levels.max() <= 1.0
        assert rhythm(levels) < most
        assert (levels == [level(seed, t) for t in times]).all()


def test_a_sea_has_the_loudness_of_a_film(heard):
    samples = mixed(*heard[1], levels=SoundLevels())
    assert loudness(samples) == pytest.approx(-20.0, abs=3.0)
    assert true_peak(samples) < -1.0
    assert by_ffmpeg(samples) == pytest.approx((loudness(samples), true_peak(samples)), abs=0.2)


@pytest.mark.nightly
@pytest.mark.parametrize("name", resource_names("assets/scenarios", ".toml"))
def test_every_sea_has_the_loudness_of_a_film(name):
    world = create_world(load_scenario(name)[0])
    steer, sources = tour_steering(world, "auto"), sources_of(world)
    moments = []
    for _ in range(450):
        step(world, steer(world))
        moments.append(hear(world, listener_of(world), sources))
    for layout in ("stereo", "5.1"):
        mixer = Mixer(LAYOUTS[layout])
        stems = np.concatenate([mixer.stems(one) for one in moments], axis=1)
        assert max(true_peak(part) for part in stems) < -1.0
        samples = mixed(*moments, layout=LAYOUTS[layout], levels=SoundLevels())
        assert true_peak(samples) < -1.0
        assert -26.0 < loudness(samples, layout) < -16.0  # the open ocean is calm


def test_shrimp_snap_more_where_there_is_more_stone(heard):
    world, _ = heard

    def snaps(size):
        around = Sources(np.array([[100.0, 0.0, -300.0, size]]), np.zeros((0, 5)))
        ticks = range(1, 18_000, 45)  # of ten minutes
        count = 0
        for world.state.tick in ticks:
            count += int((hear(world, ears(), around).events[:, 0] == SNAP).sum())
        return count / (len(ticks) * 0.033)

    tick = world.state.tick
    few, many = snaps(20.0), snaps(400.0)
    world.state.tick = tick
    assert few < 0.2 * many
    assert many == pytest.approx(SNAPS_S, rel=0.2)


def test_only_aboard_the_vessel_is_heard(heard):
    world, _ = heard
    around = Sources(np.zeros((0, 4)), np.zeros((0, 5)))
    inside, outside = (hear(world, ears(velocity=(60.0, 0, 0), aboard=x), around) for x in (1, 0))
    assert inside.beds[MOTOR, 0] > 0.0
    assert outside.beds[MOTOR, 0] == 0.0
    assert 0.0 < outside.beds[BEDS.index("flow"), 0] < inside.beds[BEDS.index("flow"), 0]


def test_sides_and_nearness_in_words():
    ways = {
        (-0.9, 0.1, 0.0): "left", (0.1, 0.9, 0.2): "ahead", (0.9, 0.0, 0.0): "right",
        (0.1, -0.9, 0.0): "behind", (0.1, 0.2, 0.9): "above", (0.0, 0.3, -0.9): "below",
        (0.0, 0.0, 0.0): "",
    }  # fmt: skip
    assert [side_of(way) for way in ways] == list(ways.values())
    assert [nearness_of(away) for away in (100.0, 500.0, 1200.0)] == ["close", "", "far off"]


def beside(world, gap, velocity):
    """Moments before and after the first fish of a world becomes a large one at a `gap`."""
    fishes, ear = world.state.fishes, ears((0.0, 0.0, -300.0))
    stones = Sources(np.array([[120.0, 0.0, -300.0, 300.0]]), np.zeros((0, 5)))
    kept = fishes.length[0], fishes.position[0].copy(), fishes.velocity[0].copy()
    found = []
    for length in (LARGE_CM - 1.0, 130.0):
        fishes.length[0], fishes.velocity[0] = length, velocity
        fishes.position[0] = ear.place + gap
        found.append(hear(world, ear, stones))
    fishes.length[0], fishes.position[0], fishes.velocity[0] = kept
    return found


def test_something_large_is_heard_from_its_side_before_it_is_seen(heard):
    world, _ = heard
    far = 0.9 * world.scenario.water.visibility_cm
    _, comes = beside(world, (0.0, far, 0.0), (0.0, -60.0, 0.0))  # y is left
    _, goes = beside(world, (0.0, far, 0.0), (0.0, 60.0, 0.0))
    before, near = beside(world, (0.0, 300.0, 0.0), (0.0, -60.0, 0.0))
    assert before.beds[LARGE, 0] == 0.0
    assert 0.0 < goes.beds[LARGE, 0] < 0.4 * comes.beds[LARGE, 0] < 0.4 * near.beds[LARGE, 0]
    assert comes.beds[LARGE, 1] < -0.9
    (words,) = [one for one in comes.words if one.words == "something large"]
    assert (side_of(words.way), nearness_of(words.away)) == ("left", "far off")
    assert not any(one.leads for one in (*goes.words, *before.words))


def test_the_reef_falls_silent_before_something_large(heard):
    world, _ = heard
    before, near = beside(world, (0.3 * HUSHED_CM, 0.0, 0.0), (-60.0, 0.0, 0.0))
    assert near.beds[CRACKLE, 0] < 0.3 * before.beds[CRACKLE, 0]
    assert "the reef falls silent" in [one.words for one in near.words]
    snaps, tick = [0, 0], world.state.tick
    for world.state.tick in range(1, 300):
        for k, one in enumerate(beside(world, (0.3 * HUSHED_CM, 0.0, 0.0), (-60.0, 0.0, 0.0))):
            snaps[k] += int((one.events[:, 0] == SNAP).sum())
    world.state.tick = tick
    assert snaps[1] < 0.5 * snaps[0]


def test_places_sound_different(heard):
    """Sand, reef and surface."""
    world, _ = heard
    bare, full = (
        Sources(np.array([[60.0, 0.0, -300.0, size]]), np.zeros((0, 5))) for size in (1.0, 400.0)
    )
    tick, levels = world.state.tick, []
    for world.state.tick in range(1, 20_000, 400):  # ten minutes
        low = ears((0.0, 0.0, world.state.sea.heights.min() + 40.0))
        at = (low, bare), (low, full), (ears((0.0, 0.0, -20.0)), bare)
        levels.append([hear(world, *one).beds[[CRACKLE, SAND, LAP], 0] for one in at])
    world.state.tick = tick
    sand, reef, surface = np.mean(levels, axis=0)
    assert sand[0] < 0.2 * reef[0] and reef[1] < 0.2 * sand[1]
    assert surface[2] > 10.0 * max(sand[2], reef[2])
    crackle = np.array(levels)[:, 1, 0]
    assert crackle.min() < 0.2 * crackle.max()  # it breathes


def test_all_that_breathes_falls_silent_now_and_then():
    times = np.arange(0.0, 600.0, 0.5)
    for seed in (1, 2):
        levels = np.array([breathing(seed, t, 17.0, 53.0, 6) for t in times])
        assert 0.15 < (levels < 0.1).mean() < 0.5
        assert 0.15 < (levels > 0.8).mean() < 0.5
        assert np.abs(np.diff(levels)).max() < 0.12  # in half a second


def test_the_room_echoes_after_a_sound():
    snap = event(SNAP, when=0.0)
    dry, wet = (
        mixed(
            moment(tick=1)._replace(room=room), moment(snap, tick=2)._replace(room=room),
            *(moment(tick=k)._replace(room=room) for k in range(3, 30)),
        )
        for room in (0.0, 1.0)
    )  # fmt: skip
    after = slice(3 * BLOCK, 6 * BLOCK)
    assert not dry[after].any()
    assert 1e-4 < np.abs(wet[after]).max() < np.abs(wet).max()
    assert np.abs(wet[-BLOCK:]).max() < 0.1 * np.abs(wet[after]).max()  # it dies away


def test_changes_of_place_make_no_click():
    """The derivative of a sea that changes in one tick stays within that of what it changes to."""
    calm, wild = bed(SAND, 0.0), bed(SAND, 0.05)
    wild[LARGE], wild[CRACKLE] = (0.1, -1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0, 1.0)
    calm[LARGE] = (0.1, 1.0, 0.0, 0.0, 1.0)
    parts = [
        moment(beds=(wild, calm)[k // 12 % 2], tick=k)._replace(room=float(k // 12 % 2))
        for k in range(1, 120)
    ]
    steady = mixed(*(moment(beds=wild, tick=k)._replace(room=1.0) for k in range(1, 120)))
    steps = np.abs(np.diff(mixed(*parts), axis=0))
    assert steps.max() < 1.3 * np.abs(np.diff(steady, axis=0)).max()


def test_each_bubble_is_heard_when_it_leaves_as_drawn(heard):
    world, _ = heard
    foot, rate, size = (200.0, 50.0, -400.0), 6.0, 1.0
    around = Sources(np.zeros((0, 4)), np.array([[*foot, rate, size]]))
    tick, times = world.state.tick, []
    for world.state.tick in range(1, 1200):
        found = hear(world, ears(), around).events
        begin = (world.state.tick - 1) * 0.033
        times += (begin + 0.033 * found[found[:, 0] == BUBBLE, 1]).tolist()
    world.state.tick = tick
    drawn = slots(foot, rate, size, 0).astype(float)
    expected = [t for m, p in drawn[:, 4:6] for t in np.arange(m, 1199 * 0.033, p) if t >= 0.0]
    assert len(times) > 200
    assert np.sort(times) == pytest.approx(np.sort(expected), abs=1e-4)
