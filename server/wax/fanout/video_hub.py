"""The fan-out of the picture: from the slot through the renditions to the viewers' lanes."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING, Final, Protocol

from wax.capture.newest_slot import NewestSlot
from wax.encode.choice import Encoders
from wax.encode.rendition import Rendition
from wax.fanout.batches import in_batches
from wax.fanout.video_lane import VideoLane
from wax.machine import cores

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.capture.source import Picture
    from wax.clock import Clock
    from wax.config.video import RenditionSettings, VideoSettings
    from wax.encode.encoded import EncodedPicture
    from wax.encode.video_encoder import PictureEncoder
    from wax.error_boundary import ErrorBoundary

_STOP_S: Final = 1.5
_CORES_SHARE: Final = 0.5


class HubLane(Protocol):
    """The interface of one viewer's lane; see `VideoLane`."""

    dropped: int

    @property
    def rendition(self) -> str | None: ...

    def choose(self, rendition: str | None) -> None: ...

    def takes(self, rendition: str) -> bool: ...

    def put(self, picture: EncodedPicture) -> None: ...


class VideoHub:
    """Encodes each rendition once and passes the packets to all lanes that want them."""

    def __init__(
        self,
        *,
        settings: VideoSettings,
        clock: Clock,
        make_encoder: Callable[[RenditionSettings], PictureEncoder] | None = None,
    ) -> None:
        self.slot: NewestSlot[Picture] = NewestSlot()
        self._clock = clock
        self._lanes: dict[HubLane, Callable[[EncodedPicture], None]] = {}
        self._first: HubLane | None = None
        self._dropped_by_gone = 0
        self._loop: asyncio.AbstractEventLoop | None = None
        self._make = make_encoder or Encoders(settings).make
        self._keyframe_interval_s = settings.keyframe_interval_s
        self._renditions = {one.name: self._rendition(one) for one in settings.renditions}
        self._shared = tuple(self._renditions)
        self._cores = cores.usable()

    @property
    def names(self) -> list[str]:
        """The names of the renditions, the configured ones first."""
        return list(self._renditions)

    @property
    def sizes(self) -> list[str]:
        """The sizes of the shared renditions, each once, the largest first."""
        return list(dict.fromkeys(self._renditions[name].settings.size for name in self._shared))

    def start(self) -> None:
        self._loop = asyncio.get_running_loop()
        for rendition in self._renditions.values():
            rendition.start()

    def request_stop(self) -> None:
        """Ask all threads to end, and return at once; `stop` then waits for them."""
        for rendition in self._renditions.values():
            rendition.request_stop()

    def stop(self) -> None:
        """End all threads; takes at most 1.5 s, safe to call twice."""
        self.request_stop()
        end_s = self._clock.now_s() + _STOP_S
        for rendition in self._renditions.values():
            rendition.stop(max(end_s - self._clock.now_s(), 0.0))

    def add(self, boundary: ErrorBoundary) -> VideoLane:
        """Make a lane, which is called inside `boundary`; it gets nothing until `choose`."""
        lane = VideoLane()
        self.attach(lane, boundary)
        return lane

    def attach(self, lane: HubLane, boundary: ErrorBoundary) -> None:
        """Add an existing lane; it gets nothing until `choose`."""
        self._lanes[lane] = boundary.around(lane.put)

    def provide(self, settings: RenditionSettings) -> None:
        """Add a rendition that is not in the configuration; it is removed when nobody uses it."""
        if settings.name not in self._renditions and self._loop is not None:
            rendition = self._rendition(settings)
            self._renditions[settings.name] = rendition
            rendition.start()

    @property
    def has_room(self) -> bool:
        """Whether the machine can encode one more rendition for a single viewer.

        Half of the cores are reserved for everything else; one more rendition is assumed to cost as
        much as the most expensive current one.
        """
        loads = [one.load for one in self._renditions.values()]
        return sum(loads) + max(loads) <= _CORES_SHARE * self._cores

    @property
    def loads(self) -> dict[str, float]:
        """For each size, the largest load of its encoders (`Rendition.load`)."""
        found: dict[str, float] = {}
        for one in self._renditions.values():
            found[one.settings.size] = max(found.get(one.settings.size, 0.0), one.load)
        return found

    def prioritise(self, lane: HubLane) -> None:
        """Serve this lane first: the operator does not wait for a crowd."""
        if lane in self._lanes:
            self._first = lane
            self._lanes = {lane: self._lanes[lane], **self._lanes}

    def remove(self, lane: HubLane) -> None:
        """Forget a lane; safe to call twice."""
        if lane in self._lanes:
            del self._lanes[lane]
            self._dropped_by_gone += lane.dropped
            if lane is self._first:
                self._first = None
        self._refresh()

    def choose(self, lane: HubLane, rendition: str | None) -> None:
        """Send this lane this rendition, starting at its next keyframe, and request one."""
        if rendition == lane.rendition:
            return
        lane.choose(rendition)
        self._refresh()
        self.request_keyframe(lane)

    def request_keyframe(self, lane: HubLane) -> None:
        """Request a keyframe for a viewer who cannot decode (PLI, RFC 4585; FIR, RFC 5104).

        `session/viewer.py` limits a viewer's requests; the rendition merges requests.
        """
        if lane.rendition is not None:
            is_first = lane is self._first
            self._renditions[lane.rendition].request_keyframe(is_urgent=is_first)

    @property
    def wanted(self) -> list[str]:
        """The renditions in use; no other is encoded."""
        return [name for name, one in self._renditions.items() if one.wanted]

    @property
    def dropped(self) -> int:
        """Pictures dropped by full lanes since the start; never falls."""
        return self._dropped_by_gone + sum(lane.dropped for lane in self._lanes)

    def counts(self) -> dict[str, int]:
        """Count pictures since the start: captured, and encoded by rendition."""
        encoded = {name: one.encoded for name, one in self._renditions.items()}
        return {"captured": self.slot.count} | encoded

    def _rendition(self, settings: RenditionSettings) -> Rendition:
        return Rendition(
            settings=settings,
            keyframe_interval_s=self._keyframe_interval_s,
            make_encoder=partial(self._make, settings),
            slot=self.slot,
            clock=self._clock,
            deliver=self._from_thread,
        )

    def _refresh(self) -> None:
        for name, rendition in list(self._renditions.items()):
            wanted = any(lane.takes(name) for lane in self._lanes)
            rendition.want(wanted)
            if not wanted and name not in self._shared:
                del self._renditions[name]
                rendition.request_stop()
        if self.wanted:
            self.slot.needed.set()
        else:
            self.slot.needed.clear()

    def _from_thread(self, picture: EncodedPicture) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._fan_out, picture)

    def _fan_out(self, picture: EncodedPicture) -> None:
        takers = [put for lane, put in self._lanes.items() if lane.takes(picture.rendition)]
        calls: list[Callable[[], None]] = [partial(put, picture) for put in takers]
        if picture.keyframe:  # lanes switch now, which may leave the old rendition unused
            calls.append(self._refresh)
        in_batches(calls)
