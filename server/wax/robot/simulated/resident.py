"""Somebody who lives in the flat, and answers when they are spoken to.

Pure, except for reading the recorded answers in `answers`.
"""

from __future__ import annotations

import math
from functools import cache
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Final

import av
import numpy as np

from wax.capture.source import SAMPLE_RATE_HZ
from wax.robot.simulated.through_walls import muffled
from wax.voice.limiter import SilenceGate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.driver.interface import Pose
    from wax.robot.simulated.world import Dweller, World

HEARS_M: Final = 4.0
"""Residents answer only within this distance, and not through a wall."""
ANSWER_RMS: Final = 0.15
"""An answer's loudness at one metre, full scale being 1."""
_WORDS: Final = SAMPLE_RATE_HZ // 2
"""At least this much sound, including short pauses, counts as speech and not as a knock."""
_PAUSE: Final = SAMPLE_RATE_HZ * 4 // 10
"""The pause before an answer, after the 0.3 s that may be a pause inside a sentence."""
_FOLDER: Final = Path(__file__).with_name("answers")


class Resident:
    """Hears what the robot's speaker plays, and answers once it pauses: an `Emitter`."""

    def __init__(self, dweller: Dweller, world: World) -> None:
        self.place = dweller.x, dweller.y
        self._world = world
        self._answers = cycle(answers(dweller.name))
        self._gate = SilenceGate()
        self._heard = self._quiet = 0
        self._left = (np.zeros(0), np.zeros(0))

    @property
    def is_speaking(self) -> bool:
        return len(self._left[0]) > 0

    def listen(self, said: NDArray[np.float64], pose: Pose) -> None:
        """Listen to the speech of a robot at `pose`; 1 is full scale."""
        samples = np.asarray(np.round(said * 32_767.0), np.int16)
        if self._gate.opens(samples) and self._is_near(pose):
            self._heard += len(said)
            self._quiet = 0
            return
        self._quiet += len(said)
        if self._quiet < _PAUSE:
            return
        if self._heard >= _WORDS and not self.is_speaking:
            self._left = next(self._answers)
        self._heard = 0

    def play(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        now = [np.pad(track[:count], (0, max(0, count - len(track)))) for track in self._left]
        self._left = (self._left[0][count:], self._left[1][count:])
        return now[0], now[1]

    def _is_near(self, pose: Pose) -> bool:
        x, y = self.place
        if math.hypot(x - pose.x_m, y - pose.y_m) > HEARS_M:
            return False
        return self._world.walls_between(pose.x_m, pose.y_m, x, y) == 0


@cache
def answers(name: str) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Load a resident's answers: as heard at one metre, and as heard through a wall."""
    found = []
    for path in sorted(_FOLDER.glob(f"{name}_*.opus")):
        with av.open(str(path)) as file:
            frames = [frame.to_ndarray().reshape(-1) for frame in file.decode(audio=0)]
        sound = np.concatenate(frames).astype(np.float64)
        sound *= ANSWER_RMS / np.sqrt(np.mean(sound**2))
        found.append((sound, muffled(sound)))
    return found
