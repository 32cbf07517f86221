"""How well the radio's direction is heard in what a viewer's decoder gives."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Final

import numpy as np

from e2e.harness.direction import lateral_deg
from e2e.harness.listener import Listener
from wax.capture.source import SAMPLE_RATE_HZ
from wax.config.settings import AudioSettings
from wax.driver.interface import Pose
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.hearing import BLOCK_S, ROOM_NOISE_RMS
from wax.robot.simulated.motion import RADIUS_M
from wax.robot.simulated.placed_sound import reach
from wax.robot.simulated.radio import LEVEL_RMS
from wax.robot.simulated.simulation import Senses
from wax.streams.rendition_ladder import sound_encodings

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.congestion.allocation import SoundEncoding

LISTENS_S: Final = 2.0
_SETTLES_S: Final = 0.2
LEAST_OFF_DEG: Final = 10.0
WITHIN_DEG: Final = 20.0
SHARE: Final = 0.9


def stereo_encodings() -> list[SoundEncoding]:
    """Return the encodings in stereo as shipped, the shortest packets first."""
    audio = AudioSettings()
    found = (sound_encodings(one, audio.channels) for one in audio.encodings)
    return [one for encodings in found for one in encodings if one.channels > 1]


def errors(encoding: SoundEncoding, n: int, seed: int = 2004) -> tuple[list[float], int]:
    """Return by how many degrees each direction is wrong, and how often the side is."""
    errors_deg: list[float] = []
    wrong = 0
    for number, (pose, lateral) in enumerate(_poses(n, seed)):
        listener = Listener(furnished_flat(), encoding, seed=number)
        # Whoever comes in hears the radio's tune from the beginning: not all at the same note.
        begin = number % 7 * round(1.3 / BLOCK_S)
        blocks = begin + round((_SETTLES_S + LISTENS_S) / BLOCK_S)
        heard = np.concatenate([listener.hear(Senses(at * BLOCK_S, pose)) for at in range(blocks)])
        found = lateral_deg(heard[-round(LISTENS_S * SAMPLE_RATE_HZ) :])
        wrong += found is None or found * lateral <= 0
        errors_deg.append(180.0 if found is None else abs(found - lateral))
    return errors_deg, wrong


def _poses(n: int, seed: int) -> Iterator[tuple[Pose, float]]:
    """Give places where the robot can stand, all over the flat, with the radio to one side.

    There the radio is at least as loud as the noise of the room: behind four walls there is nothing
    to hear. With each comes how far to the left of the median plane it is, in degrees.
    """
    world, chance = furnished_flat(), random.Random(seed)
    while n > 0:
        x, y = chance.uniform(0.0, world.width), chance.uniform(0.0, world.depth)
        heading_rad = chance.uniform(-math.pi, math.pi)
        bearing_rad = math.atan2(world.radio[1] - y, world.radio[0] - x) - heading_rad
        lateral = math.degrees(math.asin(math.sin(bearing_rad)))
        pose = Pose(x, y, heading_rad)
        loudness = LEVEL_RMS * reach(world, world.radio, pose, heading_rad).gain
        is_heard = loudness >= ROOM_NOISE_RMS and abs(lateral) >= LEAST_OFF_DEG
        if is_heard and world.nearest_surface(x, y)[0] >= RADIUS_M:
            n -= 1
            yield pose, lateral
