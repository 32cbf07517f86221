"""The documents: links resolve, and the first page stays short."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Final

import pytest

ROOT: Final = Path(__file__).parents[1]
_LINK: Final = re.compile(r"\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"")
_BLOCK: Final = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
_CODE: Final = re.compile(r"`[^`\n]*`")
_MOST_LINES: Final = 250
_MOST_BYTES: Final = 16_000
TEXTS: Final = sorted(
    subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "*.md"],
        cwd=ROOT,
        capture_output=True,
        check=True,
        text=True,
    )
    .stdout.rstrip("\0")
    .split("\0")
)


def _anchors(text: str) -> set[str]:
    """Return the anchors that GitHub derives from the headings."""
    headings = re.findall(r"^#+ (.+)$", _BLOCK.sub("", text), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", TEXTS)
def test_links_lead_somewhere(name: str) -> None:
    """Every linked file exists, and has the linked heading."""
    path = ROOT / name
    prose = _CODE.sub("", _BLOCK.sub("", path.read_text(encoding="utf-8")))
    for found in _LINK.finditer(prose):
        link = found[1] or found[2]
        if "://" in link:
            continue
        target, _, anchor = link.partition("#")
        there = (path.parent / target).resolve() if target else path
        assert there.exists(), f"{name}: {link}"
        if anchor:
            assert anchor in _anchors(there.read_text(encoding="utf-8")), f"{name}: {link}"


def test_the_readme_is_read_in_five_minutes() -> None:
    """The README stays short enough for five minutes."""
    data = (ROOT / "README.md").read_bytes()
    assert len(data.splitlines()) <= _MOST_LINES
    assert len(data) <= _MOST_BYTES
