"""What the simulated robot hears: the radio, people, itself, and room noise.

Sounds in the flat have a direction; the robot's own sounds are equal in both ears.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ
from wax.robot.simulated.placed_sound import PlacedSound
from wax.robot.simulated.radio import Radio
from wax.robot.simulated.resident import Resident

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.robot.simulated.simulation import Senses
    from wax.robot.simulated.speaker import SimulatedSpeaker
    from wax.robot.simulated.world import World
BLOCK_S = BLOCK_SAMPLES / SAMPLE_RATE_HZ

ROOM_NOISE_RMS = 0.0006
HUM_LEVEL = 0.03
HORN_LEVEL = 0.25
HORN_HZ = (420.0, 525.0)
SPEAKER_GAIN = 0.5
"""The gain from the robot's speaker to its microphone, a hand's breadth away."""
_SPIN = 0.293
"""The fraction of a speed change that a motor completes in each block."""


class SoundMixer:
    """Makes one block of sound after the other, each joining the last without a click."""

    def __init__(
        self, world: World, seed: int = 1, speaker: SimulatedSpeaker | None = None
    ) -> None:
        self._speaker = speaker
        self._radio = PlacedSound(Radio(world.radio), world)
        residents = [Resident(dweller, world) for dweller in world.people]
        self._residents = [(one, PlacedSound(one, world)) for one in residents]
        self._random = np.random.default_rng(seed)
        self._motors = tuple(_Motor(46.0 + 1.5 * wheel, wheel) for wheel in range(4))
        self._horn = _Horn()
        self._bumps: int | None = None
        self._thuds = np.zeros(0)

    def block(self, senses: Senses) -> NDArray[np.int16]:
        """Mix the next `BLOCK_SAMPLES` of what is heard with these `senses`; never clips.

        The shape is ``(n, 2)``, the left ear first.
        """
        said = np.zeros(BLOCK_SAMPLES)
        if self._speaker is not None:
            said = self._speaker.heard(BLOCK_SAMPLES)
        sound = self._random.normal(0.0, ROOM_NOISE_RMS, (BLOCK_SAMPLES, 2))
        sound += self._radio.heard(senses)
        for resident, placed in self._residents:
            resident.listen(said, senses.pose)
            if resident.is_speaking:
                sound += placed.heard(senses)
        sound += self._own(senses, said)[:, None]
        return np.asarray(np.round(32_000.0 * np.tanh(sound)), np.int16)

    def _own(self, senses: Senses, said: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the robot's own sounds; `said` is what its speaker plays."""
        sound = self._bump(senses) + SPEAKER_GAIN * said + self._horn.sound(senses.is_honking)
        for motor, speed_mps in zip(self._motors, senses.wheels_mps, strict=False):
            sound += motor.hum(speed_mps)
        return sound

    def _bump(self, senses: Senses) -> NDArray[np.float64]:
        if self._bumps is not None and senses.bumps > self._bumps:
            thud = _thud(senses.bump_mps, self._random)
            thud[: len(self._thuds)] += self._thuds[: len(thud)]
            self._thuds = thud
        self._bumps = senses.bumps
        now = np.zeros(BLOCK_SAMPLES)
        part = self._thuds[:BLOCK_SAMPLES]
        now[: len(part)] = part
        self._thuds = self._thuds[BLOCK_SAMPLES:]
        return now


class _Motor:
    """The hum of one geared motor: pitch and loudness follow the wheel."""

    def __init__(self, idle_hz: float, phase: float) -> None:
        self._idle_hz = idle_hz
        self._phase = phase
        self._speed_mps = 0.0

    def hum(self, speed_mps: float) -> NDArray[np.float64]:
        old, new = self._speed_mps, self._speed_mps + _SPIN * (abs(speed_mps) - self._speed_mps)
        self._speed_mps = new
        speed = old + (new - old) * np.arange(1, BLOCK_SAMPLES + 1) / BLOCK_SAMPLES
        phase = self._phase + np.cumsum(
            2.0 * np.pi * (self._idle_hz + 280.0 * speed) / SAMPLE_RATE_HZ
        )
        self._phase = float(phase[-1]) % (2.0 * math.pi)
        loudness = HUM_LEVEL * np.minimum(1.0, speed / 0.6)
        return np.asarray(
            loudness * (np.sin(phase) + 0.5 * np.sin(2.0 * phase) + 0.35 * np.sin(5.0 * phase))
        )


class _Horn:
    """Two notes, which fade in and out within one block."""

    def __init__(self) -> None:
        self._at = 0
        self._loudness = 0.0

    def sound(self, is_honking: bool) -> NDArray[np.float64]:
        loudness = HORN_LEVEL if is_honking else 0.0
        fade = np.linspace(self._loudness, loudness, BLOCK_SAMPLES)
        self._loudness = loudness
        time_s = (self._at + np.arange(BLOCK_SAMPLES)) / SAMPLE_RATE_HZ
        self._at = (self._at + BLOCK_SAMPLES) % SAMPLE_RATE_HZ
        return np.asarray(fade * sum(np.sin(2 * np.pi * hz * time_s) for hz in HORN_HZ))


def _thud(impact_mps: float, random: np.random.Generator) -> NDArray[np.float64]:
    time_s = np.arange(round(0.3 * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    rattle = np.convolve(random.normal(0.0, 1.0, len(time_s)), np.full(24, 1 / 24), mode="same")
    body = np.sin(2.0 * np.pi * 78.0 * time_s) * np.exp(-14.0 * time_s)
    crack = rattle * np.exp(-45.0 * time_s)
    soft_start = np.minimum(1.0, time_s / 0.002)
    soft_end = np.minimum(1.0, (0.3 - time_s) / 0.02)
    return np.asarray(
        min(1.0, 0.25 + impact_mps) * (0.7 * body + 0.8 * crack) * soft_start * soft_end
    )
