"""A test file is no library."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_no_test_imports_from_another() -> None:
    """What test files share stands in a module of its own, where its users look for it."""
    found = [
        f"{path.relative_to(ROOT)}: {line}"
        for folder in ("tests", "e2e")
        for path in (ROOT / folder).rglob("*.py")
        for line in re.findall(
            r"^ *from (?:tests|e2e)[\w.]*\.test_\w+ import", path.read_text("utf-8"), re.MULTILINE
        )
    ]
    assert found == []
