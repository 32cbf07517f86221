"""Feeds one speaker in its own thread, and reopens it when it fails."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final

from wax.device_thread import DeviceThread
from wax.sentence import Sentence
from wax.speaker.voice_playout import VoicePlayout

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.speaker.interface import Speaker
    from wax.voice.packet import VoicePacket

_POLL_S: Final = 0.005
_AHEAD_S: Final = 0.015
"""Sound is written this long before it is due, so that the device never runs dry between polls."""
_IDLE_POLL_S: Final = 0.5
_HANGS_S: Final = 1.0


class SpeakerThread(DeviceThread):
    """Plays the packets that it is given as soon as they are due.

    `push`, `hush` and the properties never wait for the device.
    """

    def __init__(self, speaker: Speaker, clock: Clock) -> None:
        super().__init__(
            speaker,
            clock,
            name="speaker",
            problem=Sentence("speaker.opening"),
            hangs=Sentence("speaker.hangs"),
            hangs_after_s=_HANGS_S,
        )
        self._speaker = speaker
        self._playout = VoicePlayout()
        self._news = threading.Event()
        self._sounded_s = float("-inf")
        self._hushed = 0

    @property
    def sounded_s(self) -> float:
        """When sound other than silence was last played."""
        return self._sounded_s

    @property
    def lost_ms(self) -> int:
        """How much of the voices the network has lost since the start."""
        return self._playout.lost_samples // 48

    def push(self, packet: VoicePacket, now_s: float) -> None:
        """Enqueue a packet that arrives now."""
        with self._lock:
            self._playout.push(packet, now_s)
        self._news.set()

    def hush(self) -> None:
        """Discard every packet that has arrived, except for sound that the device has already."""
        with self._lock:
            self._playout.hush()
            self._hushed += 1

    def request_stop(self) -> None:
        super().request_stop()
        self._news.set()

    def _use(self) -> None:
        self._mark_working()
        while not self._stopping.is_set():
            self._news.clear()
            now_s = self._clock.now_s()
            with self._lock:
                pieces = self._playout.pop_due(now_s + _AHEAD_S)
                is_idle = self._playout.is_idle
                hushed = self._hushed
            for piece in pieces:
                if hushed != self._hushed:
                    break
                self._mark_busy()
                self._speaker.write(piece)
                self._mark_working()
                self._sounded_s = self._clock.now_s()
            if is_idle:
                self._news.wait(_IDLE_POLL_S)
            else:
                self._stopping.wait(_POLL_S)

    def _fail(self, sentence: Sentence) -> None:
        with self._lock:
            self._playout.hush()
        super()._fail(sentence)

    def _failed(self, why: str) -> Sentence:
        return Sentence("speaker.failed", {"why": why})
