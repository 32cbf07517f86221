"""The suite: what observers past one machine see, and what becomes of them when it breaks."""

from __future__ import annotations

from typing import Final

from e2e.load.cluster.engine_lost import engine_lost
from e2e.load.cluster.next_operator import next_operator
from e2e.load.cluster.node_cost import node_cost
from e2e.load.cluster.node_lost import node_lost
from e2e.load.cluster.origin_cost import origin_cost
from e2e.load.cluster.watch import watch
from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Suite, measured

SUITE: Final = Suite(
    name="cluster",
    about="Watch in rooms of LiveKit beside the robot's own server, and break the rooms.",
    measures=(*SERVER, *PAGE, *FIRMWARE, "e2e/peers/livekit/*.py"),
    columns=("median", "p95", "max"),
    cases=(
        measured("watch", 5, watch, "windows of 20 s", 1),
        measured("node-lost", 5, node_lost, "nodes killed, and as many frozen", 1),
        measured("engine-lost", 5, engine_lost, "times without Redis, nodes, and good tokens", 1),
        measured("next-operator", 20, next_operator, "turns", 4),
        measured("origin-cost", 12, origin_cost, "pairs of 10 s, with and without 1,000 pages", 1),
        measured("node-cost", 4, node_cost, "pairs of 8 s, with nobody in a room and with 16", 1),
    ),
    notes=(
        "LiveKit: two nodes and a Redis on the machine on which everything else is. Where they are "
        "lost, they and the page have one core, the robot’s server and its operator the other.",
    ),
)
