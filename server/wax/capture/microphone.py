"""Live microphones: everything that PortAudio reaches.

FFmpeg's ALSA input, which comes with PyAV, had the same delay to within a millisecond, but took
twice the CPU time.
"""

from __future__ import annotations

import queue
from collections import deque
from contextlib import suppress
from statistics import median
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import structlog
from av.audio.frame import AudioFrame

from wax.capture.channels import MOST_CHANNELS
from wax.capture.portaudio import (
    close_stream,
    load_portaudio,
    portaudio_name,
    readable_part,
    rescan_devices,
    start_stream,
)
from wax.capture.resample import Resampler
from wax.capture.source import REST_S, SAMPLE_RATE_HZ, Sound
from wax.errors import SourceError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from wax.clock import Clock
    from wax.config.audio import AudioSettings

_LOG = structlog.get_logger(__name__)

_BLOCKS_PER_S: Final = 100
_QUEUE_BLOCKS: Final = 50
"""Half a second: a reader that falls further behind loses the oldest, so that delay cannot grow."""

_MOST_AGE_S: Final = 0.5
"""The greatest age of a block, as reported by the device, that is believed."""

_SILENT_S: Final = 1.8
_LOG_EVERY_S: Final = 10.0


class PortAudioMicrophone:
    """A microphone of ALSA, PulseAudio, PipeWire, CoreAudio, WASAPI …, the default or one of them.

    `device` is PortAudio's number, a part of the name, a link in /dev/snd, or None for the
    default. Blocks last 10 ms. A device is opened with as many of the wanted channels as it has;
    one that cannot deliver them at 48 kHz is opened at its own rate and resampled.

    `captured_s` is PortAudio's time of the first sample at the converter if that is credible,
    otherwise the time of arrival minus the block's length. Sound servers guess it, and for some
    blocks are wrong by a quarter of a second, so the median of the last second is used. Losses in
    the device and by a slow reader are logged, at most once in 10 s.
    """

    rest_s: Final = REST_S

    def __init__(
        self,
        settings: AudioSettings,
        clock: Clock,
        *,
        device: int | str | None = None,
        load_portaudio: Callable[[], Any] = load_portaudio,
    ) -> None:
        self._wanted_channels = settings.channels
        self._clock = clock
        self._device = device
        self._load_portaudio = load_portaudio
        self._blocks: queue.Queue[Sound] = queue.Queue(_QUEUE_BLOCKS)
        self._stream: Any = None
        self._opened_before = False
        self._losses = 0
        self._losses_logged = 0
        self._logged_s = float("-inf")

    @property
    def name(self) -> Sentence:
        if self._device is None:
            return Sentence("microphone.default")
        return Sentence("microphone.named", {"name": self._device})

    def open(self) -> None:
        self.close()
        portaudio = self._load_portaudio()
        if self._opened_before:
            rescan_devices(portaudio)
        self._opened_before = True
        try:
            self._stream = self._start(portaudio)
        except (portaudio.PortAudioError, ValueError) as error:
            raise SourceError(
                Sentence(
                    "microphone.not_open", {"microphone": self.name, "why": readable_part(error)}
                )
            ) from error

    def read(self) -> Sound:
        if self._stream is None:
            raise SourceError(f"{self.name} was read before it was opened.")
        try:
            sound = self._blocks.get(timeout=_SILENT_S)
        except queue.Empty:
            raise SourceError(Sentence("microphone.no_sound", {"microphone": self.name})) from None
        self._log_losses()
        return sound

    def catch_up(self) -> None:
        with suppress(queue.Empty):
            while True:
                self._blocks.get_nowait()
        self._losses_logged = self._losses

    def close(self) -> None:
        stream, self._stream = self._stream, None
        close_stream(stream)
        self._blocks = queue.Queue(_QUEUE_BLOCKS)

    def _start(self, portaudio: Any) -> Any:
        device = portaudio_name(self._device)
        own = portaudio.query_devices(device, "input")
        has = max(1, min(MOST_CHANNELS, own["max_input_channels"]))
        channels = min(self._wanted_channels, has)
        choices = dict.fromkeys(
            (
                (SAMPLE_RATE_HZ, channels),
                (SAMPLE_RATE_HZ, 1),
                (round(own["default_samplerate"]), has),
            )
        )
        *firsts, last = choices
        for choice in firsts:
            with suppress(portaudio.PortAudioError):
                return self._start_at(portaudio, device, *choice)
        return self._start_at(portaudio, device, *last)

    def _start_at(
        self, portaudio: Any, device: int | str | None, rate_hz: int, channels: int
    ) -> Any:
        stream = portaudio.InputStream(
            device=device,
            samplerate=rate_hz,
            channels=channels,
            blocksize=rate_hz // _BLOCKS_PER_S,
            dtype="int16",
            latency="low",
            callback=self._receiver(rate_hz, channels),
        )
        start_stream(stream)
        if channels < self._wanted_channels:
            _LOG.info("the microphone has one channel: its sound is mono", source=str(self.name))
        return stream

    def _receiver(
        self, rate_hz: int, channels: int
    ) -> Callable[[NDArray[np.int16], int, Any, Any], None]:
        """Make PortAudio's callback, which runs in PortAudio's thread and must not block."""
        blocks = self._blocks
        kept = min(channels, self._wanted_channels)
        direct = (rate_hz, channels) == (SAMPLE_RATE_HZ, kept)
        resampler = None if direct else Resampler(kept)
        count = 0
        zeros_s: deque[float] = deque(maxlen=_BLOCKS_PER_S)

        def receive(samples: NDArray[np.int16], frames: int, times: Any, status: Any) -> None:
            nonlocal count
            length_s = frames / rate_hz
            zero_s = self._clock.now_s() - _age_s(times, length_s) - count / rate_hz
            if status.input_overflow:
                self._losses += 1
            # Sound was missing, so the count no longer says when the first block was captured.
            if status.input_overflow or (zeros_s and abs(zero_s - zeros_s[-1]) > _MOST_AGE_S):
                zeros_s.clear()
            zeros_s.append(zero_s)
            captured_s = median(zeros_s) + count / rate_hz
            if resampler is None:
                copy = samples[:, 0].copy() if channels == 1 else samples.copy()
                self._enqueue(blocks, Sound(samples=copy, captured_s=captured_s))
            else:
                frame = _frame(samples, rate_hz, count)
                for piece, time_s in resampler.feed(frame):
                    begin_s = captured_s + time_s - count / rate_hz
                    self._enqueue(blocks, Sound(samples=piece, captured_s=begin_s))
            count += frames

        return receive

    def _log_losses(self) -> None:
        """Log losses from the reader's thread: PortAudio's thread must not wait for a terminal."""
        now_s, losses = self._clock.now_s(), self._losses
        if losses == self._losses_logged or now_s - self._logged_s < _LOG_EVERY_S:
            return
        _LOG.warning("sound was lost", source=str(self.name), blocks=losses - self._losses_logged)
        self._losses_logged, self._logged_s = losses, now_s

    def _enqueue(self, blocks: queue.Queue[Sound], sound: Sound) -> None:
        while True:
            try:
                blocks.put_nowait(sound)
                return
            except queue.Full:
                self._losses += 1
                try:
                    blocks.get_nowait()
                except queue.Empty:
                    continue


def _age_s(times: Any, length_s: float) -> float:
    """Return how long ago the block's first sample was captured.

    Some host APIs report 0 or another clock's time; a block's age is at least its length.
    """
    age_s = float(times.currentTime - times.inputBufferAdcTime)
    credible = times.inputBufferAdcTime > 0 and 0.5 * length_s <= age_s <= _MOST_AGE_S
    return age_s if credible else length_s


def _frame(samples: NDArray[np.int16], rate_hz: int, pts: int) -> AudioFrame:
    layout = "mono" if samples.shape[1] == 1 else "stereo"
    frame = AudioFrame.from_ndarray(np.ascontiguousarray(samples).reshape(1, -1), "s16", layout)
    frame.sample_rate = rate_hz
    frame.pts = pts
    return frame
