"""The bridge: our own policy's sender and the model's server of 2004, asked by the same client.

This is how we know that the baseline is the thesis's: what the model hears of the thesis's
connections is what it would hear if our sender served it. They differ in three places.

* An MU that nobody asks for: the model keeps it until the next is ready, our sender drops it after
  its own length. The thesis says both and takes them for the same (3.3), and they are, unless a
  sound card hands over several MUs at once; ours cuts one after the other.
* What our page acknowledges: it does so on delivery. The client of 2004 asked when its queue had
  room, and on Windows a turn-round later; that is no matter of the server, but of what is heard.
* A newcomer: the model's server, and `Baseline` here, give it the MU in the buffer; our hub hands
  a viewer what is complete from then on, so there it begins up to one MU later.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from random import Random
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.baseline.client2004.baseline import Baseline
from tests.baseline.client2004.client import Client, Heard, Listening
from tests.baseline.client2004.scenes import PAGE, RECORDER, SCENES, Scene
from tests.baseline.client2004.source import Recorder, SharedMemory
from tests.baseline.client2004.table import MU_LENGTHS_MS, WITHOUT_FRAGMENTS, hear, is_clean
from tests.examples import at_length, share_of

if TYPE_CHECKING:
    from tests.baseline.client2004.client import Serve

on_each_connection = pytest.mark.parametrize(
    "scene",
    [SCENES[2], SCENES[-1], *at_length(*SCENES[:2], *SCENES[3:-1])],
    ids=lambda scene: scene.name,
)
mu_lengths = st.sampled_from(MU_LENGTHS_MS)


def _hear(
    scene: Scene, mu_ms: int, serve: Serve, *, recorder: Recorder, client: Client, seed: int
) -> Heard:
    return Listening(
        mu_ms=mu_ms,
        recorder=recorder,
        path=scene.path,
        client=client,
        chance=Random(seed),
        seconds=60.0,
        serve=serve,
    ).run()


@on_each_connection
@pytest.mark.parametrize("page", [False, True], ids=["asked", "delivered"])
def test_the_sender_serves_as_the_server_of_2004(scene: Scene, page: bool) -> None:
    """Of sound in one piece the same MUs leave at the same times, are skipped and are heard.

    With what the client of 2004 asks for as the acknowledgement, and with the page's own.
    """
    client = PAGE if page else scene.client
    for mu_ms in MU_LENGTHS_MS:
        for seed in range(share_of(4)):
            ours, theirs = (
                _hear(scene, mu_ms, serve, recorder=WITHOUT_FRAGMENTS, client=client, seed=seed)
                for serve in (partial(Baseline, mu_ms), SharedMemory)
            )
            assert len(theirs.given) > 80
            assert ours == theirs
            if client.least_turn_ms > 2 * mu_ms:
                assert len(theirs.skipped) > len(theirs.given)


@on_each_connection
def test_fragments_differ_by_how_long_an_mu_is_valid_and_by_nothing_else(scene: Scene) -> None:
    """A model that drops an MU after its own length too, as ours does, is the same in all cells."""
    for mu_ms in MU_LENGTHS_MS:
        for seed in range(share_of(4)):
            ours, theirs = (
                _hear(scene, mu_ms, serve, recorder=RECORDER, client=scene.client, seed=seed)
                for serve in (partial(Baseline, mu_ms), partial(SharedMemory, valid_ms=mu_ms))
            )
            assert ours == theirs


@pytest.mark.full
@on_each_connection
def test_our_sender_has_pauses_where_the_thesis_has_them(scene: Scene) -> None:
    """With fragments, too, it is clean in the same cells as the model."""
    for mu_ms in MU_LENGTHS_MS:
        ours = hear(scene, mu_ms, serve=partial(Baseline, mu_ms))
        assert is_clean(ours) == is_clean(hear(scene, mu_ms)), mu_ms


@pytest.mark.full
@on_each_connection
def test_the_page_loses_nothing_that_only_the_client_lost(scene: Scene) -> None:
    """Acknowledged on delivery and in one piece, every connection of chapter 5.2 is clean."""
    paged = replace(scene, client=PAGE)
    for mu_ms in MU_LENGTHS_MS:
        heard = hear(paged, mu_ms, recorder=WITHOUT_FRAGMENTS, serve=partial(Baseline, mu_ms))
        assert is_clean(heard), mu_ms


@settings(deadline=None)
@given(mu_lengths, st.lists(st.integers(0, 900), min_size=1, max_size=40))
def test_asked_at_any_time_the_same_leaves(mu_ms: int, gaps_ms: list[int]) -> None:
    """At any time, even when an MU becomes ready, both give the same answer."""
    ready_ms = WITHOUT_FRAGMENTS.ready_ms(mu_ms, 500)
    ours, theirs = Baseline(mu_ms, ready_ms), SharedMemory(ready_ms)
    now_ms = 0.0
    for gap_ms in gaps_ms:
        leaves_ms = theirs.answer_ms(now_ms + gap_ms)
        assert leaves_ms is not None
        assert ours.answer_ms(now_ms + gap_ms) == leaves_ms
        now_ms = leaves_ms
    assert (ours.given, ours.skipped) == (theirs.given, theirs.skipped)


def test_the_end_of_the_recording_is_the_end() -> None:
    """After the last MU there is no answer, from either."""
    ready_ms = WITHOUT_FRAGMENTS.ready_ms(100, 3)
    for server in (Baseline(100, ready_ms), SharedMemory(ready_ms)):
        assert [server.answer_ms(asked_ms) for asked_ms in (0, 250, 310)] == [100, 250, 310]
        assert server.answer_ms(320) is None
        assert server.given == [(0, 100), (1, 250), (2, 310)]
