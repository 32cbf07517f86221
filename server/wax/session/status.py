"""The content of `GET /api/status`."""

from __future__ import annotations

import asyncio
from dataclasses import asdict
from typing import TYPE_CHECKING

from wax import __version__
from wax.protocol.robot_report import ROBOT_VALUES
from wax.telemetry import CountRates

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.fanout.camera import Camera
    from wax.protocol.messages import Report, StopInfo
    from wax.sentence import Sentence
    from wax.session.parts import Parts
    from wax.session.room import Room
    from wax.session.tape_keeper import TapeKeeper
    from wax.session.viewer import Viewer


class Status:
    """Gathers one JSON object from all parts; changes no state."""

    def __init__(
        self, parts: Parts, room: Room, steps: Callable[[], dict[str, dict[str, float]]]
    ) -> None:
        self._parts = parts
        self._room = room
        self._steps = steps
        self._kind = parts.driver.kind
        self._clock = parts.clock
        self._turns = parts.turns
        self._control = parts.control
        self._pipelines = parts.pipelines
        self._video, self._audio = parts.pipelines.video, parts.pipelines.audio
        self._rates = CountRates()

    def sample(self) -> None:
        """Sample the counters for the rates; call about once a second."""
        counts = {f"video.{name}": count for name, count in self._video.counts().items()}
        counts |= {f"audio.{name}": count for name, count in self._audio.counts().items()}
        for camera in self._pipelines.cameras:
            counts |= {
                f"camera {camera.name}.{n}": count for n, count in camera.hub.counts().items()
            }
        self._rates.sample(counts, self._clock.now_s())

    async def run(self) -> None:
        """Sample until cancelled."""
        while True:
            self.sample()
            await asyncio.sleep(1.0)

    def __call__(self) -> dict[str, object]:
        now_s = self._clock.now_s()
        snapshot = self._room.snapshot(now_s)
        ends_s = self._turns.ends_s
        return {
            "version": __version__,
            "viewers": [self._viewer(line.id, line.model_dump()) for line in snapshot.viewers],
            "turn": {
                "number": self._turns.number,
                "operator": self._turns.operator,
                "seconds_left": None if ends_s is None else round(max(ends_s - now_s, 0.0), 2),
            },
            "stop": _stop(snapshot.stop),
            "robot": self._robot(),
            "streams": {
                "video": {
                    "problem": _text(snapshot.video.problem),
                    "undated": _text(snapshot.video.undated),
                    "failures": self._failures("video"),
                    "captured_fps": self._rates.hz("video.captured"),
                    "encoded_fps": {n: self._rates.hz(f"video.{n}") for n in self._video.names},
                    "wanted": self._video.wanted,
                    "dropped": self._video.dropped,
                    "encoder": self._encoder(0),
                },
                "audio": {
                    "problem": _text(snapshot.audio.problem),
                    "failures": self._failures("audio"),
                    "captured_hz": self._rates.hz("audio.captured"),
                    "encoded_hz": self._rates.hz("audio.encoded"),
                    "wanted": self._audio.wanted,
                    "dropped": self._audio.dropped,
                    "channels": self._audio.channels,
                    "channel_fault": self._pipelines.channel_faults.problem,
                    "filled_ms": self._pipelines.blocks.filled_ms,
                    "cut_ms": self._pipelines.blocks.dropped_ms,
                },
            },
            "limits": asdict(self._pipelines.service.limits),
            "cameras": [
                self._camera(camera) | {"encoder": self._encoder(number)}
                for number, camera in enumerate(self._pipelines.cameras, 1)
            ],
            **self._voice(),
            "rooms": self._parts.cluster.status(),
            "tape": _tape(self._parts.tape),
            "hooks": self._parts.hooks.status(),
            "door": self._parts.tunnel.status(),
            "counters": self._parts.counters.snapshot() | self._control.counts(),
            "tasks": len(asyncio.all_tasks()),
            "steps": self._steps(),
        }

    def _camera(self, camera: Camera) -> dict[str, object]:
        """Return the status of a camera other than the driving view."""
        hub = camera.hub
        return {
            "name": camera.name,
            "problem": _text(camera.problem),
            "failures": camera.failures,
            "captured_fps": self._rates.hz(f"camera {camera.name}.captured"),
            "encoded_fps": {
                name: self._rates.hz(f"camera {camera.name}.{name}") for name in hub.names
            },
            "wanted": hub.wanted,
            "dropped": hub.dropped,
        }

    def _encoder(self, number: int) -> dict[str, object] | None:
        """Return the encoder status of the driving view (0) or of another camera."""
        return self._pipelines.encoders[number].status() if self._pipelines.encoders else None

    def _voice(self) -> dict[str, object]:
        """Return the status of the robot's speaker, empty if it has none."""
        speaker = self._parts.speaker
        if speaker is None:
            return {}
        return {
            "voice": {
                "problem": _text(speaker.problem),
                "failures": speaker.failures,
                "lost_ms": speaker.lost_ms,
            }
        }

    def _viewer(self, number: int, line: dict[str, object]) -> dict[str, object]:
        """Return what is known about a viewer, even if their streams fail."""
        viewer = self._parts.viewers.numbered(number)
        if viewer is None:
            return line
        with viewer.boundary:
            return line | self._served(viewer)
        return line

    def _served(self, viewer: Viewer) -> dict[str, object]:
        one_way_s = viewer.link.one_way_s
        report = viewer.report
        return {
            "round_trip_ms": None if one_way_s is None else round(one_way_s * 2000, 1),
            "report": None if report is None else report.model_dump(exclude={"type"}),
            "skew_ms": None if report is None else _skew_ms(report),
            "last_minute": {
                "concealed_ms": round(viewer.concealed_ms.sum, 1),
                "frozen_ms": round(viewer.frozen_ms.sum, 1),
            },
            "streams": viewer.streams.status().entry,
        }

    def _failures(self, stream: str) -> int:
        capture = self._pipelines.captures.get(stream)
        return 0 if capture is None else capture.failures

    def _robot(self) -> dict[str, object]:
        state = self._control.robot_state
        told = state.told
        return {
            **state.extra,  # first, so that a plug-in cannot override the rest
            "kind": self._kind,
            "connected": state.connected,
            "problem": _text(state.said),
            "moving": state.moving,
            "pose": None if state.pose is None else asdict(state.pose),
            "aboard": None if state.aboard is None else asdict(state.aboard),
            "gauges": dict(state.gauges),
            "controls": dict(self._control.control_values),
            **{name: told.get(name) for name in ROBOT_VALUES},
        }


def _text(sentence: Sentence | None) -> str | None:
    return None if sentence is None else str(sentence)


def _stop(stop: StopInfo | None) -> dict[str, object] | None:
    return None if stop is None else {"number": stop.number, "by": str(stop.by)}


def _tape(tape: TapeKeeper | None) -> dict[str, object] | None:
    if tape is None:
        return None
    status = tape.recorder.status()
    return asdict(status) | {"problem": _text(status.problem)}


def _skew_ms(report: Report) -> float | None:
    """Return how much older the sound is than the picture shown with it."""
    sound_ms = None if report.sound is None else report.sound.age_ms
    picture_ms = None if report.picture is None else report.picture.age_ms
    if sound_ms is None or picture_ms is None:
        return None
    return round(sound_ms - picture_ms, 1)
