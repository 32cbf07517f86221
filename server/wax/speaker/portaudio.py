"""Live speakers: everything that PortAudio reaches."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any, Final

import av
import numpy as np

from wax.capture.portaudio import (
    close_stream,
    load_portaudio,
    portaudio_name,
    readable_part,
    rescan_devices,
    start_stream,
)
from wax.errors import SourceError, SpeakerError
from wax.sentence import Sentence
from wax.voice.packet import RATE_HZ

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from wax.clock import Clock
    from wax.config.voice import VoiceSettings

_BLOCKS_PER_S: Final = 100
_WAITING_S: Final = 0.2
"""The longest queue for the device: more would only add delay, so the newest sound is dropped."""


def _load() -> Any:
    return load_portaudio(Sentence("portaudio.speakers"), '[voice] speaker = "none"')


class PortAudioSpeaker:
    """A speaker of ALSA, PulseAudio, PipeWire, CoreAudio, WASAPI …, the default or one of them.

    `device` is PortAudio's number, a part of the name, a link in /dev/snd, or None for the
    default. It stays open and plays silence between words, because opening it takes longer than a
    word. At most 200 ms are queued for it.
    """

    def __init__(
        self,
        settings: VoiceSettings,
        clock: Clock,
        *,
        device: int | str | None = None,
        load_portaudio: Callable[[], Any] = _load,
    ) -> None:
        del settings, clock  # PortAudio calls back when it needs sound
        self._device = device
        self._load_portaudio = load_portaudio
        self._queue = _Queue()
        self._stream: Any = None
        self._opened_before = False

    @property
    def name(self) -> Sentence:
        if self._device is None:
            return Sentence("speaker.default")
        return Sentence("speaker.named", {"name": self._device})

    def open(self) -> None:
        self.close()
        try:
            portaudio = self._load_portaudio()
        except SourceError as error:
            raise SpeakerError(error.sentence) from error
        if self._opened_before:
            rescan_devices(portaudio)
        self._opened_before = True
        try:
            self._stream = self._start(portaudio)
        except (portaudio.PortAudioError, ValueError) as error:
            raise SpeakerError(
                Sentence("speaker.not_open", {"speaker": self.name, "why": readable_part(error)})
            ) from error

    def write(self, samples: NDArray[np.int16]) -> None:
        if self._stream is None or not self._stream.active:
            raise SpeakerError(Sentence("speaker.gone", {"speaker": self.name}))
        self._queue.put(samples)

    def close(self) -> None:
        stream, self._stream = self._stream, None
        close_stream(stream)

    def _start(self, portaudio: Any) -> Any:
        try:
            return self._start_at(portaudio, RATE_HZ, 1)
        except portaudio.PortAudioError:
            own = portaudio.query_devices(portaudio_name(self._device), "output")
            rate_hz, channels = round(own["default_samplerate"]), min(2, own["max_output_channels"])
            if (rate_hz, channels) == (RATE_HZ, 1):
                raise
            return self._start_at(portaudio, rate_hz, channels)

    def _start_at(self, portaudio: Any, rate_hz: int, channels: int) -> Any:
        self._queue = queue = _Queue(rate_hz)

        def fill(out: NDArray[np.int16], frames: int, _times: Any, _status: Any) -> None:
            """Run in PortAudio's thread, which must not block."""
            out[:] = queue.take(frames)[:, np.newaxis]

        return start_stream(
            portaudio.OutputStream(
                device=portaudio_name(self._device),
                samplerate=rate_hz,
                channels=channels,
                blocksize=rate_hz // _BLOCKS_PER_S,
                dtype="int16",
                latency="low",
                callback=fill,
            )
        )


class _Queue:
    """The queue of samples that are not played yet, at the device's rate."""

    def __init__(self, rate_hz: int = RATE_HZ) -> None:
        self._most = int(rate_hz * _WAITING_S)
        self._resampler: av.AudioResampler | None = None
        if rate_hz != RATE_HZ:
            self._resampler = av.AudioResampler(format="s16", layout="mono", rate=rate_hz)
        self._lock = threading.Lock()
        self._samples = np.zeros(0, np.int16)

    def put(self, samples: NDArray[np.int16]) -> None:
        converted = self._converted(samples)
        with self._lock:
            room = max(0, self._most - len(self._samples))
            self._samples = np.concatenate((self._samples, converted[:room]))

    def take(self, count: int) -> NDArray[np.int16]:
        """Remove and return `count` samples, padded with silence."""
        taken = np.zeros(count, np.int16)
        with self._lock:
            first, self._samples = self._samples[:count], self._samples[count:]
        taken[: len(first)] = first
        return taken

    def _converted(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        if self._resampler is None:
            return samples
        frame = av.AudioFrame.from_ndarray(samples.reshape(1, -1), format="s16", layout="mono")
        frame.sample_rate = RATE_HZ
        pieces = [out.to_ndarray().reshape(-1) for out in self._resampler.resample(frame)]
        return np.concatenate([np.zeros(0, np.int16), *pieces]).astype(np.int16, copy=False)
