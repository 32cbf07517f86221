"""The benchmarks: WAX and a stock aiortc server, the same work on the same machine."""

from __future__ import annotations

from typing import Final

from e2e.load.cameras import cameras
from e2e.load.crossing import crossing
from e2e.load.crowded import crowded
from e2e.load.fan_out import fan_out
from e2e.load.first_picture import first_picture
from e2e.load.key_to_byte import key_to_byte
from e2e.load.memory import memory
from e2e.load.picture_cost import picture_cost
from e2e.load.recording import recording
from e2e.load.servers import JANUS, STOCK, WAX
from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Case, Suite, measured

SUITE: Final = Suite(
    name="bench",
    about="Measure WAX and a stock aiortc server, the same work on the same machine.",
    measures=(*SERVER, *PAGE, *FIRMWARE, "e2e/peers/stock.py"),
    columns=(WAX, STOCK, JANUS),
    cases=(
        measured("fan-out", 6, fan_out, "windows of 2 s for each number of viewers", 1),
        measured("crowd", 5, crowded, "pairs of 30 s, alone and beside the crowd", 1),
        measured("first-picture", 20, first_picture, "page loads", 3),
        measured("key-to-byte", 220, key_to_byte, "key presses", 15),
        measured("memory", 200, memory, "joins and leaves", 20),
        measured("cameras", 5, cameras, "pairs of 10 s, a second camera off and large", 1),
        Case(
            "crossing",
            "pictures of each size and place",
            1500,
            crossing,
            150,
        ),
        measured("picture-cost", 600, picture_cost, "pictures of each size and codec", 150),
        measured("recording", 10, recording, "pairs of 30 s, the tape off and on", 1),
    ),
    notes=(
        "Stock is aiortc as its examples have it: MediaRelay, an encoder for each peer; a second "
        "of its first picture is waiting for names that nobody answers.",
        "Janus: Debian’s, its streaming plugin fed by RTP, which encodes nothing and estimates no "
        "link.",
        "640×480 at 30 fps; for the fan-out the server is held to one core.",
    ),
)
