"""Every parser that bytes from outside reach. A new one is one line here."""

from __future__ import annotations

from typing import Final

from tests.fuzz.targets import (
    files,
    hand_line,
    house,
    network,
    offers,
    pages,
    sctp,
    serial_line,
    tapes,
    text_line,
    tokens,
    voice,
)

TARGETS: Final = {
    target.name: target
    for target in (
        pages.DRIVE,
        pages.STATE,
        pages.SIGNALLING,
        offers.SDP,
        network.RTCP,
        sctp.SCTP,
        network.STUN,
        network.ONE_PORT,
        voice.VOICE,
        serial_line.SERIAL,
        serial_line.FIRMWARE,
        text_line.TEXT,
        hand_line.HAND,
        house.HOUSE,
        files.CONFIG,
        tokens.TOKENS,
        tokens.COOKIES,
        tokens.HEADS,
        tapes.EVENTS,
        tapes.RECORDS,
        tapes.MEDIA,
    )
}
