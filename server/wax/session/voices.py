"""Who speaks through the robot: one at a time, decided for each packet by its sender's role."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Protocol

from wax.access import permissions
from wax.control.listener import Listener
from wax.protocol import messages
from wax.rate_limits import TokenBucket
from wax.sentence import Sentence
from wax.session.roles import role_of
from wax.voice.floor import Floor, VoiceVerdict

if TYPE_CHECKING:
    from wax.access.host_decisions import HostDecisions
    from wax.clock import Clock
    from wax.control.loop import ControlLoop
    from wax.control.turns import TurnEvent, Turns
    from wax.session.viewer import Viewer
    from wax.session.viewers import Viewers
    from wax.telemetry import Counters
    from wax.voice.packet import VoicePacket

_PACKETS_HZ: Final = 110.0
"""Packets of 10 ms, with a margin for a fast clock."""
_PACKETS_BURST: Final = 60
"""What a link may hold back in more than half a second; older packets are too late anyway."""
_OVER_S: Final = 0.5
"""A viewer who sends nothing for this long has stopped speaking."""
_TELL_S: Final = 0.3

_ONLY: Final = Sentence("voice.not_yours")
_MUTED: Final = Sentence("voice.muted")


class Output(Protocol):
    """What plays a voice (`wax.speaker.speaker_thread.SpeakerThread`); nothing here raises."""

    @property
    def problem(self) -> Sentence | None: ...

    @property
    def sounded_s(self) -> float: ...

    def push(self, packet: VoicePacket, now_s: float) -> None: ...

    def hush(self) -> None: ...


@dataclass(slots=True)
class _Speaking:
    """A viewer who sends sound, and what their page was told."""

    viewer: Viewer
    bucket: TokenBucket
    verdict: VoiceVerdict
    came_s: float
    told: messages.Heard | None = None
    told_s: float = float("-inf")


class Voices(Listener):
    """Passes a voice to the `speaker`, or tells its sender why not; never raises.

    Call all methods from the event loop.
    """

    def __init__(
        self,
        *,
        speaker: Output,
        clock: Clock,
        counters: Counters,
        decisions: HostDecisions,
        viewers: Viewers,
        turns: Turns,
        control: ControlLoop,
    ) -> None:
        self._speaker = speaker
        self._clock = clock
        self._counters = counters
        self._decisions = decisions
        self._viewers = viewers
        self._turns = turns
        self._control = control
        self._floor = Floor()
        self._speaking: dict[int, _Speaking] = {}
        self._shown = self.info()

    def info(self) -> messages.VoiceInfo:
        """Return what everybody sees of the voices."""
        return messages.VoiceInfo(
            speaker=self._floor.holder(self._clock.now_s()),
            muted=self._decisions.switches.are_voices_muted,
            problem=self._speaker.problem,
        )

    def receive(self, viewer: Viewer, packet: VoicePacket | None) -> None:
        """Handle a packet of a viewer's voice, None for one that could not be read."""
        with viewer.boundary:
            now_s = self._clock.now_s()
            one = self._speaking.get(viewer.number)
            if one is None or one.viewer is not viewer:
                bucket = TokenBucket(rate_hz=_PACKETS_HZ, burst=_PACKETS_BURST)
                one = _Speaking(viewer, bucket, VoiceVerdict.NOT_ALLOWED, now_s)
                self._speaking[viewer.number] = one
            one.came_s = now_s
            if packet is None:
                self._counters.add("voice packets refused")
            elif not one.bucket.take(now_s):
                self._counters.add("voice packets over the rate")
            else:
                one.verdict = self._judged(viewer, now_s)
                if one.verdict is VoiceVerdict.HEARD:
                    source = viewer.number << 32 | packet.source
                    self._speaker.push(replace(packet, source=source), now_s)
                else:
                    self._counters.add(f"voice packets {one.verdict.value}")

    def check(self) -> None:
        """Silence a speaker who may no longer speak, at once: call it when a turn ends."""
        holder = self._floor.holder(self._clock.now_s())
        if holder is None:
            return
        one = self._speaking.get(holder)
        if one is None or self._is_muted or not self._may_speak(one.viewer):
            self._floor.clear()
            self._speaker.hush()

    def turn_events(self, _events: tuple[TurnEvent, ...]) -> None:
        self.check()

    def send_changes(self, now_s: float) -> None:
        """Tell the pages what has changed; call it a few times a second."""
        self.check()
        for number, one in list(self._speaking.items()):
            is_over = now_s - one.came_s > _OVER_S
            told = messages.Heard(heard=False, reason=None) if is_over else self._news(one, now_s)
            if told != one.told and (is_over or now_s - one.told_s >= _TELL_S):
                one.told, one.told_s = told, now_s
                one.viewer.send(told)
            if is_over:
                del self._speaking[number]
        shown = self.info()
        if shown != self._shown:
            self._shown = shown
            self._viewers.changed()

    def _judged(self, viewer: Viewer, now_s: float) -> VoiceVerdict:
        holder = self._floor.holder(now_s)
        if holder is not None:
            self._floor.sounded(holder, self._speaker.sounded_s)
        verdict = self._floor.judge(
            viewer.number,
            now_s,
            may_speak=self._may_speak(viewer),
            is_muted=self._is_muted,
            is_played=self._speaker.problem is None,
        )
        if holder == viewer.number and verdict in (VoiceVerdict.NOT_ALLOWED, VoiceVerdict.MUTED):
            self._speaker.hush()
        return verdict

    def _may_speak(self, viewer: Viewer) -> bool:
        return permissions.may(role_of(viewer, self._turns, self._control), permissions.SPEAK)

    @property
    def _is_muted(self) -> bool:
        switches = self._decisions.switches
        return switches.are_voices_muted or switches.is_blanked

    def _news(self, one: _Speaking, now_s: float) -> messages.Heard:
        match one.verdict:
            case VoiceVerdict.HEARD:
                sounds = now_s - self._speaker.sounded_s < _OVER_S
                return messages.Heard(heard=sounds, reason=None)
            case VoiceVerdict.NOT_ALLOWED:
                reason = _ONLY
            case VoiceVerdict.MUTED:
                reason = _MUTED
            case VoiceVerdict.TAKEN:
                reason = self._taken(now_s)
            case VoiceVerdict.NO_SPEAKER:
                reason = self._speaker.problem or Sentence("speaker.silent")
        return messages.Heard(heard=False, reason=reason)

    def _taken(self, now_s: float) -> Sentence:
        holder = self._floor.holder(now_s)
        other = None if holder is None else self._speaking.get(holder)
        if other is None:
            return Sentence("voice.taken_by_somebody")
        return Sentence("voice.taken", {"name": other.viewer.name})
