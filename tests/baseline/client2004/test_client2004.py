"""The model of the 2004 client: its parts, and the shape of the thesis's Figures 5.31 to 5.44."""

from __future__ import annotations

import itertools
from dataclasses import replace
from random import Random
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.baseline.client2004.client import Client, Heard, Listening
from tests.baseline.client2004.path import SyntheticPath
from tests.baseline.client2004.scenes import RECORDER, SCENES, Scene
from tests.baseline.client2004.source import Recorder, SharedMemory
from tests.baseline.client2004.table import (
    CLEAN_PER_S,
    MU_LENGTHS_MS,
    WITHOUT_FRAGMENTS,
    agreement,
    differences,
    hear,
    is_clean,
)
from tests.examples import at_length

if TYPE_CHECKING:
    from tests.baseline.client2004.path import Path

BY_NAME = {scene.name: scene for scene in SCENES}
PLAIN = Client()


def _steady(delay_ms: float) -> SyntheticPath:
    return SyntheticPath(delay_ms, delay_ms, 0.0, delay_ms)


def _listen(
    mu_ms: float,
    path: Path,
    *,
    recorder: Recorder = WITHOUT_FRAGMENTS,
    client: Client = PLAIN,
    seed: int = 0,
) -> Heard:
    return Listening(
        mu_ms=mu_ms,
        recorder=recorder,
        path=path,
        client=client,
        chance=Random(seed),
        seconds=60.0,
        from_s=5.0,
    ).run()


# --- the shape of the figures ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "clean_from_ms"),
    [
        ("LAN", 300),
        ("campus", 400),
        # The thesis has one in 2 s at 300 ms; this model does not, and the table says so.
        *at_length(("same machine", 200), ("Internet, Linux", 300), ("Internet, Windows", 500)),
    ],
)
def test_pauses_up_to_a_length_and_none_from_there_on(name: str, clean_from_ms: int) -> None:
    """The model has pauses where the thesis has them, and nowhere else."""
    clean = [is_clean(hear(BY_NAME[name], mu_ms)) for mu_ms in MU_LENGTHS_MS]
    assert clean == [mu_ms >= clean_from_ms for mu_ms in MU_LENGTHS_MS]
    java_2 = replace(BY_NAME[name], client=Client(block_ms=256.0))
    assert is_clean(hear(java_2, 500))  # Figure 5.43


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_pauses_and_silence_fall_as_the_mu_grows(scene: Scene) -> None:
    """On every connection a longer MU loses no more sound and pauses no more often.

    By time a long pause hides the next, so from 100 to 200 ms they fall on the LAN alone; over as
    many blocks, which is the axis of Figures 5.31 to 5.44, by a quarter or more at each step.
    """
    all_heard = [hear(scene, mu_ms) for mu_ms in MU_LENGTHS_MS]
    assert all_heard[0].pauses_per_s > 1.5
    assert all_heard[0].silence > 0.02
    assert is_clean(all_heard[-1])
    assert all_heard[-1].silence < 0.001
    for shorter, longer in itertools.pairwise(all_heard):
        assert longer.silence <= shorter.silence + 0.002
        assert longer.pauses_per_s <= shorter.pauses_per_s + CLEAN_PER_S
        if not is_clean(shorter):
            assert longer.pauses_per_block < 0.75 * shorter.pauses_per_block


@pytest.mark.full
@pytest.mark.parametrize("hand_over_ms", [2.5, 3.0, 4.0])
def test_the_shape_does_not_hang_on_the_one_value_that_nobody_wrote_down(
    hand_over_ms: float,
) -> None:
    """Anything from 2.5 to 4 ms between two MUs of one fragment gives the same cells."""
    recorder = Recorder(fragment_ms=RECORDER.fragment_ms, hand_over_ms=hand_over_ms)
    for scene in SCENES:
        clean = [is_clean(hear(scene, mu_ms, recorder=recorder)) for mu_ms in MU_LENGTHS_MS]
        assert clean == [is_clean(hear(scene, mu_ms)) for mu_ms in MU_LENGTHS_MS], scene.name


@pytest.mark.full
@pytest.mark.parametrize(("least_ms", "most_ms"), [(200.0, 350.0), (250.0, 350.0), (300.0, 350.0)])
def test_the_shape_does_not_hang_on_the_exact_turn_round_of_windows(
    least_ms: float, most_ms: float
) -> None:
    """Neighbouring ranges give the same cells on both connections with Windows."""
    for name in ("campus", "Internet, Windows"):
        client = Client(least_turn_ms=least_ms, most_turn_ms=most_ms)
        scene = replace(BY_NAME[name], client=client)
        clean = [is_clean(hear(scene, mu_ms)) for mu_ms in MU_LENGTHS_MS]
        assert clean == [is_clean(hear(BY_NAME[name], mu_ms)) for mu_ms in MU_LENGTHS_MS], name


@pytest.mark.parametrize("name", ["LAN", *at_length("same machine", "Internet, Linux")])
def test_the_printed_delays_alone_make_no_pauses(name: str) -> None:
    """Without the card's fragments nothing pauses: the thesis's delays alone explain no pause."""
    for mu_ms in MU_LENGTHS_MS:
        assert is_clean(hear(BY_NAME[name], mu_ms, recorder=WITHOUT_FRAGMENTS))


def test_where_it_does_not_reproduce_is_said() -> None:
    """The one cell in which model and thesis differ is named."""
    named = [line for line in differences() if line.endswith("model none.")]
    assert [line.partition(":")[0] for line in named] == ["Internet, Linux, 300 ms"]
    agree, told = agreement()
    assert agree == told - 1


# --- the parts ---------------------------------------------------------------------------------

recorders = st.builds(Recorder, st.sampled_from([0.0, 128.0, 512.0]), st.floats(0, 20))


@given(recorders, st.sampled_from(MU_LENGTHS_MS))
def test_an_mu_is_ready_when_its_last_fragment_is(recorder: Recorder, mu_ms: int) -> None:
    """Never before its sound was there, in order, and at most one fragment and the rest later."""
    ready_ms = recorder.ready_ms(mu_ms, 50)
    behind_ms = recorder.fragment_ms + recorder.hand_over_ms * (recorder.fragment_ms // mu_ms + 2)
    for number, when_ms in enumerate(ready_ms):
        assert (number + 1) * mu_ms <= when_ms + 1e-6
        assert when_ms <= (number + 1) * mu_ms + behind_ms
    assert ready_ms == sorted(ready_ms)


@given(recorders, st.sampled_from(MU_LENGTHS_MS), st.lists(st.floats(0, 900), max_size=40))
def test_each_answer_is_the_newest_and_given_once(
    recorder: Recorder, mu_ms: int, gaps_ms: list[float]
) -> None:
    """What leaves is the newest there is; all before it were given or skipped."""
    ready_ms = recorder.ready_ms(mu_ms, 500)
    memory = SharedMemory(ready_ms)
    now_ms = 0.0
    for given_so_far, gap_ms in enumerate(gaps_ms, start=1):
        leaves_ms = memory.answer_ms(now_ms + gap_ms)
        assert leaves_ms is not None
        assert leaves_ms >= now_ms + gap_ms
        now_ms = leaves_ms
        assert given_so_far == len(memory.given)
        assert given_so_far + len(memory.skipped) == sum(when_ms <= now_ms for when_ms in ready_ms)


@settings(deadline=None)
@given(st.sampled_from(MU_LENGTHS_MS), st.floats(0, 0.95), st.integers(0, 1000))
def test_a_round_shorter_than_an_mu_makes_no_pause(mu_ms: int, share: float, seed: int) -> None:
    """As 3.3.2 says: an MU longer than the end-to-end delay is always there in time."""
    heard = _listen(mu_ms, _steady(share * mu_ms), seed=seed)
    assert heard.pauses == []
    assert heard.blocks > 0


@settings(deadline=None)
@given(st.sampled_from(MU_LENGTHS_MS), st.floats(1.2, 6.0), st.integers(0, 1000))
def test_a_longer_round_is_silent_for_the_rest_of_it(mu_ms: int, share: float, seed: int) -> None:
    """A round of r times the MU plays one r-th of the time: the rest was replaced at the source."""
    heard = _listen(mu_ms, _steady(share * mu_ms), seed=seed)
    assert heard.silence == pytest.approx(1 - 1 / share, abs=0.05)
    assert heard.skipped


class Late:
    """20 ms, but for the MUs that are later by so much."""

    def __init__(self, by_ms: dict[int, float]) -> None:
        self._by_ms = by_ms
        self._number = -1

    def delay_ms(self, at_ms: float, chance: Random) -> float:
        self._number += 1
        return 20.0 + 2 * self._by_ms.get(self._number, 0.0)


def test_a_pause_is_as_long_as_an_mu_is_later_than_any_before() -> None:
    """30 ms late is a pause of 30; the next that is 20 late finds what that left in the queue."""
    # Each MU comes as the last block of the one before has played out: a read of 50 ms, unheard.
    assert _listen(500, Late({})).pauses == []
    (pause,) = _listen(500, Late({20: 30.0, 30: 20.0})).pauses
    assert pause[1] == pytest.approx(30.0)
    assert pause[0] == pytest.approx(21 * 500 + 10, abs=0.1)
    two = _listen(500, Late({20: 30.0, 30: 40.0})).pauses
    assert [length for _, length in two] == pytest.approx([30.0, 10.0])


def test_the_queue_takes_two_mus_and_the_rest_stays_at_the_source() -> None:
    """A card that hands over 1 s at once: of ten MUs the queue and the threads take five."""
    recorder = Recorder(fragment_ms=1000.0, hand_over_ms=5.0)
    heard = _listen(100, SyntheticPath(1.0, 1.0, 0.0, 1.0), recorder=recorder)
    # 50 ms play, 50 are next, 200 queue, 100 are in the thread's hand, 100 wait at the source.
    assert heard.silence == pytest.approx(0.5, abs=0.01)
