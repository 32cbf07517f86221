"""What a browser is to who measures, whichever it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, Literal, Protocol

if TYPE_CHECKING:
    from contextlib import AbstractAsyncContextManager

    from e2e.measure.ear import Ear

Key = Literal["ArrowUp", "KeyT"]
LOAD_WITHIN_S: Final = 120.0
"""A page of some 100 kB takes a modem half a minute."""


class Window(Protocol):
    """One page. All methods raise `MeasureError` with the browser's own words."""

    async def goto(self, url: str) -> None:
        """Open the page; return when it is loaded, with all that it names itself."""

    async def evaluate(self, expression: str) -> Any:
        """Return the value of an expression, awaited, as JSON has it; as if by a touch."""

    async def hold(self, key: Key) -> None:
        """Press a key and keep it pressed."""

    async def release(self, key: Key) -> None:
        """Let go of a key that is held."""


class Browser(Protocol):
    """One process with many windows, each visible to itself, and one sound device: `ear`."""

    ear: Ear

    async def cpu_s(self) -> float | None:
        """Return the processor time of its processes, s; None where it does not tell."""

    def window(self, preload: str) -> AbstractAsyncContextManager[Window]:
        """Have a page without a past; the script `preload` runs in it before its own ones."""


def as_json(expression: str) -> str:
    """Return the expression as one whose value is text, which all browsers hand over alike."""
    return f"(async () => JSON.stringify(await ({expression})))()"
