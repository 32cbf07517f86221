"""A class's name says which it is: in a stack trace, in the log and to grep."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import wax


def test_no_two_public_classes_have_one_name() -> None:
    names = Counter(
        name
        for path in Path(wax.__file__).parent.rglob("*.py")
        for name in re.findall(r"^class ([A-Z]\w*)", path.read_text("utf-8"), re.MULTILINE)
    )
    assert [name for name, count in names.items() if count > 1] == []
