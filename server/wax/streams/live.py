"""`audio-master` and `video-first`: a policy for each viewer, shared encoders for everybody.

Three decisions are made for each viewer, each by pure code: what their link carries
(`congestion/estimator`), what they are sent over it (`congestion/allocator`), and when it plays
(`sync/policies`).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import structlog

from wax.congestion.allocator import Allocator
from wax.congestion.late_encoding import BESIDE, LateEncoding
from wax.congestion.late_loop import LateLoop
from wax.congestion.sender_side import SenderSideControl
from wax.congestion.sound_choice import FIT_SHARE
from wax.congestion.upload_budget import UploadBudget
from wax.sentence import Sentence
from wax.streams.camera_feeds import CameraFeeds
from wax.streams.interface import (
    Codecs,
    Kind,
    Lanes,
    MessageRate,
    Policy,
    SendingLimits,
    StreamState,
    UnitPattern,
)
from wax.streams.playout_controller import PlayoutController
from wax.streams.rendition_ladder import RenditionLadder
from wax.streams.served_notifier import ServedNotifier, served
from wax.weak_callback import weak_callback

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from wax.clock import Clock
    from wax.config.audio import AudioSettings
    from wax.config.sync import SyncSettings
    from wax.config.video import VideoSettings
    from wax.congestion.allocation import Allocation, SoundEncoding, Step
    from wax.congestion.control import LinkEstimate
    from wax.fanout.camera import Camera
    from wax.fanout.sound_hub import SoundHub
    from wax.fanout.sound_lane import BoundedSoundLane
    from wax.fanout.video_hub import VideoHub
    from wax.fanout.video_lane import VideoLane
    from wax.streams.interface import Page
    from wax.sync.playout import PlayoutReport

_LOG = structlog.get_logger(__name__)

_THIN_BPS: Final = 100_000
_ALL: Final = Sentence("sent.all")
_RESUME_S: Final = 0.5
"""The least time between two keyframe requests for a lane that cannot decode."""


class LiveStreams:
    """One viewer's lanes, congestion control and decisions."""

    units: UnitPattern | None = None

    def __init__(
        self,
        *,
        clock: Clock,
        video: VideoHub,
        audio: SoundHub,
        ladder: RenditionLadder,
        budget: UploadBudget,
        late_encoding: LateEncoding,
        page: Page,
        sync: SyncSettings,
        cameras: Sequence[Camera] = (),
    ) -> None:
        self._clock = clock
        self._video = video
        self._audio = audio
        self._ladder = ladder
        self._budget = budget
        self._late_encoding = late_encoding
        self._page = page
        self._cameras = CameraFeeds(cameras, late_encoding)
        self._role_sync = sync
        self._wanted_policy: Policy | None = None
        self._size: str | None = video.sizes[0]
        self._sound_wanted = False
        self._is_ready = False
        self._is_deciding = False
        self._drives = False
        self._picture_lane: VideoLane | None = None
        self._sound_lane: BoundedSoundLane | None = None
        self._reset()

    def _reset(self) -> None:
        """Reset all knowledge of the link."""
        self._playout = PlayoutController(self._page, self._sync)
        self._notifier = ServedNotifier(self._page)
        self._congestion = SenderSideControl(weak_callback(self._follow), self._budget)
        self._congestion.full_feedback = self._drives
        self._allocator = self._make_allocator()
        self._allocation: Allocation | None = None
        self._seen: list[str | None] = []
        self._asked_s = float("-inf")

    @property
    def _sync(self) -> SyncSettings:
        """The role's settings, with the policy that the viewer has chosen."""
        if self._wanted_policy in (None, self._role_sync.policy):
            return self._role_sync
        return self._role_sync.model_copy(update={"policy": self._wanted_policy})

    def _make_allocator(self) -> Allocator:
        is_finer = self._sync.finer_ladder and self._video.has_room
        return Allocator(
            self._ladder.steps(is_finer=is_finer),
            self._ladder.encodings(self._sync.least_audio_mu_ms),
        )

    # --- the peer's life -------------------------------------------------------------------

    def make_lanes(self) -> Lanes:
        self.release()
        self._reset()
        self._picture_lane = self._video.add(self._page.boundary)
        self._sound_lane = self._audio.add(self._page.boundary)
        self._prioritise()
        cameras = self._cameras.make_lanes(self._page.boundary)
        return Lanes(self._picture_lane, self._sound_lane, self._congestion, cameras)

    def _prioritise(self) -> None:
        """Serve the operator first."""
        if self._drives and self._picture_lane is not None and self._sound_lane is not None:
            self._video.prioritise(self._picture_lane)
            self._audio.prioritise(self._sound_lane)

    def release(self) -> None:
        if self._picture_lane is not None and self._sound_lane is not None:
            self._video.remove(self._picture_lane)
            self._audio.remove(self._sound_lane)
        self._cameras.release()
        self._budget.leave(self)
        self._picture_lane = self._sound_lane = None
        self._sound_wanted = False
        self._is_ready = False

    def connected(self) -> None:
        """Start the picture before the page can request it: it plays on load."""
        self._playout.connected()
        self._decide_now()

    def ready(self) -> None:
        self._is_ready = True
        self._playout.ready()

    def link_changed(self) -> None:
        self._congestion.reset()
        self._decide_now()

    def want(self, *, sound: bool, picture: bool, size: str, policy: Policy | None) -> None:
        self._sound_wanted = sound
        self._size = size if picture else None
        if policy != self._wanted_policy:
            self._wanted_policy = policy
            self._playout.change_policy(self._sync)
        self._decide_now()

    def select_cameras(self, *, large: int | None, small: bool) -> None:
        self._cameras.select(large=large, small=small)
        self._decide_now()

    def set_role(self, sync: SyncSettings, *, drives: bool) -> None:
        self._drives = self._congestion.full_feedback = drives
        self._prioritise()
        if sync is self._role_sync:
            return
        self._role_sync = sync
        self._allocator = self._make_allocator()
        self._playout.change_policy(self._sync)
        self._decide_now()

    def reported(self, report: PlayoutReport) -> None:
        now_s = self._clock.now_s()
        self._playout.reported(report, now_s, self._congestion.estimate(now_s), self._allocation)

    def round_trip(self, round_trip_s: float) -> None:
        self._congestion.round_trip(round_trip_s, self._clock.now_s())

    @property
    def is_thin(self) -> bool:
        estimate = self._congestion.estimate(self._clock.now_s())
        return not estimate.assumed and estimate.rate_bps < _THIN_BPS

    def file_sent(self, size_bytes: int) -> float | None:
        if not self.is_thin:
            return None
        return self._congestion.file_sent(size_bytes, self._clock.now_s())

    def received(self, kind: Kind, pts: int) -> None: ...

    def keyframe_wanted(self, camera: int | None = None) -> None:
        if camera is not None:
            self._cameras.keyframe_wanted(camera)
        elif self._picture_lane is not None:
            self._video.request_keyframe(self._picture_lane)

    def status(self) -> StreamState:
        if self._allocation is None:
            return StreamState(self._playout.status())
        estimate = self._congestion.estimate(self._clock.now_s())
        in_step, lost = self._playout.is_in_step, round(estimate.lost, 4)
        now = served(estimate, self._allocation, in_step=in_step, cameras=self._seen)
        told = now.model_dump(exclude={"type"}) | {"reason": str(now.reason), "lost": lost}
        return StreamState(self._playout.status() | told, now, lost)

    # --- what is sent ----------------------------------------------------------------------

    def _decide_now(self) -> None:
        now_s = self._clock.now_s()
        self._decide(self._congestion.estimate(now_s), now_s)

    def _follow(self, estimate: LinkEstimate, now_s: float) -> None:
        """Decide anew if the new estimate may change what is sent."""
        lane, other_bps = self._picture_lane, self._congestion.other_bps
        if (lane is not None and self._needs_keyframe(lane, estimate, now_s)) or (
            not self._allocator.may_rest(estimate, other_bps, now_s)
        ):
            self._decide(estimate, now_s)

    def _decide(self, estimate: LinkEstimate, now_s: float) -> None:
        """Decide and apply the decision; a pre-roll sent meanwhile must not start another one."""
        if self._is_deciding:
            return
        self._is_deciding = True
        try:
            self._apply(estimate, now_s)
        finally:
            self._is_deciding = False

    def _apply(self, estimate: LinkEstimate, now_s: float) -> None:
        if self._picture_lane is None or self._sound_lane is None:
            return
        size = None if self._size is None else self._late_encoding.bounded(self._size)
        allowed = self._within_budget(estimate, size, now_s)
        allocation = self._allocator.decide(
            allowed,
            size=size,
            sound=self._sound_wanted,
            sound_encodings=self._fixed_encodings(),
            sound_channels=self._audio.channels,
            other_bps=self._congestion.other_bps,
            now_s=now_s,
            takes_redundancy=self._sound_lane.takes_redundancy,
        )
        if size != self._size and allocation.reason == _ALL:
            allocation = replace(allocation, reason=Sentence("sent.encoding"))
        before, self._allocation = self._allocation, allocation
        if allocation.tries and not (before and before.tries):
            self._congestion.try_more(now_s)
        self._send_picture(self._picture_lane, before, allocation, estimate, now_s)
        self._send_sound(self._sound_lane, allocation)
        self._seen = self._cameras.send(allocation, allowed, now_s)
        if self._is_ready:
            self._notifier.notify(
                estimate,
                allocation,
                in_step=self._playout.is_in_step,
                cameras=self._seen,
                now_s=now_s,
            )

    def _within_budget(
        self, estimate: LinkEstimate, size: str | None, now_s: float
    ) -> LinkEstimate:
        """Return the estimate of a link that carries no more than this viewer's share."""
        most_bps = self._ladder.most_bps(size)
        if size is not None:
            most_bps += self._cameras.most_bps(estimate.rate_bps) / FIT_SHARE
        # The share includes data channels, whatever they carry.
        wants_bps = min(estimate.rate_bps, most_bps + self._congestion.other_bps)
        share_bps = self._budget.share_bps(self, wants_bps, drives=self._drives, now_s=now_s)
        if share_bps >= wants_bps:
            return estimate
        return replace(estimate, rate_bps=share_bps, limit="share")

    def _send_picture(
        self,
        lane: VideoLane,
        before: Allocation | None,
        allocation: Allocation,
        estimate: LinkEstimate,
        now_s: float,
    ) -> None:
        lane.top_layer = allocation.top_layer
        old = None if before is None else before.step
        if allocation.step != old or before is None:
            name = None if allocation.step is None else allocation.step.name
            if name is not None:
                self._video.provide(self._ladder.settings(name))
            self._video.choose(lane, name)
            self._asked_s = now_s
            if old is not None and allocation.step is not None and _falls(old, allocation.step):
                # The link is full of the old rendition, and more pictures of it would be late.
                lane.give_up()
        elif self._needs_keyframe(lane, estimate, now_s):
            self._asked_s = now_s
            self._video.request_keyframe(lane)

    def _needs_keyframe(self, lane: VideoLane, estimate: LinkEstimate, now_s: float) -> bool:
        """Whether the old rendition was given up while the link was full, and a keyframe fits now.

        Or the keyframe came too late.
        """
        return (
            (lane.is_cut or lane.is_waiting)
            and estimate.state in ("starting", "steady")
            and now_s - self._asked_s >= _RESUME_S
            and self._congestion.is_free_for_keyframe(now_s)
        )

    def _send_sound(self, lane: BoundedSoundLane, allocation: Allocation) -> None:
        lane.redundancy = allocation.redundancy
        self._audio.choose(lane, allocation.sound, self._playout.preroll_ms)

    def _fixed_encodings(self) -> Sequence[SoundEncoding] | None:
        mu_ms = self._sync.audio_mu_ms
        return None if mu_ms == "auto" else self._ladder.encodings_of(mu_ms)


class LiveService:
    """Makes the streams for viewers who each have their own policy."""

    acknowledged = False
    state_messages = MessageRate(rate_hz=20.0, burst=60)

    def __init__(
        self,
        *,
        clock: Clock,
        video_settings: VideoSettings,
        audio_settings: AudioSettings,
        video: VideoHub,
        audio: SoundHub,
        upload_bps: float = 0,
        cameras: Sequence[Camera] = (),
    ) -> None:
        """`upload_bps` limits what all viewers together are sent; 0 is no limit."""
        self._cameras = cameras
        self.codecs = Codecs(
            audio="opus",
            video=video_settings.codec,
            cameras=frozenset(one.settings.codec for one in cameras),
        )
        self._clock = clock
        self._video = video
        self._audio = audio
        self._ladder = RenditionLadder(video_settings, audio_settings)
        self._budget = UploadBudget(upload_bps)
        self._late_loop = LateLoop()
        self._late_encoding = LateEncoding(
            video.sizes, has_cameras=any(len(one.hub.sizes) > 1 for one in cameras)
        )

    def relieve(self, late_s: float) -> None:
        before = self.limits
        wants_bps = self._budget.observers_want_bps
        self._late_loop.update(late_s, wanted_bps=sum(wants_bps), observers=len(wants_bps))
        self._budget.limit_observers(self._late_loop.most_bps)
        beside = [one.hub.loads[one.hub.sizes[0]] for one in self._cameras]
        loads = self._video.loads | {BESIDE: max(beside, default=0.0)}
        self._late_encoding.update(loads, self._clock.now_s())
        _log_changes(before, self.limits, loads)

    @property
    def limits(self) -> SendingLimits:
        left, most_bps = self._late_encoding.left, self._late_loop.most_bps
        largest = self._late_encoding.bounded(self._video.sizes[0])
        return SendingLimits(left, largest, most_bps if math.isfinite(most_bps) else None)

    @property
    def has_room(self) -> bool:
        return self._budget.next_bps() >= self._ladder.least_bps

    @property
    def sizes(self) -> Sequence[str]:
        return self._video.sizes

    @property
    def cameras(self) -> Sequence[str]:
        return [one.name for one in self._cameras]

    def streams(self, page: Page, sync: SyncSettings) -> LiveStreams:
        return LiveStreams(
            clock=self._clock,
            video=self._video,
            audio=self._audio,
            ladder=self._ladder,
            budget=self._budget,
            late_encoding=self._late_encoding,
            page=page,
            sync=sync,
            cameras=self._cameras,
        )


def _log_changes(before: SendingLimits, now: SendingLimits, loads: Mapping[str, float]) -> None:
    if len(now.left) > len(before.left):
        _LOG.warning(
            "encoding falls behind; the largest sizes are left for a while",
            left=", ".join(now.left),
            largest=now.largest,
            loads={size: round(load, 2) for size, load in loads.items() if load},
        )
    elif now.left != before.left:
        _LOG.info("a size that was left is tried again", size=now.largest)
    if before.observers_bps is None and now.observers_bps is not None:
        _LOG.warning("the event loop is late; all observers together are sent less")
    elif now.observers_bps is None and before.observers_bps is not None:
        _LOG.info("the event loop is on time; observers are sent what their links carry")


def _falls(old: Step, new: Step) -> bool:
    return new.bitrate_bps < old.bitrate_bps
