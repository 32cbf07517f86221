"""VP8 payloads: every byte arrives, and the browser decodes all it can and nothing wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace
from random import Random
from typing import TYPE_CHECKING, Any

import av
import numpy as np
import pytest
from aiortc.codecs.vpx import VpxPayloadDescriptor
from hypothesis import example, given
from hypothesis import strategies as st
from tests.examples import at_length
from tests.rtc.vp8_receiver import Arrived, Receiver

from wax.capture.source import Picture
from wax.config.video import RenditionSettings
from wax.encode.video_encoder import VideoEncoder
from wax.rtc.payload.vp8 import DESCRIPTOR_BYTES, Vp8Packetizer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

FIRST_ID, FIRST_BASE = 0x7FF0, 0xF8
"""Both numbers wrap within each of these tests."""

PLACES = (0, 2, 1, 2)


@dataclass(frozen=True)
class Source:
    """One encoded picture and its properties; `needs` are the indices that it refers to."""

    index: int
    layer: int
    sync: bool
    droppable: bool
    keyframe: bool
    needs: tuple[int, ...]
    data: bytes = b"0123456789"


def pattern(keyframes: Sequence[bool]) -> list[Source]:
    """Arrange pictures as the encoder does; its pattern of four restarts at each keyframe."""
    found: list[Source] = []
    base = place = 0
    for index, keyframe in enumerate(keyframes):
        place = 0 if keyframe or not index else (place + 1) % 4
        needs = {0: (base,), 1: (base,), 2: (base,), 3: (base, index - 1)}[place]
        if keyframe or not index:
            needs = ()
        base = index if place == 0 else base
        found.append(
            Source(
                index=index,
                layer=PLACES[place],
                sync=place in (1, 2),
                droppable=place in (1, 3),
                keyframe=not needs,
                needs=needs,
            )
        )
    return found


def packets(packetizer: Vp8Packetizer, data: bytes, **how: Any) -> list[bytes]:
    return [head + piece for head, piece in packetizer.packets(data, **how)]


def send(packetizer: Vp8Packetizer, source: Source, max_bytes: int = 1200) -> list[bytes]:
    return packets(
        packetizer,
        source.data,
        layer=source.layer,
        sync=source.sync,
        droppable=source.droppable,
        keyframe=source.keyframe,
        max_bytes=max_bytes,
    )


class Sent:
    """The packets sent to one viewer, with the numbers on the wire unwrapped."""

    def __init__(self) -> None:
        self._packetizer = Vp8Packetizer(picture_id=FIRST_ID, tl0_picidx=FIRST_BASE)
        self._bases = FIRST_BASE - 1
        self.sources: dict[int, Source] = {}

    def send(self, source: Source) -> Arrived:
        """Send a picture and return it as it would arrive."""
        (payload,) = send(self._packetizer, source)
        descriptor, data = VpxPayloadDescriptor.parse(payload)
        assert data == source.data
        number = FIRST_ID + len(self.sources)
        self._bases += source.layer == 0
        assert descriptor.picture_id == number & 0x7FFF
        assert descriptor.tl0picidx == self._bases & 0xFF
        assert descriptor.tid is not None
        tid, sync = descriptor.tid
        self.sources[number] = source
        return Arrived(number, self._bases, tid, bool(sync), source.keyframe)


@given(
    data=st.binary(min_size=1, max_size=6000),
    max_bytes=st.integers(32, 1300),
    layer=st.integers(0, 3),
    sync=st.booleans(),
    droppable=st.booleans(),
    first_less=st.sampled_from([0, 4]),
)
def test_a_picture_is_reassembled(
    *, data: bytes, max_bytes: int, layer: int, sync: bool, droppable: bool, first_less: int
) -> None:
    """Payloads fit, have one size but the first and last, and differ only in the start flag."""
    packetizer = Vp8Packetizer(picture_id=0x7FFF, tl0_picidx=0xFF)
    payloads = packets(
        packetizer,
        data,
        layer=layer,
        sync=sync,
        droppable=droppable,
        keyframe=False,
        max_bytes=max_bytes,
        first_less=first_less,
    )
    parsed = [VpxPayloadDescriptor.parse(payload) for payload in payloads]
    assert b"".join(rest for _, rest in parsed) == data
    sizes = [len(payload) for payload in payloads]
    assert max(sizes) <= max_bytes
    assert len(sizes) == -(-(len(data) + first_less) // (max_bytes - DESCRIPTOR_BYTES))
    if len(sizes) > 1:
        whole = [sizes[0] + first_less, *sizes[1:-1]]
        assert len(set(whole)) == 1
        assert whole[0] - len(sizes) < sizes[-1] <= whole[0]
    assert [one.partition_start for one, _ in parsed] == [1] + [0] * (len(parsed) - 1)
    for payload, (descriptor, _) in zip(payloads, parsed, strict=True):
        assert descriptor.partition_id == 0
        assert descriptor.picture_id == 0x7FFF
        assert descriptor.tl0picidx == (0xFF if layer == 0 else 0xFE)
        assert descriptor.tid == (layer, int(sync))
        assert descriptor.keyidx is None
        assert bool(payload[0] & 0x20) is droppable


def test_the_descriptor_is_as_the_rfc_draws_it() -> None:
    """Every bit is as in RFC 7741, 4.2, including those that the other test's parser ignores."""
    packetizer = Vp8Packetizer(picture_id=0x1234, tl0_picidx=0x56)
    (payload,) = packets(
        packetizer, b"picture", layer=0, sync=False, droppable=False, keyframe=True, max_bytes=100
    )
    assert payload == bytes.fromhex("90 e0 9234 56 00") + b"picture"
    (payload,) = packets(
        packetizer, b"picture", layer=2, sync=True, droppable=True, keyframe=False, max_bytes=100
    )
    assert payload == bytes.fromhex("b0 e0 9235 56 a0") + b"picture"


@given(st.integers(0, 60), st.integers(32, 200))
def test_a_keyframe_starts_with_its_whole_header(extra: int, max_bytes: int) -> None:
    """A keyframe's first packet has its whole ten-byte header, for its size (RFC 6386, 9.1)."""
    packetizer = Vp8Packetizer(picture_id=0, tl0_picidx=0)
    payloads = packets(
        packetizer,
        bytes(10 + extra),
        layer=0,
        sync=False,
        droppable=False,
        keyframe=True,
        max_bytes=max_bytes,
    )
    assert len(payloads[0]) >= DESCRIPTOR_BYTES + 10


def test_invalid_arguments_are_refused() -> None:
    """A keyframe above layer 0 and a lack of room are refused; an empty picture takes no number."""
    packetizer = Vp8Packetizer(picture_id=5, tl0_picidx=5)
    source = pattern([True])[0]
    with pytest.raises(ValueError, match="layer 0"):
        packets(
            packetizer, b"x", layer=1, sync=True, droppable=False, keyframe=True, max_bytes=1200
        )
    with pytest.raises(ValueError, match="32 bytes"):
        send(packetizer, source, max_bytes=31)
    assert (
        packets(
            packetizer, b"", layer=0, sync=False, droppable=False, keyframe=False, max_bytes=1200
        )
        == []
    )
    descriptor, _ = VpxPayloadDescriptor.parse(send(packetizer, source)[0])
    assert (descriptor.picture_id, descriptor.tl0picidx) == (5, 5)


plans = st.lists(
    st.tuples(
        st.sampled_from([False] * 9 + [True]),  # a keyframe was asked for
        st.sampled_from(["sent", "sent", "sent", "left out", "lost"]),
        st.integers(0, 9),  # how many later pictures overtake it
    ),
    min_size=1,
    max_size=150,
)


def decodable_and_sent(sources: Sequence[Source], fates: Sequence[str]) -> list[Source]:
    """Return what a lane sends: without some upper layers, and all that refers to them."""
    sent: list[Source] = []
    there: set[int] = set()
    for source, fate in zip(sources, fates, strict=True):
        if (source.layer and fate == "left out") or not there.issuperset(source.needs):
            continue
        there.add(source.index)
        sent.append(source)
    return sent


@given(plans)
def test_in_order_decodable_pictures_are_handed_off_at_once(
    plan: list[tuple[bool, str, int]],
) -> None:
    """However many upper-layer pictures were dropped or lost, the browser waits for none of them.

    One exception: the last of four waits if one of its own four was lost.
    """
    sources = pattern([keyframe for keyframe, _, _ in plan])
    fates = [fate for _, fate, _ in plan]
    wire, receiver = Sent(), Receiver()
    handed: set[int] = set()
    lost_since_base = False
    for source in decodable_and_sent(sources, fates):
        arrived = wire.send(source)
        lost_since_base = lost_since_base and source.layer > 0
        if source.layer and fates[source.index] == "lost":
            lost_since_base = True
            continue
        found = {wire.sources[number].index for number in receiver.take(arrived)}
        assert found == (set() if not source.sync and lost_since_base else {source.index})
        handed |= found
        assert handed.issuperset(source.needs) or not found


@given(plans)
@example([(at == 3, "sent", late) for at, late in enumerate((8, 7, 7, 5, 6, 8, 0))])
def test_nothing_is_decoded_without_what_it_refers_to(
    plan: list[tuple[bool, str, int]],
) -> None:
    """Losses, late retransmissions and reordering break no reference and never block layer 0.

    One exception: libwebrtc notices gaps only after the first picture that arrives. A picture that
    refers to an earlier one may be decoded without it, but then no other refers to that picture.
    """
    sources = pattern([keyframe for keyframe, _, _ in plan])
    fates = [fate for _, fate, _ in plan]
    wire, receiver = Sent(), Receiver()
    on_the_way = [
        (place + plan[source.index][2], place, wire.send(source))
        for place, source in enumerate(decodable_and_sent(sources, fates))
    ]
    handed: list[int] = []
    first: int | None = None
    for _, _, arrived in sorted(on_the_way, key=lambda one: one[:2]):
        source = wire.sources[arrived.picture_id]
        if source.layer and fates[source.index] == "lost":
            continue
        first = source.index if first is None else first
        for number in receiver.take(arrived):
            found = wire.sources[number]
            lacks = set(found.needs) - set(handed)
            assert not lacks or (found.droppable and max(lacks) <= first)
            handed.append(found.index)
    assert len(set(handed)) == len(handed)
    last_keyframe = max(source.index for source in sources if source.keyframe)
    bases = {s.index for s in sources if s.layer == 0 and s.index >= last_keyframe}
    assert bases.issubset(handed)


def _encoded(count: int, keyframes: set[int]) -> list[Source]:
    rendition = RenditionSettings(width=160, height=120, fps=30, bitrate_bps=200_000)
    encoder = VideoEncoder(codec="vp8", rendition=rendition)
    texture = np.random.default_rng(1).integers(0, 255, (180, 160 + count), dtype=np.uint8)
    sources = pattern([index in keyframes for index in range(count)])
    found: list[Source] = []
    for source in sources:
        at = source.index
        picture = Picture(np.ascontiguousarray(texture[:, at : at + 160]), 5000 + at / 30)
        encoded = encoder.encode(picture, keyframe=source.keyframe)
        assert encoded is not None
        assert (encoded.layer, encoded.keyframe) == (source.layer, source.keyframe)
        found.append(replace(source, data=encoded.data))
    return found


def _decoded(sources: Sequence[Source]) -> dict[int, NDArray[Any]]:
    decoder = av.CodecContext.create("vp8", "r")
    assert isinstance(decoder, av.VideoCodecContext)
    decoder.thread_count = 1
    found: dict[int, NDArray[Any]] = {}
    for source in sources:
        (frame,) = decoder.decode(av.Packet(source.data))
        found[source.index] = frame.to_ndarray()
    return found


@pytest.mark.parametrize("seed", [0, *at_length(*range(1, 6))])
def test_what_the_browser_decodes_is_what_was_encoded(seed: int) -> None:
    """With upper layers dropped and lost, each real picture decodes exactly as without losses."""
    random, sources = Random(seed), _encoded(80, {30, 53})
    whole = _decoded(sources)
    fates = [random.choice(["sent", "sent", "left out", "lost"]) for _ in sources]
    packetizer, receiver = Vp8Packetizer(picture_id=0, tl0_picidx=0), Receiver()
    numbers: dict[int, Source] = {}
    handed: list[Source] = []
    bases = -1
    for source in decodable_and_sent(sources, fates):
        payloads = send(packetizer, source, max_bytes=300)
        bases += source.layer == 0
        parsed = [VpxPayloadDescriptor.parse(payload) for payload in payloads]
        assert b"".join(rest for _, rest in parsed) == source.data
        numbers[len(numbers)] = source
        if source.layer and fates[source.index] == "lost":
            continue
        tid, sync = parsed[0][0].tid or (0, 0)
        arrived = Arrived(len(numbers) - 1, bases, tid, bool(sync), source.keyframe)
        handed += [numbers[number] for number in receiver.take(arrived)]
    seen = _decoded(handed)
    assert {s.index for s in sources if s.layer == 0}.issubset(seen)
    assert any(s.layer == 2 and not s.sync for s in handed)
    assert all(np.array_equal(picture, whole[index]) for index, picture in seen.items())
