"""The hand-over's measurement can fail: the server is made to leak an old turn's command."""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING, Final

import pytest

from e2e.measure.suite import ROOT
from e2e.stop.hand_over import hand_over
from e2e.stop.stage import LIGHT

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    Edit = tuple[str, str, str]

SERVER: Final = ROOT / "server"

GATE: Final[tuple[Edit, ...]] = (
    ("access/permissions.py", "messages.Drive: _IN_CHARGE,", "messages.Drive: _INSIDE,"),
    (
        "control/gate.py",
        "refusal = _foreign(state, viewer, command, turn)",
        "refusal = None",
    ),
)
"""Everybody may send commands; the gate accepts them for every turn, in any order."""

NUMBERS: Final[tuple[Edit, ...]] = (
    (
        "control/loop.py",
        "self._safe_driver.steer(setpoint, turn.number)",
        "self._safe_driver.steer("
        "setpoint, self._gate.command.turn if self._gate.command else turn.number)",
    ),
    ("robot/process/driver_watchdog.py", "if message.turn < self._turn:", "if False:"),
    (
        "robot/process/driver_watchdog.py",
        "if turn <= self._turn:\n            return ()\n        self._turn = turn\n"
        "        self._disarm()",
        "if turn == self._turn:\n            return ()\n        self._turn = turn",
    ),
    ("robot/serial/setpoints.py", "if not self._fence.admits(turn):", "if False:"),
)
"""An accepted command's own turn goes down the line, and the driver's process passes it on."""


def leaky(folder: Path, edits: Iterable[Edit]) -> dict[str, str]:
    """Return the environment of a server whose code has these edits, each of which must fit."""
    shutil.copytree(SERVER / "wax", folder / "wax")
    for name, sound, leak in edits:
        path = folder / "wax" / name
        code = path.read_text(encoding="utf-8")
        assert code.count(sound) == 1, f"{name} does not have once: {sound}"
        path.write_text(code.replace(sound, leak), encoding="utf-8")
    return {"PYTHONPATH": os.pathsep.join((str(folder), str(ROOT)))}


@pytest.mark.timeout(180)
@pytest.mark.full
async def test_a_leak_in_the_gate_is_seen_by_the_hands(tmp_path: Path) -> None:
    """The previous operator's motion is counted, although it has the new turn's number."""
    found, _, _ = await hand_over(4, load=LIGHT, environment=leaky(tmp_path, GATE))
    assert not found.met
    assert found.detail["of_the_operator_before"] > 0
    assert found.detail["of_the_old_turn"] == 0


@pytest.mark.timeout(180)
@pytest.mark.full
async def test_a_leak_down_to_the_wire_is_seen_by_the_number(tmp_path: Path) -> None:
    """Frames of the old turn are counted although the board itself refuses each of them."""
    found, _, _ = await hand_over(4, load=LIGHT, environment=leaky(tmp_path, GATE + NUMBERS))
    assert not found.met
    assert found.detail["of_the_old_turn"] > 0
