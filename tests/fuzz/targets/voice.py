"""Datagrams of an admitted page's voice, decrypted: read, ordered and decoded."""

from __future__ import annotations

import struct
from typing import Final

import numpy as np
from tests.fuzz.target import Target

from wax.errors import ProtocolError
from wax.rtc import voice_packet
from wax.speaker.voice_playout import VoicePlayout
from wax.voice.limiter import CEILING
from wax.voice.packet import MAX_SAMPLES

_OPUS: Final = 111
_STEP_S: Final = 0.01
_PACKETS: Final = 100
"""The most packets of one input: 10 ms of playing cost more than the one byte of an empty
packet."""


def _hear(data: bytes) -> None:
    """Split into packets, each after a byte with its length; 10 ms pass after each."""
    playout = VoicePlayout()
    at, now_s, packets, samples = 0, 100.0, 0, 0
    for _ in range(_PACKETS):
        if at >= len(data):
            break
        end = at + 1 + data[at]
        try:
            packet = voice_packet.read(data[at + 1 : end], _OPUS)
        except ProtocolError:
            packet = None
        if packet is not None:
            packets += 1
            playout.push(packet, now_s)
        now_s += _STEP_S
        for piece in playout.pop_due(now_s):
            samples += len(piece)
            assert np.abs(piece.astype(int)).max() <= CEILING
        at = end
    assert samples <= (packets + 1) * 2 * MAX_SAMPLES


def _packet(number: int, payload: bytes, *, first: int = 0x80, more: bytes = b"") -> bytes:
    header = struct.pack("!BBHLL", first, _OPUS, number % 2**16, number * 960, 5)
    packet = header + more + payload
    return bytes((len(packet),)) + packet


_SPEECH: Final = bytes((1 << 3, 11, 5, 7, 9))

VOICE: Final = Target(
    name="voice",
    what="packets of a voice",
    hear=_hear,
    seeds=(
        b"".join(_packet(n, _SPEECH) for n in range(6)),
        b"".join(_packet(n, bytes((31 << 3 | 3, n % 7)) + bytes(20)) for n in range(6)),
        _packet(0, _SPEECH, first=0x90, more=struct.pack("!HHL", 0xBEDE, 1, 0)),
        _packet(2**31 // 960, _SPEECH + b"\0\0\3", first=0xA0),
    ),
    words=(b"\x80\x6f", b"\x90\x6f", b"\xa0\x6f", b"\xbe\xde", b"\xff\xff\xff\xff", b"\xfb\x06"),
    steps=100_000,
)
