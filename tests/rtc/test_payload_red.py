"""Redundant sound: earlier units are repeated if they fit, and the newest is always sent."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.rtc.payload.red import HEADER_BYTES, red_payload

OPUS = 111


def unpacked(payload: bytes) -> list[tuple[int, int, bytes]]:
    """Parse it by RFC 2198, section 3: payload type, ticks before, unit; the newest last."""
    heads: list[tuple[int, int, int]] = []
    at = 0
    while payload[at] & 0x80:
        word = int.from_bytes(payload[at + 1 : at + 4], "big")
        heads.append((payload[at] & 0x7F, word >> 10, word & 0x3FF))
        at += 4
    kind = payload[at]
    at += 1
    found: list[tuple[int, int, bytes]] = []
    for earlier_kind, ticks, size in heads:
        found.append((earlier_kind, ticks, payload[at : at + size]))
        assert len(found[-1][2]) == size
        at += size
    return [*found, (kind, 0, payload[at:])]


def test_two_earlier_units_as_the_rfc_draws_them() -> None:
    """The oldest unit comes first, each with its offset and length, the newest without."""
    payload = red_payload(b"new", [(960, b"old"), (1920, b"older")], OPUS, 1200)
    assert payload == (
        bytes.fromhex("ef 1e0005")
        + bytes.fromhex("ef 0f0003")
        + b"\x6f"
        + b"older"
        + b"old"
        + b"new"
    )


def test_without_redundancy_the_payload_is_one_byte_longer() -> None:
    """A packet without redundancy is also in this format, one byte longer than its sound."""
    assert red_payload(b"new", [], OPUS, 1200) == b"\x6fnew"


def test_units_beyond_the_formats_limits_are_left_out() -> None:
    """A unit beyond 14 bits of offset or 10 of length is left out alone, not those around it."""
    found = red_payload(
        b"new",
        [
            (960, b"x" * 1024),
            (1920, b"y" * 1023),
            (16383, b"z"),
            (16384, b"z"),
            (0, b"z"),
            (9, b""),
        ],
        OPUS,
        10_000,
    )
    assert unpacked(found) == [
        (OPUS, 16383, b"z"),
        (OPUS, 1920, b"y" * 1023),
        (OPUS, 0, b"new"),
    ]


def test_if_space_is_short_the_oldest_is_dropped_first() -> None:
    """If space is short, the oldest unit is dropped first, even if it is smaller."""
    earlier = [(1920, b"o"), (960, b"x" * 20)]
    whole = 1 + 3 + 2 * HEADER_BYTES + 21
    assert len(red_payload(b"new", earlier, OPUS, whole)) == whole
    assert [t for _, t, _ in unpacked(red_payload(b"new", earlier, OPUS, whole - 1))] == [960, 0]
    assert unpacked(red_payload(b"new", earlier, OPUS, 27)) == [(OPUS, 0, b"new")]
    assert unpacked(red_payload(b"new", earlier, OPUS, 0)) == [(OPUS, 0, b"new")]


@given(
    st.binary(max_size=1500),
    st.lists(st.tuples(st.integers(-10, 20_000), st.binary(max_size=1100)), max_size=6),
    st.integers(0, 127),
    st.integers(0, 1500),
)
def test_the_newest_always_arrives_and_the_rest_as_it_fits(
    primary: bytes, earlier: list[tuple[int, bytes]], payload_type: int, max_bytes: int
) -> None:
    """The newest units within the format's limits are sent, up to the first that is too long."""
    payload = red_payload(primary, earlier, payload_type, max_bytes)
    *found, newest = unpacked(payload)
    assert newest == (payload_type, 0, primary)
    assert len(payload) <= max(max_bytes, 1 + len(primary))
    fit = [(t, unit) for t, unit in earlier if 0 < t < 2**14 and 0 < len(unit) < 2**10]
    fit.sort(key=lambda one: one[0])
    carried = [(ticks, unit) for _, ticks, unit in reversed(found)]
    assert carried == fit[: len(carried)]
    if len(carried) < len(fit):
        assert len(payload) + HEADER_BYTES + len(fit[len(carried)][1]) > max_bytes
