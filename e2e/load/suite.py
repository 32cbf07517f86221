"""The suite: the cost of a viewer here and in a LiveKit room, of the page and of a crowd."""

from __future__ import annotations

from typing import Final

from e2e.load.beside import crowded, recording
from e2e.load.cluster.cost import room_cost
from e2e.load.cluster.faults import faults
from e2e.load.cluster.next_operator import next_operator, room_delay
from e2e.load.fan_out import fan_out
from e2e.load.memory import memory
from e2e.load.page.work import presented, work
from e2e.load.servers import JANUS, STOCK, WAX
from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Suite, measured

SUITE: Final = Suite(
    name="load",
    about="Measure what viewers, a crowd, the tape, the page and rooms of LiveKit cost.",
    measures=(*SERVER, *PAGE, *FIRMWARE, "e2e/peers/*.py", "e2e/peers/livekit/*.py"),
    columns=(WAX, STOCK, JANUS, "median", "p95", "max"),
    cases=(
        measured("fan-out", 3, fan_out, "windows of 2 s each", 1, minutes=2.7),
        measured("crowd", 3, crowded, "pairs of 30 s, alone and beside", 1, minutes=4.2),
        measured("memory", 60, memory, "joins and leaves", 10, minutes=2.5),
        measured("recording", 2, recording, "pairs of 20 s, tape off and on", 1, minutes=2.3),
        measured("page", 6, work, "stretches of 15 s", 4, minutes=2.4),
        measured("presented", 2, presented, "pairs of 10 s, page and bare video", 1, minutes=1.2),
        measured("room-cost", 2, room_cost, "pairs of 8 s, 0 and 16 in a room", 1, minutes=1.5),
        measured("room-delay", 4, room_delay, "times 150 pictures, there and here", 1, minutes=0.8),
        measured("room-lost", 2, faults, "times each fault", 1, minutes=2.5),
        measured("next-operator", 8, next_operator, "turns", 3, minutes=1.6),
        measured("page-half-hour", 120, work, "stretches of 15 s", 4, minutes=31.0, long=True),
        measured("memory-1000", 1000, memory, "joins and leaves", 10, minutes=20.0, long=True),
    ),
    notes=(
        "Stock is aiortc as its examples have it: MediaRelay, an encoder for each peer.",
        "Janus: Debian’s, its streaming plugin fed by RTP, which encodes nothing and estimates no "
        "link.",
        "640×480 at 30 fps; for the fan-out the server is held to one core.",
        "Main thread: Chromium’s own count of the time in tasks; the heap’s growth is the slope of "
        "the second half. Pictures presented: by the compositor’s count, by turns.",
        "LiveKit: two nodes and a Redis on the same machine; where they are lost, they and the "
        "page have one core, the robot’s server and its operator the other.",
    ),
)
