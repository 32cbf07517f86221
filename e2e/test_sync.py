"""The audio-master policy: sound keeps its delay, the picture keeps to the sound."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING

import pytest

from e2e.harness import ear, toml
from e2e.harness.eye import assert_live
from e2e.harness.viewer import EARS
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

TOLERANCE_MS = 40.0
"""The issue's promise: a chosen delay is followed within it, both streams."""

HELD_MS = 80.0
"""More than any browser holds a picture back by itself, less than 200 ms of sound need."""

SOUND_EARLY_MS, SOUND_LATE_MS = 45.0, 125.0
"""ITU-R BT.1359: skew that people begin to detect."""


@dataclass(frozen=True, slots=True)
class JitterBuffer:
    """Mean delay in the browser's jitter buffer, and the least that the arrival allows."""

    delay_ms: float
    least_ms: float


async def jitter_buffer(viewer: Viewer, kind: str, over_s: float = 1.0) -> JitterBuffer:
    """Measure during the next `over_s`."""

    async def started() -> bool:
        return "jitterBufferDelay" in await viewer.inbound(kind)

    await eventually(started, f"{kind} arrives")
    first = await viewer.inbound(kind)
    await asyncio.sleep(over_s)
    last = await viewer.inbound(kind)
    count = last["jitterBufferEmittedCount"] - first["jitterBufferEmittedCount"]
    assert count > 0, f"no {kind} came out of the jitter buffer"

    def mean_ms(name: str) -> float:
        return float((last[name] - first[name]) / count * 1000)

    return JitterBuffer(mean_ms("jitterBufferDelay"), mean_ms("jitterBufferMinimumDelay"))


@pytest.mark.timeout(120)
@pytest.mark.parametrize(
    "delay_ms",
    [pytest.param(20, marks=pytest.mark.full), 200, pytest.param(500, marks=pytest.mark.full)],
)
async def test_a_chosen_delay_is_followed_by_both_streams(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer, delay_ms: int
) -> None:
    """Sound and picture wait as long as `audio_delay_ms` says, ± 40 ms, and stay in step."""
    settings = toml.card_with(sync__observer=f"audio_delay_ms = {delay_ms}.0")
    async with serve(tmp_path, settings) as server:
        viewer = await open_viewer(server, **EARS)
        await viewer.listen()
        measured = ""

        async def follows() -> bool:
            nonlocal measured
            sound, picture = await asyncio.gather(
                jitter_buffer(viewer, "audio"), jitter_buffer(viewer, "video")
            )
            measured = f"{sound}, {picture}"
            # On a busy machine sound arrives so unevenly that less would break it.
            wanted_ms = max(delay_ms, sound.least_ms)
            return all(
                abs(buffer.delay_ms - wanted_ms) <= TOLERANCE_MS for buffer in (sound, picture)
            )

        try:
            await eventually(follows, "both streams wait as long as was chosen", within_s=12)
        finally:
            print(f"chosen {delay_ms} ms: {measured}")
        skew_ms = await measured_skew_ms(viewer)
        print(f"chosen {delay_ms} ms: skew {skew_ms:+.0f} ms (sound late is positive)")
        assert -SOUND_EARLY_MS <= skew_ms <= SOUND_LATE_MS


async def measured_skew_ms(viewer: Viewer) -> float:
    """How much later than the picture the sound comes to the ear, by the test card of both."""
    await asyncio.sleep(2)
    await viewer.forget()
    cards = await viewer.cards(90)
    await asyncio.sleep(1)
    sound_ms = median(ear.burst_ages_ms(await viewer.heard())) + await viewer.device_ms()
    picture_ms = median(card.age_ms for card in cards if card.valid)
    return sound_ms - picture_ms


@pytest.mark.timeout(90)
async def test_by_default_the_delay_is_small(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """As shipped, an observer on a good line hears and sees within a quarter of a second."""
    async with serve(tmp_path, toml.CARD) as server:
        viewer = await open_viewer(server, **EARS)
        await viewer.listen()
        skew_ms = await measured_skew_ms(viewer)
        ages = [card.age_ms for card in await viewer.cards(30) if card.valid]
        print(f"default: picture {median(ages):.0f} ms old, skew {skew_ms:+.0f} ms")
        assert median(ages) < 250
        assert -SOUND_EARLY_MS <= skew_ms <= SOUND_LATE_MS


@pytest.mark.timeout(90)
async def test_the_delay_follows_the_role(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """At hand-over the operator's delay applies at once, without a new connection."""
    settings = toml.card_with(sync__observer="audio_delay_ms = 400.0")
    async with serve(tmp_path, settings) as server:
        viewer = await open_viewer(server, **EARS)
        await viewer.listen()

        async def waits() -> bool:
            return (await jitter_buffer(viewer, "video")).delay_ms > 300

        await eventually(waits, "the observer's picture waits", within_s=12)
        peers = await viewer.probe("peers()")
        await viewer.join()
        await viewer.drives()

        async def hurries() -> bool:
            return (await jitter_buffer(viewer, "video")).delay_ms < 120

        await eventually(hurries, "the operator's picture hurries", within_s=8)
        assert await viewer.probe("peers()") == peers


@pytest.mark.timeout(90)
async def test_timing_is_switched_while_watching(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """Timing changes policy and hold-back at once: no new peer, black picture or gap in sound."""
    settings = toml.card_with(sync__observer="audio_delay_ms = 200.0")
    async with serve(tmp_path, settings) as server:
        viewer = await open_viewer(server, **EARS)
        await viewer.listen()
        await held_back(server, viewer, "audio-master", HELD_MS)
        await asyncio.sleep(2)  # until the sound's buffer has grown to what was chosen
        peers = await viewer.probe("peers()")
        await viewer.forget()
        for timing, policy, held_ms in (
            ("Picture first", "video-first", 0.0),
            ("In step", "audio-master", HELD_MS),
        ):
            cards, _ = await asyncio.gather(viewer.cards(60), viewer.timing.select_option(timing))
            assert_live(cards)
            await held_back(server, viewer, policy, held_ms)
        assert await viewer.probe("peers()") == peers
        blocks = await viewer.heard()
        assert ear.loudness(blocks) > 0.02
        assert sum(ear.gaps_ms(blocks)) <= 60, ear.gaps_ms(blocks)


async def held_back(server: Server, viewer: Viewer, policy: str, least_ms: float) -> None:
    """Wait until this policy holds the picture back by so much or more, by nothing for 0."""

    async def holds() -> bool:
        (line,) = (await server.status())["viewers"]
        streams = line["streams"]
        told_ms, kept_ms = (
            streams["picture_held_ms"],
            (await jitter_buffer(viewer, "video")).delay_ms,
        )
        as_told = told_ms >= least_ms if least_ms else told_ms == 0
        as_kept = kept_ms >= least_ms if least_ms else kept_ms < HELD_MS
        return streams["policy"] == policy and as_told and as_kept

    await eventually(holds, f"{policy} holds the picture back", within_s=10)
