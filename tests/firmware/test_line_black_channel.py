"""The line as a black channel: nothing that it does moves a wheel that should not move."""

from __future__ import annotations

import os
import shutil
from collections import Counter
from random import Random
from typing import TYPE_CHECKING

import pytest
from tests.examples import at_length, share_of
from tests.firmware.channel import ERRORS, make_trace, play
from tests.firmware.core import FIRMWARE, Kind, build, load

if TYPE_CHECKING:
    import ctypes
    from pathlib import Path

TRACES = int(os.environ.get("WAX_TRACES", share_of(2000)))
MUTANT_TRACES = 400
KINDS = (Kind.SIDES, Kind.SIDES, Kind.MECANUM, Kind.OMNI)

# The rules that the core must not lack: each is a line of it, with its replacement.
MUTANTS = {
    "no time-to-live": ("robot.cpp", "now_ms - arrived_ms_ >= ttl_ms_", "now_ms > ~0u"),
    "goes on by itself": ("robot.cpp", "timed_out_ || has_run_out(now_ms)", "false"),
    "a time-to-live that never ends at the wrap": (
        "robot.cpp", "now_ms - arrived_ms_ >= ttl_ms_", "now_ms >= arrived_ms_ + ttl_ms_",
    ),
    "no session": ("frame.cpp", "frame.type == HELLO ?", "session != 0 ?"),
    "no turns": ("robot.cpp", "frame.turn < turn_", "false"),
    "no sequence": ("robot.cpp", "!is_newer(frame.sequence)", "false"),
    "the same again": ("robot.cpp", "sequence - sequence_ - 1", "sequence - sequence_"),
    "no age": ("robot.cpp", "age_ms > ttl_of(frame)", "false"),
    "no age since hello": ("robot.cpp", "age_ms > now_ms - hello_ms_", "false"),
    "a stop is of its turn only": (
        "robot.cpp", "frame.type == HELLO || frame.type == STOP", "frame.type == HELLO",
    ),
    "a stop that another motion follows": ("robot.cpp", "stand();\n    }", "break;\n    }"),
    "a hello that does not stop": ("robot.cpp", "stand();\n            return;", "return;"),
    "a stop that forgets what came after it": (
        "robot.cpp", "if (is_newer(frame.sequence)) sequence_", "sequence_",
    ),
    "a move of any age": ("robot.cpp", "if (is_late(", "if (frame.type != MOVE && is_late("),
    "a stop that turns on": (
        "robot.cpp", "wanted : wanted_) wanted = 0", "wanted : wanted_)\n"
        "        if (&wanted < wanted_ + 2) wanted = 0",
    ),
    "a CRC of few bits": ("frame.cpp", "session) == said", "session) % 16 == said % 16"),
}  # fmt: skip
SHORT = ("no time-to-live", "no sequence", "a hello that does not stop")


@pytest.mark.timeout(3600)
def test_no_wrong_execution() -> None:
    """Corrupt, repeated, disordered, lost, late, inserted, forged or foreign: no frame moves it."""
    counts: Counter[str] = Counter()
    errors: Counter[str] = Counter()
    for seed in range(TRACES):
        trace = make_trace(Random(seed), KINDS[seed % len(KINDS)])
        try:
            counts += play(trace)
        except AssertionError as error:
            raise AssertionError(f"trace {seed}: {error}") from error
        errors += trace.errors
    assert set(errors) == set(ERRORS)
    assert counts["taken"] > 5 * TRACES
    assert counts["refused"] > TRACES


@pytest.mark.system  # each builds a core of its own
@pytest.mark.parametrize("fault", [*SHORT, *at_length(*sorted(MUTANTS.keys() - SHORT))])
def test_a_core_without_one_of_its_rules_is_found_out(fault: str, tmp_path: Path) -> None:
    """With any one rule removed from the core, the same traces find a wrong execution."""
    core = _mutant(tmp_path, *MUTANTS[fault])
    with pytest.raises(AssertionError):  # noqa: PT012
        for seed in range(MUTANT_TRACES):
            play(make_trace(Random(seed), KINDS[seed % len(KINDS)]), core)


def _mutant(folder: Path, name: str, line: str, instead: str) -> ctypes.CDLL:
    """Build the core with one line of it changed."""
    shutil.copytree(FIRMWARE, folder / "firmware")
    source = folder / "firmware" / "wax" / "src" / "core" / name
    text = source.read_text(encoding="utf-8")
    assert text.count(line) == 1, f"{name} has no such line any more: {line}"
    source.write_text(text.replace(line, instead), encoding="utf-8")
    library = build(folder / "firmware", folder)
    return load(library)
