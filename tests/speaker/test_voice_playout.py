"""From packets to sound: speech is played whatever was lost or damaged on the way."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples
from tests.speaker.spoken import loudest_hz, packets, tone

from wax.speaker.voice_playout import VoicePlayout
from wax.voice.limiter import CEILING
from wax.voice.packet import MAX_SAMPLES, RATE_HZ, VoicePacket

if TYPE_CHECKING:
    from numpy.typing import NDArray


def said(
    spoken: list[VoicePacket], playout: VoicePlayout | None = None, *, from_s: float = 100.0
) -> NDArray[np.int16]:
    """Push packets as they are spoken; return everything that is played."""
    playout = playout or VoicePlayout()
    pieces: list[NDArray[np.int16]] = []
    for packet in spoken:
        now_s = from_s + packet.timestamp / RATE_HZ
        playout.push(packet, now_s)
        pieces += playout.pop_due(now_s + 0.015)
    pieces += playout.pop_due(now_s + 0.5)
    return np.concatenate([np.zeros(0, np.int16), *pieces])


@pytest.mark.parametrize("unit_ms", [10, 20, 40, 60])
def test_what_is_said_is_played(unit_ms: int) -> None:
    """A tone of a second is played with its pitch, length and level."""
    sound = said(packets(tone(440, 1.0), unit_ms=unit_ms))
    assert len(sound) == pytest.approx(RATE_HZ, abs=0.13 * RATE_HZ)
    middle = sound[RATE_HZ // 4 : RATE_HZ // 4 + 24_000]
    assert loudest_hz(middle) == pytest.approx(440, abs=3)
    assert np.abs(middle.astype(int)).max() == pytest.approx(3277, rel=0.25)


def test_what_is_lost_is_made_up() -> None:
    """With every tenth packet lost there is no gap in a tone."""
    spoken = packets(tone(440, 2.0))
    kept = [one for n, one in enumerate(spoken) if n % 10 != 9]
    playout = VoicePlayout()
    sound = said(kept, playout)
    assert playout.lost_samples == 9 * 960
    blocks = sound[4800:81_600].astype(np.float64).reshape(-1, 960)
    assert np.sqrt(np.mean(blocks**2, axis=1)).min() > 600


def test_a_pause_is_no_loss() -> None:
    """Concealment after the last word does not count as loss."""
    playout = VoicePlayout()
    words = packets(tone(440, 0.2))
    for word in range(3):
        later = [replace(one, timestamp=one.timestamp + word * RATE_HZ // 2) for one in words]
        assert len(said(later, playout)) > RATE_HZ // 5
    assert playout.lost_samples == 0


def test_silence_is_not_played() -> None:
    """An open microphone in a quiet room leaves the speaker silent."""
    assert len(said(packets(np.zeros(RATE_HZ, np.int16)))) == 0


def test_full_scale_is_limited() -> None:
    """Noise at full scale is played below the ceiling, no louder than speech."""
    noise = np.random.default_rng(1).integers(-32_768, 32_768, RATE_HZ).astype(np.int16)
    sound = said(packets(noise)).astype(np.float64)
    assert np.abs(sound).max() <= CEILING
    assert np.sqrt(np.mean(sound**2)) < 3300


def test_the_next_speaker_is_not_heard_through_the_one_before() -> None:
    """Another source discards the last one's packets, and its own first word is complete."""
    playout = VoicePlayout()
    for packet in packets(tone(440, 0.1)):
        playout.push(packet, 100.0)
    sound = said(packets(tone(1000, 0.5), source=2), playout)
    assert loudest_hz(sound[:9600]) == pytest.approx(1000, abs=10)


def test_hushed_it_is_silent_at_once() -> None:
    """After a hush nothing that had arrived is played."""
    playout = VoicePlayout()
    for packet in packets(tone(440, 0.2)):
        playout.push(packet, 100.0)
    playout.hush()
    assert playout.pop_due(101.0) == []
    assert playout.is_idle


@examples(100)
@given(st.lists(st.binary(min_size=1, max_size=60), min_size=1, max_size=20))
def test_garbage_is_made_up_for(payloads: list[bytes]) -> None:
    """Undecodable packets are counted and concealed, never louder than the limit."""
    playout = VoicePlayout()
    good = packets(tone(440, 0.2))
    bad = [
        replace(good[0], timestamp=9600 + n * 960, payload=payload)
        for n, payload in enumerate(payloads)
    ]
    sound = said(good + bad, playout)
    assert len(sound) <= (len(good) + len(bad)) * MAX_SAMPLES
    assert np.abs(sound.astype(int)).max() <= CEILING
