"""``python -m e2e.mutants.branches``: both ways of each branch are taken, by examples alone.

The same sources as for the mutants, without the tests that try many cases: what is reached only
by chance counts as not reached. Exit status 1 where a line or branch is missed.
"""

from __future__ import annotations

import subprocess
import sys
from typing import Final

import coverage
import pytest

from e2e.mutants.plan import ROOT, TARGETS

_FOR_TYPES: Final = "if TYPE_CHECKING:"
_FULL: Final = "--hypothesis-profile=full"


def main() -> int:
    return max(_python(), _cpp())


def _examples(*, is_cpp: bool) -> list[str]:
    found = [test for one in TARGETS if one.is_cpp is is_cpp for test in one.examples]
    return list(dict.fromkeys(found))


def _python() -> int:
    """Take the branches of the Python modules; say what is missed."""
    files = [str(ROOT / one.file) for one in TARGETS if not one.is_cpp]
    taken = coverage.Coverage(data_file=None, branch=True, config_file=False, include=files)
    taken.exclude(_FOR_TYPES)
    with taken.collect():
        failed = pytest.main(
            ["-q", "--no-header", "-p", "no:cacheprovider", _FULL, *_examples(is_cpp=False)]
        )
    share = taken.report(show_missing=True, skip_covered=True)
    return 1 if failed or share < 100 else 0


def _cpp() -> int:
    """Take the branches of the firmware's core; say what is missed."""
    tests = [sys.executable, "-m", "pytest", "-q", "--no-header", _FULL, *_examples(is_cpp=True)]
    script = ["sh", ".make/firmware.sh", "coverage", *tests]
    return 1 if subprocess.run(script, cwd=ROOT, check=False).returncode else 0


if __name__ == "__main__":
    sys.exit(main())
