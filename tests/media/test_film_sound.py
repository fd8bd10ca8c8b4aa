"""The sound of films: in step with the picture, repeatable, and optional."""

import wave

import av
import numpy as np
import pytest

from subsea.cli.main import main
from subsea.media.film_sound import write_wav
from subsea.sound.space import RATE
from tests.support.daily import only
from tests.support.loudness import true_peak
from tests.support.scenes import BARE

pytestmark = pytest.mark.usefixtures("one_context")

SEA = ["--scenario", str(BARE), "--size", "64x64", "--fps", "10", "--quality", "low", "--seed", "1"]
SECONDS = 1.5


def film(path, *more):
    assert main(["film", str(path), *SEA, "--seconds", str(SECONDS), *more]) == 0
    return path


def track_of(path):
    """The samples (n, c) of a film's sound, and its first time, s; None without a track."""
    with av.open(str(path)) as container:
        if not container.streams.audio:
            return None
        assert container.streams.audio[0].codec_context.name == "aac"
        assert container.streams.audio[0].rate == RATE
        packed = av.AudioResampler(format="flt")  # PyAV cannot read eight planes
        frames = [part for whole in container.decode(audio=0) for part in packed.resample(whole)]
    words = np.concatenate([frame.to_ndarray()[0] for frame in frames])
    return words.reshape(-1, frames[0].layout.nb_channels), frames[0].time


def read_wav(path):
    with wave.open(str(path)) as file:
        words = np.frombuffer(file.readframes(file.getnframes()), "<i2")
        return words.reshape(-1, file.getnchannels()) / 32767.0


def lag(heard, expected):
    """Samples by which a sound comes later than expected."""
    n = min(len(heard), len(expected))
    a, b = np.fft.rfft(heard[:n], 2 * n), np.fft.rfft(expected[:n], 2 * n)
    found = int(np.fft.irfft(a * b.conj()).argmax())
    return found if found < n else found - 2 * n


@pytest.fixture(scope="module")
def filmed(tmp_path_factory, request):
    request.getfixturevalue("one_context")
    folder = tmp_path_factory.mktemp("sound")
    more = ["--start", "0.5", "--audio", str(folder / "a.wav"), "--audio-stems", str(folder)]
    film(folder / "a.mp4", *more)
    return folder


def test_the_sound_is_in_step_with_the_film(filmed):
    heard, begin = track_of(filmed / "a.mp4")
    alone = read_wav(filmed / "a.wav")
    assert begin == 0.0
    assert heard.shape[1] == alone.shape[1] == 2
    assert len(alone) == SECONDS * RATE
    assert abs(lag(heard[:, 0], alone[:, 0])) < 0.001 * RATE


def test_stems_add_up_to_the_sound(filmed):
    parts = [read_wav(filmed / f"{name}.wav") for name in ("sea", "fishes", "vessel")]
    whole = read_wav(filmed / "a.wav")
    n = len(whole)
    assert 0.8 * sum(part[:n] for part in parts) == pytest.approx(whole, abs=3e-4)


def test_no_peak_of_a_film_or_its_stems_reaches_full_scale(filmed):
    names = "sea", "fishes", "vessel", "a"
    assert max(true_peak(read_wav(filmed / f"{name}.wav")) for name in names) < -1.0
    assert true_peak(track_of(filmed / "a.mp4")[0]) < -1.0


def test_a_later_start_hears_the_same_dive(filmed, tmp_path):
    film(tmp_path / "b.mp4", "--audio", str(tmp_path / "b.wav"))
    early, late = read_wav(tmp_path / "b.wav"), read_wav(filmed / "a.wav")
    shift = round(0.5 * RATE)
    assert (early[shift:] == late[: len(early) - shift]).all()


def test_the_same_film_has_the_same_bytes(filmed, tmp_path):
    again = film(tmp_path / "a.mp4", "--start", "0.5")
    assert again.read_bytes() == (filmed / "a.mp4").read_bytes()


def test_without_sound(tmp_path):
    assert track_of(film(tmp_path / "a.mp4", "--mute")) is None


@pytest.mark.parametrize(
    ("layout", "channels"), only([("7.1", 8)], [("7.1", 8), ("binaural", 2), ("quad", 4)])
)
def test_layouts(layout, channels, tmp_path):
    heard, _ = track_of(film(tmp_path / "a.mp4", "--sound-layout", layout))
    assert heard.shape[1] == channels


def test_a_film_of_all_round_keeps_its_marks_beside_the_sound(tmp_path):
    path = tmp_path / "a.mp4"
    film(path, "--display", "equirectangular", "--size", "128x64")
    assert b"sv3d" in path.read_bytes()
    heard, _ = track_of(path)
    assert np.abs(heard).max() > 0.0
    with av.open(str(path)) as container:
        assert len(list(container.decode(video=0))) == 15


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--sound-layout", "5.2"], "unknown layout '5.2'"),
        (["--audio", "{}/film.mp4"], "film.mp4"),
    ],
)
def test_faults_are_one_line(more, message, tmp_path, capsys):
    (tmp_path / "film.mp4").write_bytes(b"something else")
    more = [word.format(tmp_path) for word in more]
    assert main(["film", str(tmp_path / "b.mp4"), *SEA, "--seconds", "1", *more]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1
    assert not (tmp_path / "b.mp4").exists()


def test_a_wav_file(tmp_path):
    samples = np.array([[0.0, 1.0], [-1.0, 0.5]])
    write_wav(tmp_path / "a.wav", samples)
    with wave.open(str(tmp_path / "a.wav")) as file:
        assert (file.getnchannels(), file.getframerate(), file.getnframes()) == (2, RATE, 2)
        words = np.frombuffer(file.readframes(2), "<i2").reshape(2, 2)
    assert words == pytest.approx(np.array([[0, 32767], [-32767, 16384]]), abs=1)
