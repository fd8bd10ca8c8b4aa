"""Loudness and true peak by ITU-R BS.1770, and by ffmpeg's filter ebur128."""

import re
from contextlib import suppress
from fractions import Fraction

import av
import av.logging
import numpy as np
from scipy.signal import lfilter, resample_poly

RATE = 48_000
# BS.1770-4, tables 1 and 2: the head as a sphere, and a high-pass.
SHELF = ([1.53512485958697, -2.69169618940638, 1.19839281085285],
         [1.0, -1.69065929318241, 0.73248077421585])  # fmt: skip
HIGH_PASS = [1.0, -2.0, 1.0], [1.0, -1.99004745483398, 0.99007225036621]
# Table 3: weights of channels; those 60° to 120° aside count more, low frequencies not at all.
WEIGHTS = {
    "mono": (1.0,),
    "stereo": (1.0, 1.0),
    "quad": (1.0, 1.0, 1.41, 1.41),
    "5.1": (1.0, 1.0, 1.0, 0.0, 1.41, 1.41),
    "7.1": (1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.41, 1.41),
}


def loudness(samples, layout="stereo"):
    """Integrated loudness of samples (n, c), LUFS."""
    weighted = lfilter(*HIGH_PASS, lfilter(*SHELF, samples, axis=0), axis=0)
    block, step = round(0.4 * RATE), round(0.1 * RATE)
    total = np.cumsum(np.vstack([np.zeros(samples.shape[1]), weighted**2]), axis=0)
    starts = np.arange(0, len(samples) - block + 1, step)
    power = (total[starts + block] - total[starts]) / block @ np.array(WEIGHTS[layout])
    level = -0.691 + 10.0 * np.log10(power + 1e-12)
    power, level = power[level > -70.0], level[level > -70.0]
    if not len(power):
        return -np.inf
    kept = level > -0.691 + 10.0 * np.log10(power.mean()) - 10.0
    return float(-0.691 + 10.0 * np.log10(power[kept].mean()))


def true_peak(samples):
    """The true peak of samples (n, c), dB, four times oversampled."""
    most = np.abs(resample_poly(samples.astype(np.float64), 4, 1, axis=0)).max()
    return float(20.0 * np.log10(max(most, 1e-9)))


def by_ffmpeg(samples, layout="stereo"):
    """Integrated loudness, LUFS, and true peak, dB, by the summary of ffmpeg's filter."""
    graph = av.filter.Graph()
    source = graph.add_abuffer(
        sample_rate=RATE, format="flt", layout=layout, time_base=Fraction(1, RATE)
    )
    meter = graph.add("ebur128", "peak=true:framelog=quiet")
    sink = graph.add("abuffersink")
    source.link_to(meter)
    meter.link_to(sink)
    graph.configure()
    before = av.logging.get_level()
    av.logging.set_level(av.logging.INFO)
    try:
        with av.logging.Capture() as lines:
            words = np.ascontiguousarray(samples, np.float32).reshape(1, -1)
            frame = av.AudioFrame.from_ndarray(words, format="flt", layout=layout)
            frame.sample_rate, frame.pts, frame.time_base = RATE, 0, Fraction(1, RATE)
            source.push(frame)
            source.push(None)
            with suppress(av.error.EOFError):
                while True:
                    sink.pull()
            del source, meter, sink, graph  # it reports at its end
    finally:
        av.logging.set_level(before)
    text = "".join(line for _, _, line in lines)
    return (float(re.findall(r"I:\s+(\S+) LUFS", text)[-1]),
            float(re.findall(r"Peak:\s+(\S+) dBFS", text)[-1]))  # fmt: skip
