"""Lists the numeric constants of congestion control and playout, and changes one."""

from __future__ import annotations

import ast
import importlib
import pkgutil
import sys
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import wax.congestion

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import ModuleType

_PLAYOUT: Final = ("wax.sync.sound_delay", "wax.sync.hold_back", "wax.sync.audio_master")

Number = int | float
Value = Number | tuple[Number, ...]


@dataclass(frozen=True, slots=True)
class Constant:
    """`name` of `module`; `note` is the docstring behind it."""

    module: str
    name: str
    value: Value
    note: str | None

    @property
    def key(self) -> str:
        return f"{self.module.rpartition('.')[2]}.{self.name}"

    def scaled(self, factor: float) -> Value:
        """Return the value times a factor; whole numbers stay whole and positive."""
        if isinstance(self.value, tuple):
            return tuple(_scaled(one, factor) for one in self.value)
        return _scaled(self.value, factor)

    @contextmanager
    def set(self, value: Value) -> Iterator[None]:
        """Give it another value, wherever a module has imported it."""
        homes = [
            module
            for name, module in list(sys.modules.items())
            if name == self.module
            or (
                name.startswith("wax.")
                and not self.name.startswith("_")
                and getattr(module, self.name, None) == self.value
            )
        ]
        for module in homes:
            setattr(module, self.name, value)
        try:
            yield
        finally:
            for module in homes:
                setattr(module, self.name, self.value)


def modules() -> list[str]:
    """Return the modules whose constants are examined."""
    found = [f"wax.congestion.{one.name}" for one in pkgutil.iter_modules(wax.congestion.__path__)]
    return [*found, *_PLAYOUT]


def constants() -> list[Constant]:
    """Return all numeric constants, in the order of the modules."""
    return [one for name in modules() for one in _constants(importlib.import_module(name))]


def _source(module: ModuleType) -> str:
    assert module.__file__ is not None
    return Path(module.__file__).read_text(encoding="utf-8")


def _assigned(module: ModuleType) -> Iterator[tuple[ast.Name, ast.stmt | None]]:
    """Give the annotated names of a module, each with the statement behind it."""
    body = ast.parse(_source(module)).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield node.target, after


def _constants(module: ModuleType) -> list[Constant]:
    found = []
    for name, after in _assigned(module):
        value = getattr(module, name.id)
        numbers = value if isinstance(value, tuple) and not hasattr(value, "_fields") else (value,)
        if all(isinstance(one, Number) and not isinstance(one, bool) for one in numbers):
            found.append(Constant(module.__name__, name.id, value, _note(after)))
    return found


def _note(node: ast.stmt | None) -> str | None:
    match node:
        case ast.Expr(ast.Constant(str(note))):
            return " ".join(note.split())
        case _:
            return None


def _scaled(value: Number, factor: float) -> Number:
    return max(1, round(value * factor)) if isinstance(value, int) else value * factor
