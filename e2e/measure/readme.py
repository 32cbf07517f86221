"""Tables in Markdown, each between ``<!-- figures: SUITE -->`` and ``<!-- /figures -->``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import Callable

_BLOCK: Final = re.compile(
    r"(?P<begin><!-- figures: (?P<suite>[\w-]+) -->\n)(?P<body>.*?)(?P<end><!-- /figures -->)",
    re.DOTALL,
)


def rendered(text: str, table: Callable[[str], str]) -> str:
    """Put `table(suite)` between each suite's markers; raises `MeasureError` where one is alone."""
    found = _BLOCK.sub(lambda m: f"{m['begin']}{table(m['suite'])}{m['end']}", text)
    begins, ends = text.count("<!-- figures:"), text.count("<!-- /figures -->")
    if not len(_BLOCK.findall(text)) == begins == ends:
        raise MeasureError("a marker of the figures stands alone")
    return found


def blocks(text: str) -> dict[str, str]:
    """Return what stands between the markers, by suite."""
    return {match["suite"]: match["body"] for match in _BLOCK.finditer(text)}
