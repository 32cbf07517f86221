"""One viewer's lanes for all cameras but the driving view, and what is sent on them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.congestion.camera_choice import CameraChoice
from wax.congestion.wire_cost import picture_bps
from wax.streams.interface import CameraLane
from wax.streams.rendition_ladder import step_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.allocation import Allocation, Step
    from wax.congestion.control import LinkEstimate
    from wax.congestion.late_encoding import LateEncoding
    from wax.error_boundary import ErrorBoundary
    from wax.fanout.camera import Camera
    from wax.fanout.video_hub import VideoHub
    from wax.fanout.video_lane import VideoLane

_ASK_AGAIN_S: Final = 1.0
"""The least time between two keyframe requests for a lane that cannot decode."""


class CameraFeeds:
    """Lives as long as the viewer; `make_lanes` is called for each new peer."""

    def __init__(self, cameras: Sequence[Camera], late_encoding: LateEncoding) -> None:
        self._cameras = cameras
        self._late_encoding = late_encoding
        self._ladders = [
            [step_of(one, one_camera.settings.codec) for one in one_camera.settings.renditions]
            for one_camera in cameras
        ]
        self._reset()

    def _reset(self) -> None:
        """Reset all knowledge; the page must first report which cameras it shows."""
        self._large: int | None = None
        self._is_on = False
        self._choice = CameraChoice()
        self._lanes: list[VideoLane] = []
        self._sent: list[Step | None] = [None] * len(self._cameras)
        self._asked_s = [float("-inf")] * len(self._cameras)

    def make_lanes(self, boundary: ErrorBoundary) -> list[CameraLane]:
        """Make lanes for a new peer, after `release`."""
        self._reset()
        self._lanes = [one.hub.add(boundary) for one in self._cameras]
        return [
            CameraLane(lane, one.settings.codec)
            for lane, one in zip(self._lanes, self._cameras, strict=True)
        ]

    def release(self) -> None:
        """Release the lanes; safe to call twice."""
        for camera, lane in zip(self._cameras, self._lanes, strict=False):
            camera.hub.remove(lane)
        self._lanes = []

    def select(self, *, large: int | None, small: bool) -> None:
        """Select the camera shown large, None for the driving view, and whether others show."""
        self._large, self._is_on = large, small

    def most_bps(self, rate_bps: float) -> float:
        """Return the most that the cameras take on a link of this rate."""
        best = (wish[0] for wish in self._wishes() if wish)
        return sum(picture_bps(step, 0, rate_bps) for step in best)

    def send(
        self, allocation: Allocation, estimate: LinkEstimate, now_s: float
    ) -> list[str | None]:
        """Send in the rate that the driving view leaves; return each camera's rendition or None."""
        wishes = self._wishes() if allocation.step is not None and self._lanes else []
        chosen = self._choice.decide(
            wishes or [[] for _ in self._cameras],
            left_bps=allocation.left_bps,
            kept_bps=allocation.kept_bps,
            rate_bps=estimate.rate_bps,
            now_s=now_s,
        )
        for at, (camera, lane) in enumerate(zip(self._cameras, self._lanes, strict=False)):
            self._serve(at, camera.hub, lane, chosen[at], now_s)
        return [None if step is None else step.name for step in chosen]

    def keyframe_wanted(self, camera: int) -> None:
        """Handle a browser that cannot decode this camera's pictures."""
        if camera < len(self._lanes):
            self._cameras[camera].hub.request_keyframe(self._lanes[camera])

    def _wishes(self) -> list[Sequence[Step]]:
        """Return the wanted steps: all for the large camera, only the last for small ones."""
        return [
            self._in_time(ladder) if at == self._large else ladder[-1:] if self._is_on else []
            for at, ladder in enumerate(self._ladders)
        ]

    def _in_time(self, ladder: Sequence[Step]) -> Sequence[Step]:
        """Return the ladder without its largest size while that is left."""
        if not self._late_encoding.leaves_beside:
            return ladder
        return [one for one in ladder if one.size != ladder[0].size] or ladder[-1:]

    def _serve(
        self, at: int, hub: VideoHub, lane: VideoLane, step: Step | None, now_s: float
    ) -> None:
        if step != self._sent[at]:
            self._sent[at], self._asked_s[at] = step, now_s
            hub.choose(lane, None if step is None else step.name)
        elif (lane.is_cut or lane.is_waiting) and now_s - self._asked_s[at] >= _ASK_AGAIN_S:
            self._asked_s[at] = now_s
            hub.request_keyframe(lane)
