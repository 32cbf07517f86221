"""The permission table, cell by cell."""

from __future__ import annotations

from typing import get_args

import pytest

from wax.access import permissions
from wax.access.permissions import PERMISSIONS, ROLES, Role
from wax.errors import ForbiddenError
from wax.protocol import host_switches, messages

ANYBODY = "stranger embed observer adviser operator host"
WATCHING = "embed observer adviser operator host"
INSIDE = "observer adviser operator host"
CELLS: dict[permissions.Act, str] = {
    messages.Ping: WATCHING,
    messages.Report: WATCHING,
    messages.Want: WATCHING,
    messages.Received: WATCHING,
    messages.SetName: INSIDE,
    messages.Look: INSIDE,
    messages.Follow: INSIDE,
    messages.Join: INSIDE,
    messages.Leave: INSIDE,
    messages.Here: INSIDE,
    messages.Operate: INSIDE,
    messages.Stop: f"{INSIDE} house",
    messages.Drive: "operator host",
    messages.KeepTape: "adviser operator host",
    messages.SetTask: "adviser operator host",
    messages.Disown: INSIDE,
    messages.Release: "adviser operator host house",
    permissions.SPEAK: "adviser operator host",
    permissions.DIAGNOSIS: "host",
    **dict.fromkeys(get_args(messages.HostIn), "host"),
    host_switches.HoldQueue: "host house",
    host_switches.Close: "host house",
    host_switches.Blank: "host house",
    "GET /": ANYBODY,
    "GET /assets": ANYBODY,
    "GET /page.css": ANYBODY,
    "GET /preview": ANYBODY,
    "GET /open.ics": ANYBODY,
    "GET /oembed": ANYBODY,
    "GET /healthz": ANYBODY,
    "GET /readyz": ANYBODY,
    "GET /api/ice": ANYBODY,
    "GET /api/present": ANYBODY,
    "POST /api/host": ANYBODY,
    "POST /api/enter": ANYBODY,
    "POST /api/offer": ANYBODY,
    "POST /api/embed": ANYBODY,
    "POST /api/queue": ANYBODY,
    "POST /api/seat": ANYBODY,
    "POST /api/stop": INSIDE,
    "POST /api/release": "adviser operator host",
    "GET /api/status": "host",
    "GET /api/proof": "host",
    "POST /api/proof": "host",
    "GET /api/proof/record": "host",
}
"""A second copy of the table, so that a change to it is deliberate."""


@pytest.mark.parametrize("role", ROLES)
def test_every_cell(role: Role) -> None:
    """Each role may do what its cell allows, and is otherwise told who may."""
    for act, cell in CELLS.items():
        may = role in cell.split()
        assert permissions.may(role, act) is may
        if may:
            permissions.check(role, act)
            continue
        drives_otherwise = role == "adviser" and "operator" in cell.split()
        sentence = r"^Only the person aboard" if drives_otherwise else r"^Only .* can do that\.$"
        with pytest.raises(ForbiddenError, match=sentence):
            permissions.check(role, act)


def test_every_message_has_its_row() -> None:
    """Every message of the protocol has a row."""
    known = {*get_args(messages.DriveIn), *get_args(messages.StateIn)}
    assert known == {act for act in PERMISSIONS if isinstance(act, type)}
    assert PERMISSIONS.keys() == CELLS.keys()


@pytest.mark.parametrize("role", ROLES)
def test_what_is_in_no_row_nobody_may(role: Role) -> None:
    """An act without a row is forbidden to every role."""
    with pytest.raises(ForbiddenError, match="Nobody can do that"):
        permissions.check(role, "GET /api/new")
