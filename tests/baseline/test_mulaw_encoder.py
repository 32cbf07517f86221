"""Sound of 2004: media units of µ-law that begin on an even grid and lose no sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.baseline.mulaw_encoder import MULAW_RATE_HZ, MuLawEncoder
from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ, Sound

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.encode.encoded import SoundUnit

BLOCK_S = BLOCK_SAMPLES / SAMPLE_RATE_HZ


def _feed(encoder: MuLawEncoder, samples: NDArray[np.float64], begin_s: float) -> list[SoundUnit]:
    units = []
    for number, at in enumerate(range(0, len(samples) - BLOCK_SAMPLES + 1, BLOCK_SAMPLES)):
        block = Sound(samples[at : at + BLOCK_SAMPLES].astype(np.int16), begin_s + number * BLOCK_S)
        if (unit := encoder.encode(block)) is not None:
            units.append(unit)
    return units


def _decode(units: list[SoundUnit]) -> NDArray[np.int16]:
    decoder = av.CodecContext.create("pcm_mulaw", "r")
    assert isinstance(decoder, av.AudioCodecContext)
    decoder.sample_rate = MULAW_RATE_HZ
    decoder.layout = "mono"
    sounds = [sound for unit in units for sound in unit.packets]
    frames = [frame for one in sounds for frame in decoder.decode(av.Packet(one.data))]
    return np.concatenate([frame.to_ndarray().reshape(-1) for frame in frames])


@pytest.mark.parametrize(("mu_ms", "packet_ms"), [(100, 100), (140, 20), (320, 80), (500, 100)])
def test_a_unit_is_whole_and_ready_with_its_last_sample(mu_ms: int, packet_ms: int) -> None:
    """After exactly `mu_ms` of sound there is a unit of a few packets with their own times."""
    encoder = MuLawEncoder(mu_ms=mu_ms)
    units = _feed(encoder, np.zeros(SAMPLE_RATE_HZ * mu_ms * 2 // 1000), 100.0)
    assert [unit.number for unit in units] == [1, 2]
    for unit in units:
        assert len(unit.packets) == mu_ms // packet_ms
        assert {len(sound.data) for sound in unit.packets} == {8 * packet_ms}
        assert unit.packets[0].pts % encoder.unit_samples == 0
    pts = [sound.pts for unit in units for sound in unit.packets]
    assert set(np.diff(pts)) == {8 * packet_ms}


def test_what_is_heard_was_captured_when_it_says() -> None:
    """A click is heard at its packet's capture time within half a millisecond."""
    sound = np.zeros(SAMPLE_RATE_HZ)
    click_s = 0.3141
    sound[round(click_s * SAMPLE_RATE_HZ)] = 30_000
    units = _feed(MuLawEncoder(mu_ms=500), sound, 100.0)
    heard_s = int(np.argmax(np.abs(_decode(units).astype(int)))) / MULAW_RATE_HZ
    assert units[0].captured_s + heard_s == pytest.approx(100 + click_s, abs=0.0005)


def test_speech_keeps_its_level_and_no_sample_is_lost() -> None:
    """A tone within the telephone band keeps its level, without a seam between units."""
    time_s = np.arange(SAMPLE_RATE_HZ * 2) / SAMPLE_RATE_HZ
    heard = _decode(_feed(MuLawEncoder(mu_ms=200), 8000 * np.sin(2 * np.pi * 440 * time_s), 5.0))
    assert len(heard) == 2 * MULAW_RATE_HZ
    middle = heard[400:].astype(float)
    assert np.sqrt(np.mean(middle**2)) == pytest.approx(8000 / np.sqrt(2), rel=0.03)
    spectrum = np.abs(np.fft.rfft(middle * np.hanning(len(middle))))
    peak = int(np.argmax(spectrum))
    elsewhere = np.delete(spectrum, range(peak - 8, peak + 9))
    assert elsewhere.max() < spectrum.max() / 50


@given(jump_s=st.floats(-30, 30).filter(lambda s: abs(s) > 0.1), parts=st.integers(1, 80))
def test_after_a_jump_units_stay_on_the_grid_and_time_never_returns(
    jump_s: float, parts: int
) -> None:
    """A jump of the source costs the present unit, but neither order nor grid."""
    encoder = MuLawEncoder(mu_ms=100)
    silence = np.zeros(BLOCK_SAMPLES * parts)
    units = _feed(encoder, silence, 1000.0)
    units += _feed(encoder, np.zeros(BLOCK_SAMPLES * 10), 1000.0 + parts * BLOCK_S + jump_s)
    pts = [sound.pts for unit in units for sound in unit.packets]
    assert pts == sorted(set(pts))
    assert all(unit.packets[0].pts % encoder.unit_samples == 0 for unit in units)
    assert len(units) == parts // 10 + 1
    assert [unit.number for unit in units] == list(range(1, len(units) + 1))
