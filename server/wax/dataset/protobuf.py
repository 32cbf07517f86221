"""Encodes Protocol Buffers messages, and the schemas by which a reader of MCAP decodes them. Pure.

Only what an exported tape needs (https://protobuf.dev/programming-guides/encoding). The viewers
decode no JSON as pictures or as poses.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

_VARINT: Final = 0
_FIXED64: Final = 1
_BYTES: Final = 2
_FIXED32: Final = 5
_TYPES: Final = {
    "double": (1, _FIXED64),
    "int64": (3, _VARINT),
    "fixed32": (7, _FIXED32),
    "bool": (8, _VARINT),
    "string": (9, _BYTES),
    "bytes": (12, _BYTES),
    "int32": (5, _VARINT),
}
"""The number of each type in `descriptor.proto`, and how it is encoded."""
_MESSAGE: Final = 11
_ENUM: Final = 14
_OPTIONAL: Final = 1
_REPEATED: Final = 3


@dataclass(frozen=True, slots=True)
class Enum:
    """An enumeration within a message."""

    name: str
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Field:
    """A field; `type` is one of `_TYPES`, a message or an enumeration."""

    name: str
    number: int
    type: str | MessageType | Enum
    repeated: bool = False


@dataclass(frozen=True, slots=True)
class MessageType:
    """A type of message, by its package and name."""

    package: str
    name: str
    fields: tuple[Field, ...]

    @property
    def full_name(self) -> str:
        return f"{self.package}.{self.name}"

    @property
    def file(self) -> str:
        """The file's published name: a reader that knows it compares the two."""
        path = f"{self.package.replace('.', '/')}/{self.name}.proto"
        return path.lower() if self.package == "google.protobuf" else path


def encode(message: MessageType, values: Mapping[str, Any]) -> bytes:
    """Encode a message; what `values` does not have, or has as None, is left out."""
    return b"".join(
        _field(one, value)
        for one in message.fields
        if (given := values.get(one.name)) is not None
        for value in (given if one.repeated else (given,))
    )


def schema_of(message: MessageType) -> bytes:
    """Return the `FileDescriptorSet` of a message and of all messages in it."""
    files = [{"file": _described(one)} for one in _with_parts(message)]
    return b"".join(encode(_FILE_SET, one) for one in files)


def _field(field: Field, value: Any) -> bytes:
    if isinstance(field.type, MessageType):
        return _packed(field.number, encode(field.type, value))
    if isinstance(field.type, Enum):
        return _key(field.number, _VARINT) + _varint(field.type.values.index(value))
    wire = _TYPES[field.type][1]
    if wire == _BYTES:
        return _packed(field.number, value.encode() if isinstance(value, str) else value)
    if wire == _VARINT:
        return _key(field.number, wire) + _varint(int(value))
    return _key(field.number, wire) + struct.pack("<d" if wire == _FIXED64 else "<I", value)


def _packed(number: int, data: bytes) -> bytes:
    return _key(number, _BYTES) + _varint(len(data)) + data


def _key(number: int, wire: int) -> bytes:
    return _varint(number << 3 | wire)


def _varint(value: int) -> bytes:
    value &= 2**64 - 1
    encoded = bytearray()
    while value > 0x7F:
        encoded.append(value & 0x7F | 0x80)
        value >>= 7
    encoded.append(value)
    return bytes(encoded)


# --- the schema of schemas (google/protobuf/descriptor.proto) ---------------------------------

_STRING: Final = "string"
_ENUM_VALUE: Final = MessageType(
    "", "EnumValueDescriptorProto", (Field("name", 1, _STRING), Field("number", 2, "int32"))
)
_ENUM_TYPE: Final = MessageType(
    "", "EnumDescriptorProto", (Field("name", 1, _STRING), Field("value", 2, _ENUM_VALUE, True))
)
_FIELD: Final = MessageType(
    "",
    "FieldDescriptorProto",
    (
        Field("name", 1, _STRING),
        Field("number", 3, "int32"),
        Field("label", 4, "int32"),
        Field("type", 5, "int32"),
        Field("type_name", 6, _STRING),
    ),
)
_DESCRIPTOR: Final = MessageType(
    "",
    "DescriptorProto",
    (
        Field("name", 1, _STRING),
        Field("field", 2, _FIELD, True),
        Field("enum_type", 4, _ENUM_TYPE, True),
    ),
)
_FILE: Final = MessageType(
    "",
    "FileDescriptorProto",
    (
        Field("name", 1, _STRING),
        Field("package", 2, _STRING),
        Field("dependency", 3, _STRING, True),
        Field("message_type", 4, _DESCRIPTOR, True),
        Field("syntax", 12, _STRING),
    ),
)
_FILE_SET: Final = MessageType("", "FileDescriptorSet", (Field("file", 1, _FILE),))


def _with_parts(message: MessageType) -> Iterable[MessageType]:
    """Return each message once, after those that are in it."""
    found: dict[str, MessageType] = {}

    def visit(one: MessageType) -> None:
        for field in one.fields:
            if isinstance(field.type, MessageType):
                visit(field.type)
        found[one.full_name] = one

    visit(message)
    return found.values()


def _described(message: MessageType) -> dict[str, Any]:
    parts = {one.type.file for one in message.fields if isinstance(one.type, MessageType)}
    enums = [one.type for one in message.fields if isinstance(one.type, Enum)]
    return {
        "name": message.file,
        "package": message.package,
        "dependency": sorted(parts),
        "message_type": [
            {
                "name": message.name,
                "field": [_described_field(message, one) for one in message.fields],
                "enum_type": [
                    {
                        "name": one.name,
                        "value": [
                            {"name": name, "number": number}
                            for number, name in enumerate(one.values)
                        ],
                    }
                    for one in enums
                ],
            }
        ],
        "syntax": "proto3",
    }


def _described_field(message: MessageType, field: Field) -> dict[str, Any]:
    described: dict[str, Any] = {
        "name": field.name,
        "number": field.number,
        "label": _REPEATED if field.repeated else _OPTIONAL,
    }
    match field.type:
        case MessageType():
            return described | {"type": _MESSAGE, "type_name": f".{field.type.full_name}"}
        case Enum():
            name = f".{message.full_name}.{field.type.name}"
            return described | {"type": _ENUM, "type_name": name}
        case _:
            return described | {"type": _TYPES[field.type][0]}
