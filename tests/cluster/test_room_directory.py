"""How observers are spread over rooms, and their names there."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.cluster.room_directory import Occupancy, choose, person, published, upload_left_bps
from wax.config.publish import PublishSettings
from wax.config.video import RenditionSettings, VideoSettings
from wax.errors import StartError


@given(st.lists(st.integers(1, 20), min_size=1, max_size=5), st.integers(0, 120))
def test_no_room_gets_more_than_it_takes(most: list[int], crowd: int) -> None:
    """Observers get the emptiest room while there is a place, and none once all are full."""
    rooms = [Occupancy(str(number), places) for number, places in enumerate(most)]
    sent = [choose(rooms) for _ in range(crowd)]
    assert sum(bool(seats) for seats in sent) == min(crowd, sum(most))
    assert all(room.sent <= room.most for room in rooms)
    free = [room.free for room in rooms]
    assert crowd >= sum(most) or max(free) - min(free, default=0) <= max(most) - min(most) + 1


def test_the_second_room_is_another_one_even_if_it_is_full() -> None:
    """The second seat is in another room, even a full one: it is a fallback for the first."""
    first, second = (Occupancy(name, 1) for name in ("a", "b"))
    assert choose([first, second]) == [first, second]
    assert choose([first, second]) == [second, first]
    assert choose([first, second]) == []


def test_who_was_sent_somewhere_stays_there() -> None:
    """A renewed seat stays in its room, even a full one, unless that is no longer live."""
    first, second = (Occupancy(name, 1) for name in ("a", "b"))
    assert choose([first, second]) == [first, second]
    assert choose([first, second], ["a", "b"]) == [first, second]
    assert second.free == 1, "nobody was sent twice"
    assert choose([second], ["a", "b"]) == [second], "the first is gone"


def test_who_is_on_the_way_counts_until_the_next_count_but_one() -> None:
    """Observers sent to a room count until the second count after, which must include them."""
    room = Occupancy("a", 2)
    assert choose([room])
    room.count(0)
    assert room.free == 1
    room.count(1)
    assert room.free == 1


def test_two_renditions_are_published() -> None:
    """The best rendition is published, and one of at most a quarter of its bitrate, if any.

    With a limit that is the best within it.
    """
    assert [one.bitrate_bps for one in published(VideoSettings().renditions)] == [
        1_000_000,
        120_000,
    ]
    hd = VideoSettings(width=1280, height=720).renditions
    assert [one.name for one in published(hd, 1_000_000)] == [
        "960x540 at 1000 kbit/s",
        "320x180 at 120 kbit/s",
    ]
    assert published(hd)[0] == hd[0]
    only = RenditionSettings(width=640, height=480, fps=30, bitrate_bps=600_000)
    assert published([only]) == published([only], 100_000) == [only]


def test_the_rooms_come_off_the_upload_first() -> None:
    """A LiveKit room takes both renditions and the sound, another the best and the sound."""
    ladder = published(VideoSettings().renditions)
    rooms = [
        PublishSettings(livekit="wss://a", api_key="k", api_secret="s"),
        PublishSettings(whip="https://b"),
    ]
    assert upload_left_bps(0, ladder, rooms) == 0
    assert upload_left_bps(5_000_000, ladder, rooms) == 5_000_000 - 1_170_000 - 1_050_000
    assert upload_left_bps(5_000_000, ladder, []) == 5_000_000
    with pytest.raises(StartError, match="does not even carry the rooms"):
        upload_left_bps(2_220_000, ladder, rooms)


def test_a_name_in_a_room_tells_nothing() -> None:
    """Each tab has a name of its own, the same each time, that does not reveal its cookie."""
    assert person("cookie", "tab") == person("cookie", "tab")
    assert len({person("cookie", "a"), person("cookie", "b"), person("other", "a")}) == 3
    assert "cookie" not in person("cookie", "tab")
