"""The speaker thread plays, discards on request, and survives a device that fails or hangs."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import pytest
from structlog.testing import capture_logs
from tests.speaker.spoken import packets, tone
from tests.until import until

from wax import device_thread
from wax.clock import SystemClock
from wax.errors import SpeakerError
from wax.sentence import Sentence, says
from wax.speaker.speaker_thread import SpeakerThread
from wax.voice.packet import RATE_HZ

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np
    from numpy.typing import NDArray

CLOCK = SystemClock()


class Box:
    """A speaker that records what it is given, and fails or hangs when told to."""

    def __init__(self) -> None:
        self.kept: list[NDArray[np.int16]] = []
        self.opened = self.closed = 0
        self.failing: Exception | None = None
        self.fails_to_open: Exception | None = None
        self.free = threading.Event()
        self.free.set()

    def open(self) -> None:
        self.opened += 1
        if self.fails_to_open is not None:
            raise self.fails_to_open

    def write(self, samples: NDArray[np.int16]) -> None:
        self.free.wait()
        if self.failing is not None:
            raise self.failing
        self.kept.append(samples)

    def close(self) -> None:
        self.closed += 1

    @property
    def samples(self) -> int:
        return sum(map(len, self.kept))


@pytest.fixture
def box() -> Box:
    return Box()


@pytest.fixture
def thread(box: Box, monkeypatch: pytest.MonkeyPatch) -> Iterator[SpeakerThread]:
    monkeypatch.setattr(device_thread, "_RETRY_S", 0.01)
    made = SpeakerThread(box, CLOCK)
    made.start()
    yield made
    box.free.set()
    made.stop()
    made.stop()
    assert box.closed >= box.opened


def speak(thread: SpeakerThread, seconds: float = 0.4) -> None:
    """Push all packets at once, as after a stall."""
    for packet in packets(tone(440, seconds)):
        thread.push(packet, CLOCK.now_s())


def test_a_voice_is_played(thread: SpeakerThread, box: Box) -> None:
    """The whole voice is played, except for the final fade, and then the thread idles."""
    until(lambda: thread.problem is None)
    assert thread.sounded_s < CLOCK.now_s() - 1000
    speak(thread)
    until(lambda: box.samples >= 0.3 * RATE_HZ)
    assert CLOCK.now_s() - thread.sounded_s < 5
    until(lambda: thread._playout.is_idle)


def test_hushed_no_more_is_played(thread: SpeakerThread, box: Box) -> None:
    """Not even the pieces that were waiting for a busy device are played."""
    until(lambda: thread.problem is None)
    box.free.clear()
    speak(thread)
    until(lambda: thread._busy_since_s is not None)
    thread.hush()
    box.free.set()
    until(lambda: thread._playout.is_idle and thread._busy_since_s is None)
    assert len(box.kept) <= 1


def test_a_device_that_hangs_is_said(
    thread: SpeakerThread, box: Box, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While a device hangs, `push`, `hush` and `problem` return at once; then it plays again."""
    monkeypatch.setattr(thread, "_hangs_after_s", 0.05)
    until(lambda: thread.problem is None)
    box.free.clear()
    speak(thread)
    until(lambda: thread.problem is not None)
    assert thread.problem == Sentence("speaker.hangs")
    speak(thread, 3)
    thread.hush()
    box.free.set()
    until(lambda: thread.problem is None)


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (SpeakerError("The speaker has gone; plug it in again."), "The speaker has gone"),
        (RuntimeError("no bus"), "The robot's speaker failed: no bus"),
    ],
)
def test_a_device_that_fails_is_opened_again(
    thread: SpeakerThread, box: Box, error: Exception, sentence: str
) -> None:
    """The problem is shown until it plays again, whatever a plug-in raised."""
    until(lambda: thread.problem is None)
    with capture_logs():
        box.failing = box.fails_to_open = error
        speak(thread)
        until(lambda: thread.problem is not None)
        assert str(thread.problem).startswith(sentence)
        box.failing = box.fails_to_open = None
        until(lambda: thread.problem is None)
    assert thread.failures >= 1
    assert box.opened >= 2


def test_a_speaker_that_cannot_be_opened_is_a_sentence(
    box: Box, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Failing to open is a sentence, and stopping does not wait for the speaker."""
    box.fails_to_open = SpeakerError("No speaker.")
    monkeypatch.setattr(device_thread, "_RETRY_S", 60.0)
    thread = SpeakerThread(box, CLOCK)
    assert thread.problem is not None
    thread.start()
    until(lambda: thread.problem == says("No speaker."))
    thread.stop()
