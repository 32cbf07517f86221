"""Events on the tape: what one version writes others read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

import pytest

from wax.protocol.tape_events import parse_event

OF_0_9_0: Final = (Path(__file__).parents[1] / "vectors/tape-0.9.0.jsonl").read_text("utf-8")


@pytest.mark.parametrize("line", OF_0_9_0.splitlines(), ids=lambda line: json.loads(line)["type"])
def test_tapes_of_0_9_0_are_read_and_it_reads_ours(line: str) -> None:
    """Each kind of event is read, and is written with all that 0.9.0 requires of it."""
    event = parse_event(line.encode())
    assert json.loads(event.model_dump_json()).items() >= json.loads(line).items()
