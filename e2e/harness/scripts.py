"""Questions to a page by script alone, the same in every browser."""

from __future__ import annotations

import json
from typing import Any, Protocol

from e2e.harness.wait import eventually


class Window(Protocol):
    async def evaluate(self, expression: str) -> Any: ...


async def reads(window: Window, words: str) -> None:
    """Wait until these words are on the page."""
    what = f"the page says “{words}”"
    await eventually(lambda: window.evaluate(says(words)), what, within_s=15)


def says(words: str) -> str:
    """Return an expression that is true once these words are on the page."""
    return f"document.body?.innerText.includes({json.dumps(words)})"


def press(name: str) -> str:
    """Return a script that presses the button with this text, and is true if there is one."""
    return (
        "((button) => Boolean(button && !button.disabled && (button.click(), true)))"
        f"({_button(name)})"
    )


def has(name: str) -> str:
    """Return an expression that is true once there is a button with this text."""
    return f"Boolean({_button(name)})"


def _button(name: str) -> str:
    return (
        "[...document.querySelectorAll('button')].find((one) => "
        f"(one.getAttribute('aria-label') ?? one.textContent).trim() === '{name}')"
    )
