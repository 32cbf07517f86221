"""The simulated robot's microphone as an `AudioSource`."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final

from wax.capture.source import REST_S, Sound
from wax.errors import SourceError
from wax.robot.simulated.frame_timer import FrameTimer
from wax.robot.simulated.hearing import BLOCK_S, SoundMixer

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.robot.simulated.simulation import Senses
    from wax.robot.simulated.speaker import SimulatedSpeaker
    from wax.robot.simulated.world import World


class SimulatedMicrophone:
    """Delivers what the robot hears in blocks of 10 ms; `listen` returns its current state.

    It hears the robot's own `speaker`, too.
    """

    rest_s: Final = REST_S

    def __init__(
        self,
        clock: Clock,
        *,
        world: World,
        listen: Callable[[], Senses],
        speaker: SimulatedSpeaker | None = None,
    ) -> None:
        self._clock = clock
        self._world = world
        self._listen = listen
        self._speaker = speaker
        self._closed = threading.Event()
        self._mixer: SoundMixer | None = None
        self._pacer: FrameTimer | None = None

    def open(self) -> None:
        self._closed.clear()
        self._mixer = SoundMixer(self._world, speaker=self._speaker)
        self._pacer = self._make_pacer()

    def read(self) -> Sound:
        if self._mixer is None or self._pacer is None:
            raise SourceError("The robot's microphone was read before it was opened.")
        heard_s = self._pacer.beat()
        samples = self._mixer.block(self._listen())
        return Sound(samples=samples, captured_s=heard_s - BLOCK_S)

    def catch_up(self) -> None:
        self._pacer = self._make_pacer()
        if self._speaker is not None:
            self._speaker.close()

    def close(self) -> None:
        self._closed.set()
        self._mixer = None
        self._pacer = None

    def _make_pacer(self) -> FrameTimer:
        return FrameTimer(BLOCK_S, self._clock, self._closed.wait)
