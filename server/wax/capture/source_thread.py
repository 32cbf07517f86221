"""Run one source in its own thread, and reopen it when it fails."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Generic, Protocol, TypeVar

from wax.device_thread import Device, DeviceThread
from wax.sentence import Sentence

if TYPE_CHECKING:
    import threading
    from collections.abc import Callable

    from wax.clock import Clock

ItemT = TypeVar("ItemT")
ItemT_co = TypeVar("ItemT_co", covariant=True)

_BLOCKED_S: Final = 3.0
"""A source that blocks for this long is reported."""


class _Source(Device, Protocol[ItemT_co]):
    """The common part of `VideoSource` and `AudioSource`."""

    def read(self) -> ItemT_co: ...


class SourceThread(DeviceThread, Generic[ItemT]):
    """Opens a source, passes everything it delivers to `sink`, and reopens it after a failure.

    `name` is ``microphone``, or ``camera``, optionally followed by the camera's own name. `sink`
    is called from this object's thread; an error that it raises counts as one of the source.

    While `needed` is not set, a source that declares ``rest_s`` is read just often enough to know
    that it works. Once it is set, the next item is read at once. A source that queues what it
    captures declares ``catch_up``, too, which drops the queue after a rest.
    """

    def __init__(
        self,
        source: _Source[ItemT],
        sink: Callable[[ItemT], None],
        *,
        name: str,
        clock: Clock,
        needed: threading.Event | None = None,
    ) -> None:
        self._source = source
        self._sink = sink
        self._needed = needed
        self._is_microphone = name == "microphone"
        super().__init__(
            source,
            clock,
            name=name,
            problem=None,
            hangs=Sentence("microphone.silent" if self._is_microphone else "camera.silent"),
            hangs_after_s=_BLOCKED_S,
        )

    def _use(self) -> None:
        while not self._stopping.is_set():
            self._mark_busy()
            item = self._source.read()
            self._busy_since_s = None
            if self._stopping.is_set():
                return
            self._mark_working()
            self._sink(item)
            rest_s = getattr(self._source, "rest_s", None)
            # `sink`, or who needed the source, may have cleared `needed` since `request_stop`.
            may_rest = rest_s is not None and not self._stopping.is_set()
            if may_rest and self._needed is not None and not self._needed.is_set():
                self._needed.wait(rest_s)
                getattr(self._source, "catch_up", _do_nothing)()

    def request_stop(self) -> None:
        super().request_stop()
        if self._needed is not None:
            self._needed.set()

    def _failed(self, why: str) -> Sentence:
        return Sentence(
            "microphone.failed" if self._is_microphone else "camera.failed", {"why": why}
        )


def _do_nothing() -> None: ...
