"""Print what the page is built from: a JSON Schema of messages and bodies, constants, sentences.

``python -m wax.web.schema`` needs only pydantic: the page is built before WAX is installed.
"""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Any, Final

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema

from wax.field_docs import field_docs
from wax.protocol import (
    host_switches,
    http_bodies,
    messages,
    robot_report,
    room_change,
    tape_events,
)
from wax.sentence import CATALOGUE

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaMode

_CHANNELS: Final[dict[str, JsonSchemaMode]] = {
    "DriveIn": "validation",
    "DriveOut": "serialization",
    "StateIn": "validation",
    "StateOut": "serialization",
}
"""What the page sends is described for validation, what it receives for serialisation."""

_HTTP: Final[dict[str, tuple[dict[str, Any], JsonSchemaMode]]] = {
    "Bodies": (http_bodies.BODIES, "validation"),
    "Answers": (http_bodies.ANSWERS, "serialization"),
}

_REPLAYED: Final = (tape_events.TapeListing, tape_events.TapeContent)
"""What `wax replay` sends its page; not messages, so only in ``$defs``."""

_CONSTANTS: Final = ("MAX_NAME_CHARS", "MAX_TASK_CHARS", "DRIVE_COLUMNS")
"""Constants of the protocol that the page needs."""


class _ForThePage(GenerateJsonSchema):
    """The schema in the form that the type generator needs."""

    def field_title_should_be_set(self, schema: Any) -> bool:  # noqa: ARG002  # pydantic's form
        """Leave titles out: each would become a separate type."""
        return False

    def field_is_required(self, field: Any, total: bool) -> bool:
        """Require every field, since the server always writes all but those it may leave out."""
        if "serialization_exclude_if" in field:
            return False
        return self.mode == "serialization" or super().field_is_required(field, total)


def schema() -> dict[str, Any]:
    """Return one schema: a property for each channel and direction, the messages in ``$defs``.

    ``Bodies`` and ``Answers`` have a property for each path that the page asks for.

    Beyond JSON Schema it has ``constants``, values of `messages` that the page needs, too, and
    ``sentences``, the server's English texts by their codes.
    """
    adapters = [
        (name, mode, TypeAdapter[Any](getattr(messages, name))) for name, mode in _CHANNELS.items()
    ]
    adapters += [(one.__name__, "serialization", TypeAdapter[Any](one)) for one in _REPLAYED]
    adapters += [
        (f"{name} {path}", mode, TypeAdapter[Any](body))
        for name, (bodies, mode) in _HTTP.items()
        for path, body in bodies.items()
    ]
    unions, shared = TypeAdapter.json_schemas(adapters, schema_generator=_ForThePage)
    # The only message whose parts may be absent.
    change = shared["$defs"]["RoomChange"]
    change["required"] = [name for name in change["required"] if name not in room_change.PARTS]
    for name in room_change.PARTS:
        change["properties"][name].pop("default", None)
    _describe(shared["$defs"])
    http = {
        name: _object({path: unions[f"{name} {path}", mode] for path in bodies})
        for name, (bodies, mode) in _HTTP.items()
    }
    return {
        "title": "Messages",
        "description": "What page and server exchange: by data channel and direction, by path.",
        **_object({name: unions[name, mode] for name, mode in _CHANNELS.items()} | http),
        "$defs": shared["$defs"],
        "constants": {name: getattr(messages, name) for name in _CONSTANTS}
        | {"ROBOT_NUMBERS": _numbers()},
        "sentences": CATALOGUE,
    }


def _object(properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "object", "properties": properties, "required": list(properties)}


def _numbers() -> list[dict[str, Any]]:
    """Return how the page shows the robot's numbers."""
    shown = ("words", "unit", "factor", "decimals", "is_replayed")
    return [
        {"name": name} | {key: getattr(number, key) for key in shown}
        for name, number in robot_report.ROBOT_NUMBERS.items()
    ]


def _describe(definitions: dict[str, Any]) -> None:
    """Add the fields' docstrings as descriptions; the server itself need not read its source."""
    for module in (host_switches, http_bodies, messages, tape_events):
        for name, definition in definitions.items():
            texts = field_docs(getattr(module, name, object))
            for field, said in definition.get("properties", {}).items():
                if field in texts and "$ref" not in said:
                    said["description"] = texts[field]


if __name__ == "__main__":
    json.dump(schema(), sys.stdout, indent=1)
