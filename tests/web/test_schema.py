"""The schema from which the page's types are generated."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from typing import Any, get_args

from wax.access.permissions import PERMISSIONS
from wax.protocol import messages, room_change, tape_events
from wax.web import schema as described

schema = cache(described.schema)


def members(union: Any) -> set[str]:
    """Return the names of the messages in an annotated or plain union."""
    while not isinstance(union, type) and not all(isinstance(m, type) for m in get_args(union)):
        union = get_args(union)[0]
    return {member.__name__ for member in get_args(union) or (union,)}


def test_every_message_is_described() -> None:
    """Each message of each channel and direction has a definition of its own."""
    made = schema()
    channels = ("DriveIn", "DriveOut", "StateIn", "StateOut")
    assert set(made["properties"]) == {*channels, "Bodies", "Answers"}
    names = set().union(*(members(getattr(messages, name)) for name in channels))
    assert {one.__name__ for one in PERMISSIONS if isinstance(one, type)} < names
    assert {"Pong", "Hello", "RoomState"} < names
    assert names <= set(made["$defs"])


def test_what_the_server_writes_is_all_required() -> None:
    """The page may rely on every field, `type` above all; only a change may lack parts."""
    definitions = schema()["$defs"]
    for name in members(messages.StateOut) | members(messages.DriveOut):
        definition = definitions[name]
        absent = set(room_change.PARTS) if name == "RoomChange" else set()
        assert set(definition["required"]) == set(definition["properties"]) - absent, name


def test_every_body_of_a_request_is_described() -> None:
    """The page's types know what it posts to each route, and what it is answered there."""
    posted = {act for act in PERMISSIONS if isinstance(act, str) and act.startswith("POST /")}
    made = schema()["properties"]
    assert {f"POST /{path}" for path in made["Bodies"]["properties"]} == posted
    assert set(made["Answers"]["required"]) == {*made["Bodies"]["required"], "api/ice"}
    assert schema()["$defs"]["OfferAnswer"]["required"] == ["sdp"]


def test_fields_keep_their_docstrings() -> None:
    """The page's types describe a field as the server's models do."""
    held = schema()["$defs"]["Drive"]["properties"]["held"]
    assert held["description"].startswith("The dead man's switch")


def test_what_is_on_a_tape_is_described() -> None:
    """The page of `wax replay` reads the same models; only what is left out at 0 may be absent."""
    definitions = schema()["$defs"]
    for one in (*tape_events.EVENTS, tape_events.TapeListing, tape_events.TapeContent):
        described = definitions[one.__name__]
        assert set(described["properties"]) == set(one.model_fields), one.__name__
        absent = {name for name, field in one.model_fields.items() if field.exclude_if is not None}
        assert set(described["required"]) == set(one.model_fields) - absent, one.__name__


def test_what_the_page_may_leave_out_is_optional() -> None:
    """A field with a default need not be sent, and nothing unknown may be."""
    drive = schema()["$defs"]["Drive"]
    assert set(drive["properties"]) - set(drive["required"]) == {"axes", "lateral"}
    assert drive["additionalProperties"] is False


def test_the_page_is_told_how_long_a_name_is() -> None:
    """The page cuts names at the server's limit, which the schema tells it."""
    assert schema()["constants"]["MAX_NAME_CHARS"] == messages.MAX_NAME_CHARS


def test_the_page_is_told_the_order_of_a_rows_columns() -> None:
    """For every message of the drive channel, all fields are listed in order, nested ones too."""
    made = schema()
    columns = made["constants"]["DRIVE_COLUMNS"]
    assert set(columns) == {"drive", "operate", "ping", "report", "pong", "beat", "operated"}
    for name in members(messages.DriveIn) | members(messages.DriveOut):
        fields = made["$defs"][name]["properties"]
        assert list(columns[name.lower()]) == list(fields), name
    assert list(columns["report"]["picture"]) == list(made["$defs"]["PictureReport"]["properties"])
    assert columns["drive"]["axes"] is None


def test_the_command_prints_it() -> None:
    """`python -m wax.web.schema` prints the schema as JSON and nothing else."""
    command = [sys.executable, "-m", "wax.web.schema"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True, timeout=30)
    assert json.loads(printed.stdout) == schema()
    assert printed.stderr == ""
