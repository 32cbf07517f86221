"""PortAudio with one device."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any


class PortAudioError(Exception):
    pass


class OneDevice:
    """The part of `sounddevice` that is used for both kinds of stream."""

    PortAudioError = PortAudioError

    def __init__(self, rate_hz: int = 48_000, channels: int = 1, *, present: bool = True) -> None:
        self.rate_hz, self.channels, self.present = rate_hz, channels, present
        self.streams: list[SimpleNamespace] = []
        self.starts = True
        self.looked = 0

    def stream(self, **wanted: Any) -> SimpleNamespace:
        self._find()
        if (wanted["samplerate"], wanted["channels"]) != (self.rate_hz, self.channels):
            raise PortAudioError("Invalid sample rate")
        stream = SimpleNamespace(**wanted, active=True, ended=0, start=self._start)

        def end(*, ignore_errors: bool) -> None:
            stream.ended += 1
            stream.active = False

        stream.abort = stream.close = end
        self.streams.append(stream)
        return stream

    def _find(self) -> None:
        if not self.present:
            raise PortAudioError("Error querying device -1\n[PaErrorCode -9996]")

    def _start(self) -> None:
        if not self.starts:
            raise PortAudioError("Device unavailable")

    def query_devices(self, device: object, kind: str) -> dict[str, float]:
        self._find()
        return {"default_samplerate": float(self.rate_hz), f"max_{kind}_channels": self.channels}

    def _terminate(self) -> None:
        self.looked += 1

    def _initialize(self) -> None:
        pass
