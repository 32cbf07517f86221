"""The ruler: shifts that are known are read from pictures and sound as an instrument has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from e2e.delay.readings import Pictures, Readings, Sound
from e2e.delay.talking_head import lip_lag
from e2e.delay.talking_head.film import openings
from e2e.delay.talking_head.voice import FPS, RATE_HZ

if TYPE_CHECKING:
    from numpy.typing import NDArray

BEGAN_MS = 1_790_000_000_000.0
BLOCK = RATE_HZ // 100


@dataclass(frozen=True, slots=True)
class Watched:
    """How a viewer gets the film: ages from capture to glass and to ear, and what goes wrong."""

    picture_age_ms: float = 80.0
    sound_age_ms: float = 80.0
    fps: int = 30
    seconds: float = 12.0
    begin_s: float = 0.0
    """Where in the film."""
    voice_ahead_s: float = 0.0
    """How far away in the film the voice is: of other lips."""
    jitter_ms: float = 20.0
    """Each picture is early or late by up to this."""
    dropped: float = 0.2
    """Share of the pictures that never come."""
    noise: float = 0.03
    """Standard deviation of the opening as it is read."""
    rows: int = 31
    """So fine is the reading."""
    pauses: int = 3
    """Pieces of 30…300 ms of which nothing was recorded."""
    frozen_s: float = 0.0
    """In the middle no picture comes for so long."""
    seed: int = 0

    def readings(self, voice: NDArray[np.int16]) -> Readings:
        chance = np.random.default_rng(self.seed)
        mouths = openings(voice)
        apart = FPS // self.fps
        numbers = np.arange(chance.integers(apart), round(self.seconds * FPS), apart)
        numbers = numbers[chance.random(len(numbers)) >= self.dropped]
        middle = self.seconds / 2
        numbers = numbers[np.abs(numbers / FPS - middle) >= self.frozen_s / 2]
        begin = round(self.begin_s * FPS)
        mouth = mouths[(begin + numbers) % len(mouths)]
        mouth = np.clip(mouth + self.noise * chance.normal(size=len(mouth)), 0, 1)
        mouth = np.rint(mouth * self.rows) / self.rows
        late_ms = chance.uniform(-self.jitter_ms, self.jitter_ms, len(numbers))
        at_ms = np.sort(BEGAN_MS + numbers * 1000 / FPS + self.picture_age_ms + late_ms)

        # From 2 s earlier, so that there is sound for the first picture whatever its age.
        count = round((self.seconds + 2) * 100)
        first = (begin * RATE_HZ) // FPS + round((self.voice_ahead_s - 2) * RATE_HZ)
        places = (first + np.arange(count * BLOCK)) % len(voice)
        power = (voice[places] / 32768.0) ** 2
        rms = np.sqrt(power.reshape(count, BLOCK).mean(axis=1))
        start_ms = BEGAN_MS + (np.arange(count) - 200) * 10 + self.sound_age_ms
        heard = (start_ms >= BEGAN_MS) & (start_ms < BEGAN_MS + self.seconds * 1000)
        for _ in range(self.pauses):
            pause = chance.integers(count)
            heard[pause : pause + chance.integers(3, 30)] = False
        return Readings(
            opened_ms=BEGAN_MS,
            pictures=Pictures(
                at_ms=at_ms.tolist(),
                stamp_ms=[None] * len(at_ms),
                mouth=mouth.tolist(),
                width=[640] * len(at_ms),
            ),
            sound=Sound(
                start_ms=start_ms[heard].tolist(),
                rms=rms[heard].tolist(),
                tone=[0.0] * int(heard.sum()),
                burst=[0.0] * int(heard.sum()),
            ),
        )


def lag_of(readings: Readings) -> float | None:
    found = lip_lag(readings, from_ms=BEGAN_MS, to_ms=BEGAN_MS + 60_000)
    return None if found is None else found.lag_ms


shared = settings(deadline=None, derandomize=True, max_examples=30)
"""The same examples in each run, because chance can always build a worse one than was seen."""

shifts_ms = st.floats(-300, 700)
begins_s = st.floats(0, 30)
seeds = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize(
    ("fps", "seconds", "dropped", "within_ms"),
    [(30, 12.0, 0.2, 10), (5, 12.0, 0.2, 25), (1, 30.0, 0.0, 40)],
)
@shared
@given(shift_ms=shifts_ms, begin_s=begins_s, seed=seeds)
def test_a_shift_is_read_back(
    voice: NDArray[np.int16],
    *,
    fps: int,
    seconds: float,
    dropped: float,
    within_ms: float,
    shift_ms: float,
    begin_s: float,
    seed: int,
) -> None:
    """Late, lost and badly read: within 10 ms at 30 pictures a second, 25 at 5, 40 at one."""
    watched = Watched(
        sound_age_ms=80 + shift_ms,
        fps=fps,
        seconds=seconds,
        dropped=dropped,
        begin_s=begin_s,
        seed=seed,
    )
    found = lip_lag(watched.readings(voice), from_ms=BEGAN_MS, to_ms=BEGAN_MS + 60_000)
    assert found is not None
    assert abs(found.lag_ms - shift_ms) < within_ms
    if fps == 30:
        assert found.correlation > 0.8
        assert 200 < found.n <= 360


@pytest.mark.parametrize("fps", [30, 15, 10, 5, 3])
def test_the_lag_is_the_difference_of_the_ages_at_any_frame_rate(
    voice: NDArray[np.int16], fps: int
) -> None:
    """It reads as the test card's skew does, without half a frame's interval in it."""
    lags_ms = [
        lag_of(
            Watched(
                picture_age_ms=410, sound_age_ms=560, fps=fps, seconds=30, jitter_ms=0, seed=seed
            ).readings(voice)
        )
        for seed in range(4)
    ]
    assert np.mean([lag_ms for lag_ms in lags_ms if lag_ms is not None]) == pytest.approx(
        150, abs=3
    )


def test_a_frozen_picture_says_nothing(voice: NDArray[np.int16]) -> None:
    """A picture that stands for 4 s does not move the lag."""
    lag_ms = lag_of(Watched(sound_age_ms=200, frozen_s=4).readings(voice))
    assert lag_ms == pytest.approx(120, abs=10)


def test_only_the_time_asked_for_counts(voice: NDArray[np.int16]) -> None:
    """Of two halves with different lags each is read for itself."""
    one = Watched(sound_age_ms=80, seconds=15, pauses=0).readings(voice)
    other = Watched(sound_age_ms=480, seconds=15, pauses=0).readings(voice)
    both = one.model_copy(deep=True)
    for name in ("at_ms", "mouth"):
        more = [x + 20_000 if name == "at_ms" else x for x in getattr(other.pictures, name)]
        getattr(both.pictures, name).extend(more)
    both.sound.start_ms += [start_ms + 20_000 for start_ms in other.sound.start_ms]
    both.sound.rms += other.sound.rms
    first = lip_lag(both, from_ms=BEGAN_MS, to_ms=BEGAN_MS + 15_000)
    second = lip_lag(both, from_ms=BEGAN_MS + 20_000, to_ms=BEGAN_MS + 35_000)
    assert first is not None
    assert second is not None
    assert first.lag_ms == pytest.approx(0, abs=10)
    assert second.lag_ms == pytest.approx(400, abs=10)


@shared
@given(st.sampled_from([30, 10, 5]), begins_s, st.floats(4, 30), seeds)
def test_another_voice_is_not_believed(
    voice: NDArray[np.int16], fps: int, begin_s: float, ahead_s: float, seed: int
) -> None:
    """Lips and a voice from elsewhere in the film have no lag."""
    watched = Watched(fps=fps, begin_s=begin_s, voice_ahead_s=ahead_s, seed=seed)
    assert lag_of(watched.readings(voice)) is None


def test_another_voice_is_hardly_ever_believed_at_one_picture_a_second(
    voice: NDArray[np.int16],
) -> None:
    """Of 100 strange voices over 12 s at most 4 get a lag, though there are but 12 pictures."""
    chance = np.random.default_rng(53)
    believed = 0
    for seed in range(100):
        begin_s, ahead_s = chance.uniform(0, 30), chance.uniform(4, 30)
        watched = Watched(
            fps=1, dropped=0, begin_s=begin_s, voice_ahead_s=ahead_s, pauses=0, seed=seed
        )
        believed += lag_of(watched.readings(voice)) is not None
    assert believed <= 4


def test_a_lag_too_far_away_is_none(voice: NDArray[np.int16]) -> None:
    """Beyond 1.5 s nothing is found, rather than something at the edge."""
    assert lag_of(Watched(sound_age_ms=1560, pauses=0).readings(voice)) is not None
    for far_ms in (1620, 1780, 2580):
        assert lag_of(Watched(sound_age_ms=far_ms, pauses=0).readings(voice)) is None


def test_nothing_to_judge_is_none(voice: NDArray[np.int16]) -> None:
    """No face, still lips, no sound, little of it, silence, or hardly a picture: no lag."""
    whole = Watched().readings(voice)
    assert lag_of(whole) is not None
    count = len(whole.pictures.at_ms)
    faceless = whole.pictures.model_copy(update={"mouth": [None] * count})
    still = whole.pictures.model_copy(
        update={"mouth": [0.3, 0.32] * (count // 2) + [0.3] * (count % 2)}
    )
    silent = whole.sound.model_copy(update={"rms": [0.0] * len(whole.sound.rms)})
    brief = Sound(
        start_ms=whole.sound.start_ms[:400],
        rms=whole.sound.rms[:400],
        tone=whole.sound.tone[:400],
        burst=whole.sound.burst[:400],
    )
    for update in (
        {"pictures": Pictures()},
        {"pictures": faceless},
        {"pictures": still},
        {"sound": Sound()},
        {"sound": silent},
        {"sound": brief},
    ):
        assert lag_of(whole.model_copy(update=update)) is None
    assert lip_lag(whole, from_ms=BEGAN_MS, to_ms=BEGAN_MS + 400) is None
