"""``python -m tests.mutants.branches``: example tests alone take both ways of each branch.

The sources are those of the mutants; tests that try many cases are left out, because a branch
reached only by chance counts as not reached. `counted` reads the last line. Exit status 1 if a line
or branch is missed.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from typing import Final

import coverage
import pytest
from tests.mutants.plan import ROOT, TARGETS

_FOR_TYPES: Final = "if TYPE_CHECKING:"
_FULL: Final = "--hypothesis-profile=full"


def main() -> int:
    in_python, in_cpp = python(), cpp()
    print(json.dumps([in_python[1:], in_cpp[1:]]))
    return max(in_python[0], in_cpp[0])


def counted() -> tuple[tuple[int, int], tuple[int, int]]:
    """Return how many branches were taken of how many, in Python and in C++.

    It uses a process of its own, because after mutations the modules are already imported.
    """
    done = subprocess.run(
        [sys.executable, "-m", "tests.mutants.branches"],
        cwd=ROOT,
        check=False,
        stdout=subprocess.PIPE,
        text=True,
    )
    print(done.stdout)
    (python_taken, python_of), (cpp_taken, cpp_of) = json.loads(done.stdout.splitlines()[-1])
    return (python_taken, python_of), (cpp_taken, cpp_of)


def _examples(*, is_cpp: bool) -> list[str]:
    found = [test for one in TARGETS if one.is_cpp is is_cpp for test in one.examples]
    return list(dict.fromkeys(found))


def python() -> tuple[int, int, int]:
    """Take the branches of the Python modules; return exit status, how many were taken, and all."""
    files = [str(ROOT / one.file) for one in TARGETS if not one.is_cpp]
    taken = coverage.Coverage(data_file=None, branch=True, config_file=False, include=files)
    taken.exclude(_FOR_TYPES)
    with taken.collect():
        failed = pytest.main(
            ["-q", "--no-header", "-p", "no:cacheprovider", _FULL, *_examples(is_cpp=False)]
        )
    share = taken.report(show_missing=True, skip_covered=True)
    with tempfile.NamedTemporaryFile(suffix=".json") as report:
        taken.json_report(outfile=report.name)
        totals = json.load(report)["totals"]
    status = 1 if failed or share < 100 else 0
    return status, totals["covered_branches"], totals["num_branches"]


def cpp() -> tuple[int, int, int]:
    """Take the branches of the firmware's core; return what `python` does."""
    tests = [sys.executable, "-m", "pytest", "-q", "--no-header", _FULL, *_examples(is_cpp=True)]
    script = ["sh", ".make/firmware.sh", "coverage", *tests]
    done = subprocess.run(script, cwd=ROOT, check=False, stdout=subprocess.PIPE, text=True)
    print(done.stdout)
    total = re.search(r"^TOTAL +(\d+) +(\d+) ", done.stdout, re.MULTILINE)
    of, taken = (int(total[1]), int(total[2])) if total else (0, 0)
    return (1 if done.returncode else 0), taken, of


if __name__ == "__main__":
    sys.exit(main())
