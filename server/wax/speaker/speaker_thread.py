"""Feeds one speaker in its own thread, and reopens it when it fails."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final

import structlog

from wax.errors import SpeakerError
from wax.sentence import Sentence
from wax.speaker.voice_playout import VoicePlayout

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.speaker.interface import Speaker
    from wax.voice.packet import VoicePacket

_LOG = structlog.get_logger(__name__)

_BEAT_S: Final = 0.005
_AHEAD_S: Final = 0.015
"""What is due so soon is written already, so that the device does not run dry between two beats."""
_LOOK_S: Final = 0.5
_HANGS_S: Final = 1.0
_STOP_S: Final = 1.0
_OPENING: Final = Sentence("speaker.opening")


class SpeakerThread:
    """Plays what it is given as soon as it is due.

    `push`, `hush` and the properties may be used from any thread and never wait for the device.
    Nothing here raises.
    """

    def __init__(self, speaker: Speaker, clock: Clock, *, retry_s: float) -> None:
        self._speaker = speaker
        self._clock = clock
        self._retry_s = retry_s
        self._lock = threading.Lock()
        self._playout = VoicePlayout()
        self._came = threading.Event()
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self._problem: Sentence | None = _OPENING
        self._busy_since_s: float | None = None
        self._sounded_s = float("-inf")
        self._hushed = 0
        self.failures = 0

    @property
    def problem(self) -> Sentence | None:
        """A sentence for people while nothing can be heard, else None.

        A device that hangs cannot say so itself; after a second it counts as failed.
        """
        with self._lock:
            since_s = self._busy_since_s
            hangs = since_s is not None and self._clock.now_s() - since_s > _HANGS_S
            if hangs and self._problem in (None, _OPENING):
                self._note(Sentence("speaker.hangs"))
            return self._problem

    @property
    def sounded_s(self) -> float:
        """When something was last played that is not silence."""
        return self._sounded_s

    @property
    def lost_ms(self) -> int:
        """How much of the voices was lost on the way since the start."""
        return self._playout.lost_samples // 48

    def push(self, packet: VoicePacket, now_s: float) -> None:
        """Have a packet played that has come now."""
        with self._lock:
            self._playout.push(packet, now_s)
        self._came.set()

    def hush(self) -> None:
        """Play nothing of what has come so far, but for what the device has already."""
        with self._lock:
            self._playout.hush()
            self._hushed += 1

    def start(self) -> None:
        # A daemon: a hung operating system driver must not keep the process alive.
        self._thread = threading.Thread(target=self._run, name="speaker", daemon=True)
        self._thread.start()

    def request_stop(self) -> None:
        """Ask the thread to end, and return at once; `stop` then waits for it."""
        self._stopping.set()
        self._came.set()

    def stop(self) -> None:
        """End the thread and release the speaker; takes at most 1 s, safe to call twice.

        A thread that hangs in its device is abandoned.
        """
        self.request_stop()
        thread, self._thread = self._thread, None
        if thread is None:
            return
        thread.join(timeout=_STOP_S)
        if thread.is_alive():
            _LOG.warning("speaker's thread does not end; abandoned")

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self._play()
            except SpeakerError as error:
                self._fail(error.sentence)
            except Exception as error:
                # A plug-in may raise anything; the server keeps running.
                _LOG.exception("speaker failed unexpectedly")
                self._fail(Sentence("speaker.failed", {"why": str(error) or type(error).__name__}))
            finally:
                self._close()
            self._stopping.wait(self._retry_s)

    def _play(self) -> None:
        self._busy_since_s = self._clock.now_s()
        self._speaker.open()
        self._worked()
        while not self._stopping.is_set():
            self._came.clear()
            now_s = self._clock.now_s()
            with self._lock:
                pieces = self._playout.due(now_s + _AHEAD_S)
                is_idle = self._playout.is_idle
                hushed = self._hushed
            for piece in pieces:
                if hushed != self._hushed:
                    break
                self._busy_since_s = self._clock.now_s()
                self._speaker.write(piece)
                self._worked()
                self._sounded_s = self._clock.now_s()
            if is_idle:
                self._came.wait(_LOOK_S)
            else:
                self._stopping.wait(_BEAT_S)

    def _worked(self) -> None:
        with self._lock:
            self._busy_since_s = None
            if self._problem is not None:
                self._note(None)

    def _fail(self, sentence: Sentence) -> None:
        self.failures += 1
        with self._lock:
            self._busy_since_s = None
            self._playout.hush()
            if sentence != self._problem and not self._stopping.is_set():
                self._note(sentence)

    def _close(self) -> None:
        self._busy_since_s = None
        try:
            self._speaker.close()
        except Exception:
            _LOG.exception("speaker does not close")

    def _note(self, problem: Sentence | None) -> None:
        """Store a new problem, or None when it has passed; the lock is held."""
        self._problem = problem
        if problem is None:
            _LOG.info("the speaker plays")
        else:
            _LOG.warning("the speaker has a problem", problem=str(problem))
