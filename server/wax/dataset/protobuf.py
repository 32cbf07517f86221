"""Makes messages of Protocol Buffers, and the schemas by which a reader of MCAP decodes them. Pure.

The viewers decode no JSON as pictures or as poses.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping


@dataclass(frozen=True, slots=True)
class Enum:
    """An enumeration within a message."""

    name: str
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Field:
    """A field; `type` is the name of a scalar type, a message or an enumeration."""

    name: str
    type: str | MessageType | Enum
    repeated: bool = False


@dataclass(frozen=True, slots=True)
class MessageType:
    """A type of message, by its package and name; its fields are numbered from 1."""

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


def message_type(package: str, name: str, /, **types: str | MessageType | Enum) -> MessageType:
    """Return a type of message without repeated fields."""
    return MessageType(package, name, tuple(Field(*one) for one in types.items()))


def encode(message: MessageType, values: Mapping[str, Any]) -> bytes:
    """Encode a message; what `values` has as None, or nothing for its fields, is left out.

    Raises `ValueError` for a number that is too large for its field.
    """
    known = {one.name: values.get(one.name) for one in message.fields}
    encoded: bytes = _class_of(message)(**known).SerializeToString()
    return encoded


def schema_of(message: MessageType) -> bytes:
    """Return the `FileDescriptorSet` of a message and of all messages in it."""
    return descriptor_pb2.FileDescriptorSet(file=_files(message)).SerializeToString()


@cache
def _class_of(message: MessageType) -> Any:
    pool = descriptor_pool.DescriptorPool()
    for one in _files(message):
        pool.Add(one)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(message.full_name))


def _files(message: MessageType) -> Iterable[descriptor_pb2.FileDescriptorProto]:
    """Return a file for each message, once, after those that are in it."""
    found: dict[str, descriptor_pb2.FileDescriptorProto] = {}

    def visit(one: MessageType) -> None:
        for field in one.fields:
            if isinstance(field.type, MessageType):
                visit(field.type)
        found[one.full_name] = descriptor_pb2.FileDescriptorProto(**_described(one))

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
                "field": [
                    _described_field(message, *one) for one in enumerate(message.fields, start=1)
                ],
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


def _described_field(message: MessageType, number: int, field: Field) -> dict[str, Any]:
    described: dict[str, Any] = {
        "name": field.name,
        "number": number,
        "label": "LABEL_REPEATED" if field.repeated else "LABEL_OPTIONAL",
    }
    match field.type:
        case MessageType():
            name = f".{field.type.full_name}"
            return described | {"type": "TYPE_MESSAGE", "type_name": name}
        case Enum():
            name = f".{message.full_name}.{field.type.name}"
            return described | {"type": "TYPE_ENUM", "type_name": name}
        case _:
            return described | {"type": f"TYPE_{field.type.upper()}"}
