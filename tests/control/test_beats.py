"""Beats: how recently a page heard from the server, by the server's clock alone."""

from __future__ import annotations

import math
from collections import Counter
from itertools import count

from hypothesis import given
from hypothesis import strategies as st

from wax.control.beats import Beats


def test_a_beat_tells_when_it_was_sent() -> None:
    """A beat gives the time when it was sent, an unknown word gives none."""
    beats = Beats()
    first, second = beats.send(10.0), beats.send(10.1)
    assert (beats.sent_s(first), beats.sent_s(second)) == (10.0, 10.1)
    assert beats.sent_s(None) == beats.sent_s("guess") == -math.inf


def test_another_page_has_heard_others() -> None:
    """Beats sent to one page prove nothing for another page, or for its own next connection."""
    assert Beats().sent_s(Beats().send(10.0)) == -math.inf


def test_only_the_newest_are_remembered() -> None:
    """However many beats are sent, old ones are forgotten, so that memory stays bounded."""
    beats = Beats()
    words = [beats.send(float(at_s)) for at_s in range(65)]
    assert [beats.sent_s(word) for word in words[:2]] == [-math.inf, 1.0]


def test_a_word_that_comes_again_counts_from_then() -> None:
    """If the same word is ever drawn twice, the later time counts."""
    beats = Beats(lambda: "again_")
    beats.send(1.0)
    beats.send(2.0)
    assert beats.sent_s("again_") == 2.0


def test_who_sends_commands_hears_ten_a_second() -> None:
    """Fewer are due on a thin link, and a beat in a pong counts, too."""
    beats = Beats()
    assert beats.is_due(0.0, is_thin=True)
    beats.send(1.0)
    for is_thin, every_s in ((False, 0.1), (True, 0.15)):
        assert not beats.is_due(1.0 + every_s - 0.001, is_thin=is_thin)
        assert beats.is_due(1.0 + every_s + 0.001, is_thin=is_thin)


def test_no_two_beats_are_alike() -> None:
    """Each beat has six characters and 32 random bits, so that none can be predicted."""
    beats = Beats()
    words = Counter(beats.send(0.0) for _ in range(1000))
    assert all(len(word) == 6 for word in words)
    assert len(words) >= 998


@given(st.lists(st.tuples(st.floats(0, 1), st.integers(0, 99)), max_size=150))
def test_a_known_beat_never_tells_a_later_time(trace: list[tuple[float, int]]) -> None:
    """Whatever is sent and quoted, a beat gives the time when it was sent, or none."""
    names = count()
    beats, now_s, truth = Beats(lambda: str(next(names))), 0.0, {}
    for step_s, named in trace:
        now_s += step_s
        truth[beats.send(now_s)] = now_s
        assert beats.sent_s(str(named)) in (truth.get(str(named)), -math.inf)
