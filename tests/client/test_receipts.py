"""Clients without a screen acknowledge media units as the page does."""

from __future__ import annotations

import pytest

from wax.client.receipts import Receipts
from wax.client.rtp_header import RtpHeader

NEWEST = 2**32 - 1000


def packet(rtp: int, *, marker: bool = False) -> RtpHeader:
    return RtpHeader(96, marker, 1, rtp, 2, b"", None)


@pytest.mark.parametrize("rtp", [NEWEST, 3000, 7000, NEWEST - 4000])
def test_the_end_of_a_unit_is_known_across_the_wrap(rtp: int) -> None:
    """One unit's last packet determines all others, later and earlier, across the wrap at 2³²."""
    receipts = Receipts()
    receipts.learn(NEWEST, 4000)
    assert receipts.ends_unit("audio", packet(rtp))
    assert not receipts.ends_unit("audio", packet((rtp - 160) % 2**32))


def test_what_came_early_is_told_once() -> None:
    """Early packets are acknowledged once it is known which ones end a unit, and only once."""
    receipts = Receipts()
    for rtp in (3840, 4000, 4160):
        assert not receipts.ends_unit("audio", packet(rtp))
    assert receipts.learn(8000, 4000) == [4000]
    assert receipts.learn(8000, 4000) == []


def test_a_picture_ends_with_its_marker() -> None:
    """Of a picture's packets the one that is marked is the last."""
    receipts = Receipts()
    assert not receipts.ends_unit("video", packet(1))
    assert receipts.ends_unit("video", packet(1, marker=True))
