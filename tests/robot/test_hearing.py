"""What the simulated robot hears."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest

from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ
from wax.driver.interface import Pose
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.hearing import BLOCK_S, SoundMixer
from wax.robot.simulated.placed_sound import reach
from wax.robot.simulated.radio import LEVEL_RMS, tune
from wax.robot.simulated.simulation import Senses

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

WORLD = furnished_flat()
QUIET = Pose(9.0, 8.0, 0.0)


def near_radio(distance_m: float, facing: bool = True) -> Pose:
    """Return a pose at this distance from the radio, facing it or facing away."""
    bearing = math.radians(-143.0)
    x = WORLD.radio[0] + distance_m * math.cos(bearing)
    y = WORLD.radio[1] + distance_m * math.sin(bearing)
    return Pose(x, y, bearing + math.pi if facing else bearing)


def hear_both(moments: Iterable[Senses]) -> NDArray[np.float64]:
    mixer = SoundMixer(WORLD)
    return np.concatenate([mixer.block(senses) for senses in moments]) / 32768.0


def hear(moments: Iterable[Senses]) -> NDArray[np.float64]:
    """Return what the left ear hears."""
    return hear_both(moments)[:, 0]


def standing(pose: Pose, seconds: float = 0.5, speed_mps: float = 0.0) -> list[Senses]:
    count = round(seconds / BLOCK_S)
    return [Senses(n * BLOCK_S, pose, wheels_mps=(speed_mps, speed_mps)) for n in range(count)]


def level_db(sound: NDArray[np.float64]) -> float:
    return float(20.0 * np.log10(np.sqrt(np.mean(sound**2))))


def loudest_hz(sound: NDArray[np.float64]) -> float:
    spectrum = np.abs(np.fft.rfft(sound * np.hanning(len(sound))))
    return float(np.argmax(spectrum) * SAMPLE_RATE_HZ / len(sound))


def test_the_radio_falls_by_6_db_a_doubling() -> None:
    """Throughout the living room, twice the distance is 6 dB less."""
    levels = [level_db(hear(standing(near_radio(d)))) for d in (0.5, 1.0, 2.0, 4.0)]
    steps = [a - b for a, b in pairwise(levels)]
    assert all(5.5 < step_db < 6.5 for step_db in steps)


def test_at_the_start_the_radio_is_heard() -> None:
    """Where the robot starts, the radio is at least 15 dB above the noise of the room."""
    assert level_db(hear(standing(WORLD.start))) > level_db(hear(standing(QUIET))) + 15.0


def test_walls_muffle_the_radio() -> None:
    """Behind a wall the radio is at least 6 dB quieter than in the open, and duller."""
    east, north = WORLD.radio
    behind, open_air = Pose(east + 1.5, north, math.pi), near_radio(1.5)
    assert reach(WORLD, WORLD.radio, behind, math.pi).walls == 1
    assert reach(WORLD, WORLD.radio, open_air, open_air.heading_rad).walls == 0

    def brightness_hz(sound: NDArray[np.float64]) -> float:
        power = np.abs(np.fft.rfft(sound)) ** 2
        power[: len(sound) // 500] = 0.0
        return float((power * np.fft.rfftfreq(len(sound), 1 / SAMPLE_RATE_HZ)).sum() / power.sum())

    free, walled = hear(standing(open_air)), hear(standing(behind))
    assert level_db(walled) < level_db(free) - 6.0
    assert brightness_hz(walled) < 0.85 * brightness_hz(free)


def test_turning_reveals_where_the_radio_is() -> None:
    """The radio is loudest straight ahead of the head, and clearly quieter from behind."""
    ahead, behind = near_radio(1.5), near_radio(1.5, facing=False)
    assert level_db(hear(standing(ahead))) > level_db(hear(standing(behind))) + 6.0
    straight = reach(WORLD, WORLD.radio, ahead, ahead.heading_rad)
    panned = reach(WORLD, WORLD.radio, ahead, ahead.heading_rad + 1.0)
    assert panned.gain < straight.gain
    assert panned.bearing_rad == pytest.approx(straight.bearing_rad - 1.0)


@pytest.mark.parametrize("turned_rad", [0.2, 0.8, 1.5])
def test_the_nearer_ear_hears_it_sooner_and_louder(turned_rad: float) -> None:
    """With the radio on the left, the left ear is louder; on the right, the right one."""
    ahead = near_radio(1.5)
    for side, sign in ((0, -1.0), (1, 1.0)):
        pose = Pose(ahead.x_m, ahead.y_m, ahead.heading_rad + sign * turned_rad)
        both = hear_both(standing(pose, 0.2))
        near, far = both[:, side].copy(), both[:, 1 - side].copy()
        assert level_db(near) > level_db(far) + 0.3
        alike = [np.dot(near[40:-40], np.roll(far, -n)[40:-40]) for n in range(-40, 41)]
        assert np.argmax(alike) - 40 > 3


def test_the_robot_hears_itself_in_both_ears_alike() -> None:
    """The motors have no direction: only the noise of the room differs."""
    both = hear_both(standing(QUIET, speed_mps=0.4))[SAMPLE_RATE_HZ // 4 :]
    assert level_db(both[:, 0] - both[:, 1]) < level_db(both[:, 0]) - 15.0


def test_each_wheel_has_a_motor_that_hums() -> None:
    """Four wheels are louder than two, whichever way each turns."""
    two = standing(QUIET, speed_mps=0.4)
    four = [replace(one, wheels_mps=(-0.4, 0.4, 0.4, -0.4)) for one in two]
    assert level_db(hear(four)) > level_db(hear(two)) + 1.0


def test_the_motors_rise_with_speed() -> None:
    """The hum is silent at rest, and the faster the wheels, the louder and higher."""
    still, slow, fast = (
        hear(standing(QUIET, speed_mps=v))[SAMPLE_RATE_HZ // 4 :] for v in (0.0, 0.2, 0.6)
    )
    assert level_db(still) + 10.0 < level_db(slow) < level_db(fast) - 5.0
    assert loudest_hz(slow) == pytest.approx(103.0, abs=5.0)
    assert loudest_hz(fast) == pytest.approx(215.0, abs=5.0)


def test_a_collision_is_a_thud() -> None:
    """A bump is one short, loud sound, louder if harder, and over after half a second."""

    def bumped(impact_mps: float) -> NDArray[np.float64]:
        before = standing(QUIET, 0.5)
        after = [Senses(0.5 + n * BLOCK_S, QUIET, bumps=1, bump_mps=impact_mps) for n in range(70)]
        return hear([*before, *after])

    hard, soft = bumped(0.6), bumped(0.1)
    thud = slice(SAMPLE_RATE_HZ // 2, SAMPLE_RATE_HZ * 6 // 10)
    assert level_db(hard[thud]) > level_db(hard[: thud.start]) + 30.0
    assert level_db(hard[thud]) > level_db(soft[thud]) + 3.0
    assert level_db(hard[-SAMPLE_RATE_HZ // 4 :]) < level_db(hard[: thud.start]) + 3.0


def test_an_old_bump_is_not_heard_by_a_new_microphone() -> None:
    """A microphone opened after a collision does not hear it."""
    late = hear([Senses(0.0, QUIET, bumps=9, bump_mps=0.6)] * 20)
    assert level_db(late) < -50.0


def test_no_click_and_no_clipping() -> None:
    """While everything changes at once, block borders are as smooth as the sound inside."""

    def wild(n: int) -> Senses:
        return Senses(
            n * BLOCK_S,
            Pose(1.1 + n * 0.007, 0.9 + n * 0.005, n * 0.05),
            wheels_mps=(0.6 * math.sin(n / 20), 0.6 * math.cos(n / 15), 0.6, -0.6),
            bumps=n // 100,
            bump_mps=0.6,
        )

    sound = hear(map(wild, range(250)))
    assert np.abs(sound).max() < 0.98
    bend = np.abs(np.diff(sound, 2))
    places = np.arange(len(bend)) % BLOCK_SAMPLES
    border = (places == BLOCK_SAMPLES - 1) | (places == BLOCK_SAMPLES - 2)
    assert np.percentile(bend[border], 99) < 1.3 * np.percentile(bend[~border], 99)
    assert bend[border].max() <= bend[~border].max()


def test_the_tune_is_a_loop_at_its_level() -> None:
    """The end of the tune meets its beginning, and its level is LEVEL_RMS."""
    clear, muffled = tune()
    assert np.sqrt(np.mean(clear.astype(float) ** 2)) == pytest.approx(LEVEL_RMS, rel=0.01)
    for song in (clear, muffled):
        seam = abs(float(song[0]) - float(song[-1]))
        assert seam <= np.abs(np.diff(song)).max()
    assert len(clear) == len(muffled)


def test_the_same_moments_sound_the_same() -> None:
    """Sound depends only on the seed and the events."""
    moments = standing(WORLD.start, 0.2, speed_mps=0.3)
    assert np.array_equal(hear(moments), hear(moments))
