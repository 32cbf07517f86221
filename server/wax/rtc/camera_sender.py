"""Sends an additional camera's pictures, which give way to the driving view's packets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.congestion.control import Train
from wax.rtc.picture_sender import ASK_AGAIN_S, TICK_S, PictureSender, UnderWay

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Literal

    from wax.rtc.lane import PictureLane
    from wax.rtc.sender import SenderContext

_GIVE_WAY_S: Final = 0.005
"""How soon to check again whether the driving view is done. Our choice."""


class CameraSender(PictureSender):
    """Sends a packet when the link is free and the driving view has nothing to send.

    So the driving view waits for one packet at most. These pictures do not probe the link: packets
    interleaved with theirs would be measured as delay of the link.
    """

    def __init__(
        self,
        context: SenderContext,
        *,
        lane: PictureLane,
        codec: Literal["vp8", "h264"],
        round_trip_s: Callable[[], float | None],
        on_keyframe_wanted: Callable[[], None],
        driving_view: PictureSender,
    ) -> None:
        super().__init__(
            context,
            lane=lane,
            codec=codec,
            round_trip_s=round_trip_s,
            on_keyframe_wanted=on_keyframe_wanted,
        )
        self._driving_view = driving_view

    def _free_in_s(self, now_s: float) -> float:
        return _GIVE_WAY_S if self._driving_view.is_busy else super()._free_in_s(now_s)

    def _plan_train(self, size_bytes: int, now_s: float) -> Train:  # noqa: ARG002  # not a probe
        congestion = self._tap.congestion
        return Train(number=0, pace_bps=float("inf"), payload_bytes=congestion.payload_bytes)

    def _send_due(self, under_way: UnderWay, now_s: float) -> float | None:
        while under_way.packets:
            if (wait_s := self._free_in_s(now_s)) > TICK_S:
                return min(wait_s, ASK_AGAIN_S)
            packet = under_way.packets.popleft()
            self._history.add([packet], now_s)
            self._send_packets([packet], now_s)
        self._finish(under_way)
        return None
