"""The counters of one direction of a link."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Counters:
    """Counts since the start of one direction; bytes are those of IP packets."""

    packets_in: int = 0
    bytes_in: int = 0
    packets_out: int = 0
    bytes_out: int = 0
    queue_drops: int = 0
    queue_drop_bytes: int = 0
    losses: int = 0
    loss_bytes: int = 0
    backlog_peak_bytes: int = 0
