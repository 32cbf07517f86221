"""The pictures of a camera beside the driving view: they give way to it, packet by packet."""

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
"""The driving view is asked again after this whether it is done. Ours."""


class CameraSender(PictureSender):
    """Sends a packet when the link is free and the driving view has nothing to send.

    So a picture of that one waits for one packet at most. These pictures do not probe the link: the
    packets between them would count as the link's own delay.
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

    def _plan(self, size_bytes: int, now_s: float) -> Train:  # noqa: ARG002  # it is no probe
        congestion = self._tap.congestion
        return Train(number=0, pace_bps=float("inf"), payload_bytes=congestion.payload_bytes)

    def _send_due(self, under_way: UnderWay, now_s: float) -> float | None:
        while under_way.packets:
            if (wait_s := self._free_in_s(now_s)) > TICK_S:
                return min(wait_s, ASK_AGAIN_S)
            packet = under_way.packets.popleft()
            self._history.add([packet], now_s)
            self._put([packet], now_s)
        self._ended(under_way)
        return None
