"""The sound encoder and its clock: whole units on a grid, with level and rate kept."""

from __future__ import annotations

import itertools
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.encode.decoders import decoded_sound

from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ, Sound
from wax.congestion.allocation import SoundEncoding
from wax.encode.sample_clock import SampleClock
from wax.encode.sound_encoder import SoundEncoder
from wax.robot.simulated.radio import tune

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.encode.encoded import EncodedSound

TIME_S = np.arange(SAMPLE_RATE_HZ * 3) / SAMPLE_RATE_HZ
TONE = 0.05 * 32767 * np.sin(2 * np.pi * 300 * TIME_S)
RADIO = 8000 * tune()[0][: len(TIME_S)] / np.abs(tune()[0]).max()
ENCODINGS = [
    SoundEncoding(10, 64_000),
    SoundEncoding(20, 32_000),
    SoundEncoding(40, 24_000),
    SoundEncoding(20, 16_000),
    SoundEncoding(60, 12_000),
    SoundEncoding(120, 8_000),
]


@cache
def _voice() -> NDArray[np.float64]:
    """Generate pulses of 120 Hz with formants and syllables, over some hiss."""
    frequency_hz = np.fft.rfftfreq(len(TIME_S), 1 / SAMPLE_RATE_HZ)
    pulses = np.diff(np.floor(np.cumsum(120 + 15 * np.sin(4 * TIME_S)) / SAMPLE_RATE_HZ), prepend=0)
    mouth = sum(
        gain / (1 + ((frequency_hz - centre_hz) / width_hz) ** 2)
        for centre_hz, width_hz, gain in ((600, 80, 1.0), (1200, 90, 0.6), (2600, 120, 0.3))
    )
    voiced = np.fft.irfft(np.fft.rfft(pulses) * mouth, len(TIME_S))
    loudness = 0.5 * (1 + np.sin(2 * np.pi * 3 * TIME_S))
    hiss = np.random.default_rng(1).normal(0, 0.01, len(TIME_S))
    voice = voiced / np.abs(voiced).max() * loudness + hiss * (1 - loudness)
    return np.asarray(0.3 * 32767 * voice)


def _encode(
    encoding: SoundEncoding, samples: NDArray[np.float64], first_pts: int = 0
) -> list[EncodedSound]:
    encoder = SoundEncoder(encoding)
    found = []
    for begin in range(0, len(samples) - BLOCK_SAMPLES + 1, BLOCK_SAMPLES):
        block = samples[begin : begin + BLOCK_SAMPLES].astype(np.int16)
        one = encoder.encode(Sound(block, 10 + begin / SAMPLE_RATE_HZ), first_pts + begin)
        if one is not None:
            found.append(one)
    return found


@cache
def _encoded(encoding: SoundEncoding, what: str) -> list[EncodedSound]:
    return _encode(encoding, {"tone": TONE, "voice": _voice()}[what])


STEREO = [SoundEncoding(20, 56_000, 2), SoundEncoding(40, 40_000, 2)]


def _heard(encoding: SoundEncoding, both: NDArray[np.int16]) -> tuple[NDArray[np.float64], float]:
    """Encode and decode 3 s of two channels, ``(n, 2)``; return the last second and the rate."""
    encoder, sounds = SoundEncoder(encoding), []
    for begin in range(0, len(both), BLOCK_SAMPLES):
        block = Sound(both[begin : begin + BLOCK_SAMPLES], begin / SAMPLE_RATE_HZ)
        if (one := encoder.encode(block, begin)) is not None:
            sounds.append(one)
    heard = decoded_sound(sounds, "stereo").reshape(-1, 2)[-SAMPLE_RATE_HZ:]
    return heard, sum(len(one.data) for one in sounds) * 8 / 3


@pytest.mark.parametrize("encoding", STEREO)
def test_two_channels_stay_apart(encoding: SoundEncoding) -> None:
    """Different tones left and right come back on their sides, 20 dB apart."""
    left, right = (
        np.round(4000 * np.sin(2 * np.pi * hertz * TIME_S)).astype(np.int16) for hertz in (500, 700)
    )
    heard, bitrate_bps = _heard(encoding, np.column_stack((left, right)))
    tones = np.abs(np.fft.rfft(heard * np.hanning(len(heard))[:, None], axis=0))
    assert tones[500, 0] > 10 * tones[500, 1]
    assert tones[700, 1] > 10 * tones[700, 0]
    assert bitrate_bps < 1.1 * encoding.bitrate_bps


@pytest.mark.parametrize("encoding", STEREO)
@pytest.mark.parametrize("later", [-24, 8])
def test_a_sound_is_heard_where_it_is(encoding: SoundEncoding, later: int) -> None:
    """The delay between the ears is kept to 60 µs, or 7°."""
    both = np.column_stack((RADIO, 0.6 * np.roll(RADIO, later))).astype(np.int16)
    near, far = _heard(encoding, both)[0].T
    alike = [np.dot(near[40:-40], np.roll(far, -n)[40:-40]) for n in range(-40, 41)]
    assert abs(np.argmax(alike) - 40 - later) <= 3


@pytest.mark.parametrize("channels", [1, 2])
def test_any_sound_fits_any_form(channels: int) -> None:
    """Mono plays in both ears of a stereo encoding, and stereo is mixed to mono, equally loud."""
    mono = np.round(TONE[:SAMPLE_RATE_HZ]).astype(np.int16)
    encoder, sounds = SoundEncoder(SoundEncoding(20, 56_000, channels)), []
    for begin in range(0, len(mono), BLOCK_SAMPLES):
        block = Sound(mono[begin : begin + BLOCK_SAMPLES], 1.0).with_channels(3 - channels)
        if (one := encoder.encode(block, begin)) is not None:
            sounds.append(one)
    heard = decoded_sound(sounds)[SAMPLE_RATE_HZ // 4 :]
    assert np.std(heard) == pytest.approx(np.std(mono), rel=0.03)


def _level_db(samples: NDArray[np.float64]) -> float:
    return float(10 * np.log10(np.mean(samples**2)))


def _bands(samples: NDArray[np.float64]) -> list[float]:
    power = np.abs(np.fft.rfft(samples * np.hanning(len(samples)))) ** 2
    frequency_hz = np.fft.rfftfreq(len(samples), 1 / SAMPLE_RATE_HZ)
    edges = ((80, 400), (400, 1000), (1000, 3000))
    return [
        float(10 * np.log10(power[(frequency_hz >= low) & (frequency_hz < high)].sum()))
        for low, high in edges
    ]


@pytest.mark.parametrize("encoding", ENCODINGS, ids=str)
def test_one_packet_holds_one_media_unit(encoding: SoundEncoding) -> None:
    """Each packet holds one media unit, follows the last, and none is lost."""
    found = _encoded(encoding, "tone")
    assert [one.pts for one in found] == [
        n * encoding.mu_ms * 48 for n in range(3000 // encoding.mu_ms)
    ]
    assert {one.duration_samples for one in found} == {encoding.mu_ms * 48}
    assert len(decoded_sound(found)) == len(TIME_S)


@pytest.mark.parametrize("encoding", ENCODINGS, ids=str)
def test_a_tone_comes_out_as_loud_and_clean(encoding: SoundEncoding) -> None:
    """A quiet tone of 300 Hz keeps its level within 0.5 dB, with 24 dB of signal to noise."""
    heard = decoded_sound(_encoded(encoding, "tone"))[SAMPLE_RATE_HZ:]
    assert _level_db(heard) == pytest.approx(_level_db(TONE), abs=0.5)
    power = np.abs(np.fft.rfft(heard * np.hanning(len(heard)))) ** 2
    tone = np.abs(np.fft.rfftfreq(len(heard), 1 / SAMPLE_RATE_HZ) - 300) < 15
    assert 10 * np.log10(power[tone].sum() / power[~tone].sum()) > 24


@pytest.mark.parametrize("encoding", ENCODINGS, ids=str)
def test_a_voice_keeps_its_colour(encoding: SoundEncoding) -> None:
    """The bands that make speech intelligible keep their level within 1.5 dB."""
    voice = _voice()
    heard = decoded_sound(_encoded(encoding, "voice"))
    expected = _bands(voice[SAMPLE_RATE_HZ:])
    assert _bands(heard[SAMPLE_RATE_HZ:]) == pytest.approx(expected, abs=1.5)


@pytest.mark.parametrize("encoding", ENCODINGS, ids=str)
@pytest.mark.parametrize("what", ["tone", "voice"])
def test_the_rate_is_kept(encoding: SoundEncoding, what: str) -> None:
    """No encoding exceeds the ladder's rate, and on a slow link no packet does."""
    sizes = [len(one.data) for one in _encoded(encoding, what)]
    whole = encoding.bitrate_bps * encoding.mu_ms // 8000
    assert np.mean(sizes) <= whole * 1.05
    if encoding.bitrate_bps < 20_000:
        assert max(sizes) <= whole


@pytest.mark.parametrize("encoding", ENCODINGS, ids=str)
def test_what_is_heard_was_captured_when_it_says(encoding: SoundEncoding) -> None:
    """A click is heard at its packet's capture time within half a millisecond."""
    samples = np.zeros(len(TIME_S))
    click = round(1.2345 * SAMPLE_RATE_HZ)
    samples[click : click + 24] = 20_000
    found = _encode(encoding, samples)
    heard = int(np.argmax(np.abs(decoded_sound(found)))) / SAMPLE_RATE_HZ
    assert found[0].captured_s + heard == pytest.approx(
        10 + (click + 12) / SAMPLE_RATE_HZ, abs=0.0005
    )


@given(first=st.integers(0, 10**9), lost=st.lists(st.integers(0, 59), max_size=5))
def test_units_stay_on_the_grid_whatever_is_missing(first: int, lost: list[int]) -> None:
    """Every unit begins at a whole multiple of its length and has no gap inside."""
    encoder = SoundEncoder(SoundEncoding(40, 24_000))
    silence = np.zeros(BLOCK_SAMPLES, np.int16)
    numbers = [first + n for n in range(60) if n not in lost]
    found = [
        one
        for number in numbers
        if (one := encoder.encode(Sound(silence, number / 100), number * BLOCK_SAMPLES))
    ]
    whole = [n for n in numbers if n % 4 == 0 and {n + 1, n + 2, n + 3} <= set(numbers)]
    assert [one.pts for one in found] == [n * BLOCK_SAMPLES for n in whole]


@given(
    start_s=st.floats(1, 1e7),
    jitter_s=st.lists(st.floats(-0.02, 0.02), min_size=30, max_size=30),
    slope=st.floats(0.995, 1.005),
)
def test_jitter_and_drift_of_the_capture_leave_no_seam(
    start_s: float, jitter_s: list[float], slope: float
) -> None:
    """Neither jitter of capture times nor drift of a sound card reaches the RTP clock."""
    clock = SampleClock()
    pts = [clock.stamp(start_s + n * 0.01 * slope + late) for n, late in enumerate(jitter_s)]
    assert {b - a for a, b in itertools.pairwise(pts)} == {BLOCK_SAMPLES}
    assert pts[0] == pytest.approx((start_s + jitter_s[0]) * 48_000, abs=BLOCK_SAMPLES / 2 + 1)


def test_six_minutes_of_drift_are_no_gap() -> None:
    """A sound card that is 300 ppm slow is 0.1 s off after six minutes, without a jump."""
    clock = SampleClock()
    first = clock.stamp(0.0)
    for number in range(1, 36_000):
        clock.stamp(number * 0.01 * 1.0003)
    assert clock.next_pts - first == 36_000 * BLOCK_SAMPLES


@given(st.lists(st.floats(-1e6, 1e6), min_size=2))
def test_time_never_goes_back(captured_s: list[float]) -> None:
    """Whatever the capture times, media time rises in whole blocks."""
    clock = SampleClock()
    pts = [clock.stamp(one) for one in captured_s]
    assert all(b > a and (b - a) % BLOCK_SAMPLES == 0 for a, b in itertools.pairwise(pts))


def test_a_real_gap_moves_the_clock() -> None:
    """A microphone's gap of a second moves the RTP time by a second."""
    clock = SampleClock()
    first, second = clock.stamp(10.0), clock.stamp(11.01)
    assert second - first == BLOCK_SAMPLES + 48_000
