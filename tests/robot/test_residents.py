"""People in the flat, who answer anybody who speaks to them through the robot."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ
from wax.driver.interface import Pose
from wax.robot.simulated import resident
from wax.robot.simulated.flat import ADA, BEN, furnished_flat
from wax.robot.simulated.hearing import BLOCK_S, SPEAKER_GAIN, SoundMixer
from wax.robot.simulated.resident import ANSWER_RMS, HEARS_M, Resident
from wax.robot.simulated.simulation import Senses
from wax.robot.simulated.speaker import SimulatedSpeaker

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from wax.robot.simulated.world import Dweller

WORLD = furnished_flat()
FOLDER: Path = resident._FOLDER
VOICE = (np.random.default_rng(1).normal(0, 2000, SAMPLE_RATE_HZ * 6 // 10)).astype(np.int16)
SAID_S = len(VOICE) / SAMPLE_RATE_HZ


def before(who: Dweller, distance_m: float, bearing_rad: float = -1.0) -> Pose:
    """Return a pose at this distance from somebody, facing them."""
    x = who.x + distance_m * math.cos(bearing_rad)
    y = who.y + distance_m * math.sin(bearing_rad)
    return Pose(x, y, bearing_rad + math.pi)


def answering(pose: Pose, said: NDArray[np.int16] = VOICE, seconds: float = 2.0) -> list[bool]:
    """Return for each 10 ms whether anybody speaks, while the robot at `pose` plays `said`."""
    people = [Resident(who, WORLD) for who in WORLD.people]
    blocks = np.pad(said / 32_768.0, (0, round(seconds * SAMPLE_RATE_HZ))).reshape(
        -1, BLOCK_SAMPLES
    )
    speaking = []
    for block in blocks:
        for one in people:
            one.listen(block, pose)
        speaking.append(any(one.is_speaking for one in people))
        for one in people:
            one.play(BLOCK_SAMPLES)
    return speaking


def answered(pose: Pose) -> NDArray[np.float64]:
    """Return the sound of the people alone, while the robot stands at `pose` and speaks."""
    speaker = SimulatedSpeaker()
    with_voice, without = SoundMixer(WORLD, speaker=speaker), SoundMixer(WORLD)
    heard = []
    for number in range(160):
        piece = VOICE[number * BLOCK_SAMPLES :][:BLOCK_SAMPLES]
        if len(piece):
            speaker.write(piece)
        senses = Senses(number * BLOCK_S, pose)
        own = np.pad(piece / 32_768.0, (0, BLOCK_SAMPLES - len(piece))) * SPEAKER_GAIN
        both = [np.arctanh(mixer.block(senses) / 32_000.0) for mixer in (with_voice, without)]
        heard.append((both[0] - both[1]).reshape(BLOCK_SAMPLES, -1).mean(axis=1) - own)
    return np.concatenate(heard)


def loudness(sound: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(sound**2)))


@pytest.mark.parametrize("who", [ADA, BEN])
def test_people_answer_after_a_pause(who: Dweller) -> None:
    """An answer begins 0.5 to 1 s after the voice has ended."""
    loud = answering(before(who, 1.5), seconds=4.0)
    begin_s, end_s = loud.index(True) * BLOCK_S, (len(loud) - loud[::-1].index(True)) * BLOCK_S
    assert SAID_S + 0.5 < begin_s < SAID_S + 1.0
    assert 0.5 < end_s - begin_s < 2.5


def test_at_the_start_somebody_answers() -> None:
    """Somebody at the starting point answers."""
    assert loudness(answered(WORLD.start)) > 0.001


@pytest.mark.parametrize(
    "pose",
    [
        before(ADA, HEARS_M + 0.2, -0.8),
        Pose(ADA.x, 5.2, 0.0),
        Pose(9.0, 8.0, 0.0),
        Pose(5.8, 7.0, 0.0),
    ],
    ids=["too far", "behind a wall", "in the bath", "in the study"],
)
def test_people_who_are_not_near_do_not_answer(pose: Pose) -> None:
    """Only somebody near, in the same room, answers."""
    assert not any(answering(pose))


@pytest.mark.parametrize(
    "said",
    [VOICE[:0], VOICE[: SAMPLE_RATE_HZ // 10], VOICE // 1000],
    ids=["nothing", "a knock", "hardly anything"],
)
def test_only_speech_is_answered(said: NDArray[np.int16]) -> None:
    """Neither silence nor a knock is answered."""
    assert not any(answering(before(ADA, 1.0), said))


def test_the_pauses_in_a_sentence_are_not_answered() -> None:
    """A pause of 1/3 s does not end a sentence."""
    pause = np.zeros(SAMPLE_RATE_HZ // 3 // BLOCK_SAMPLES * BLOCK_SAMPLES, np.int16)
    said = np.concatenate((VOICE, pause, VOICE))
    loud = answering(before(ADA, 1.0), said)
    assert loud.index(True) * BLOCK_S > len(said) / SAMPLE_RATE_HZ + 0.5


def test_an_answer_falls_by_6_db_a_doubling() -> None:
    """At four times the distance it is 12 dB quieter."""
    near, far = (20 * math.log10(loudness(answered(before(ADA, d)))) for d in (0.75, 3.0))
    assert 11.0 < near - far < 13.0


def test_everybody_has_three_answers() -> None:
    """All have the same level, and together at most 100 kB."""
    for who in WORLD.people:
        one = Resident(who, WORLD)
        heard = []
        for _ in range(3):
            assert not one.is_speaking
            for block in (*VOICE.reshape(-1, BLOCK_SAMPLES), *np.zeros((75, BLOCK_SAMPLES))):
                one.listen(block / 32_768.0, before(who, 1.0))
            clear, through_a_wall = one.play(4 * SAMPLE_RATE_HZ)
            said = np.trim_zeros(clear)
            assert loudness(said) == pytest.approx(ANSWER_RMS, rel=0.05)
            assert loudness(through_a_wall) < 0.9 * loudness(clear)
            heard.append(len(said))
        assert len(set(heard)) == 3
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) <= 100_000
