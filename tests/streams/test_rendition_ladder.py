"""The ladders of renditions and encodings."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config.audio import AudioSettings, SoundEncodingSettings
from wax.config.video import RenditionSettings, VideoSettings
from wax.congestion.allocation import SoundEncoding
from wax.streams.rendition_ladder import RenditionLadder, refined

LADDER = RenditionLadder(VideoSettings(), AudioSettings())


def test_the_shared_ladder_is_the_configurations() -> None:
    """The shared ladder is the configured one, in its order, with VP8's layers."""
    steps = LADDER.steps(is_finer=False)
    assert [step.name for step in steps] == [one.name for one in VideoSettings().renditions]
    assert {step.layers for step in steps} == {2}
    assert {
        step.layers
        for step in RenditionLadder(VideoSettings(codec="h264"), AudioSettings())._shared
    } == {0}


def test_the_finer_ladder_can_be_encoded() -> None:
    """The finer ladder contains the shared one, and every step has settings."""
    finer = LADDER.steps(is_finer=True)
    assert set(LADDER.steps(is_finer=False)) < set(finer)
    assert [LADDER.settings(step.name).bitrate_bps for step in finer] == [
        one.bitrate_bps for one in finer
    ]


@given(st.lists(st.integers(10_000, 20_000_000), min_size=1, max_size=8, unique=True))
def test_a_refined_ladder_falls_and_keeps_its_steps(rates: list[int]) -> None:
    """A refined ladder's rates fall, keep all steps, and have no wide gap."""
    ladder = [
        RenditionSettings(width=64, height=48, fps=10, bitrate_bps=rate)
        for rate in sorted(rates, reverse=True)
    ]
    fine = refined(ladder)
    assert [one for one in fine if one in ladder] == ladder
    for above, below in pairwise(fine):
        assert above.bitrate_bps > below.bitrate_bps
    assert len(fine) <= 2 * len(ladder) - 1


@pytest.mark.parametrize(
    ("least", "expected"),
    [(10, [10, 10, 20, 20, 40, 40, 60, 120]), (40, [40, 40, 60, 120]), (120, [120])],
)
def test_a_role_may_have_only_longer_units(least: int, expected: list[int]) -> None:
    """Encodings with shorter units are left out, but the longest always stays."""
    assert [encoding.mu_ms for encoding in LADDER.encodings(least)] == expected
    short = AudioSettings(encodings=[SoundEncodingSettings(mu_ms=20, bitrate_bps=32_000)])
    ladder = RenditionLadder(VideoSettings(), short)
    assert ladder.encodings(120) == ladder.encodings(10)


def test_a_fixed_unit_has_the_rate_of_its_neighbour() -> None:
    """A configured media unit has the rate of the nearest encoding."""
    assert LADDER.encodings_of(40) == [SoundEncoding(40, 40_000, 2), SoundEncoding(40, 24_000)]
    assert LADDER.encodings_of(120) == [SoundEncoding(120, 8_000)]


def test_one_channel_has_no_encoding_in_stereo() -> None:
    """With `channels = 1` or without a stereo rate all encodings are mono."""
    mono = RenditionLadder(VideoSettings(), AudioSettings(channels=1))
    assert {encoding.channels for encoding in mono.encodings(10)} == {1}
    own = [SoundEncodingSettings(mu_ms=20, bitrate_bps=32_000)]
    assert RenditionLadder(VideoSettings(), AudioSettings(encodings=own)).encodings(10) == [
        SoundEncoding(20, 32_000)
    ]
