"""Say how much of the firmware's core a run has taken, from the notes of gcov in a folder."""

from __future__ import annotations

import gzip
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

CORE = "wax/src/core/"


def main(folder: Path) -> int:
    """Print lines and branches of the core as JSON, and what was missed; 1 if anything was."""
    notes = [str(note) for note in sorted(folder.glob("*.gcda"))]
    subprocess.run(
        ["gcov", "--json-format", "--branch-probabilities", *notes],
        cwd=folder,
        check=True,
        capture_output=True,
    )
    lines: dict[tuple[str, int], int] = {}
    branches: dict[tuple[str, int, int], int] = {}
    for report in sorted(folder.glob("*.gcov.json.gz")):
        with gzip.open(report) as text:
            for file in json.load(text)["files"]:
                if CORE in file["file"]:
                    _count(file, lines, branches)
    missed = sorted({f"{name}:{line}" for (name, line), times in lines.items() if not times})
    untaken = sorted({f"{name}:{line}" for (name, line, _), times in branches.items() if not times})
    found = {
        "lines": len(lines),
        "lines_taken": sum(times > 0 for times in lines.values()),
        "branches": len(branches),
        "branches_taken": sum(times > 0 for times in branches.values()),
        "missed_lines": missed,
        "missed_branches": untaken,
    }
    print(json.dumps(found, indent=2))
    return 1 if missed or untaken or not branches else 0


def _count(
    file: dict[str, Any],
    lines: dict[tuple[str, int], int],
    branches: dict[tuple[str, int, int], int],
) -> None:
    """Add up what each unit says of a file: a header is in several."""
    name = Path(file["file"]).name
    for line in file["lines"]:
        at = name, int(line["line_number"])
        lines[at] = lines.get(at, 0) + int(line["count"])
        for number, branch in enumerate(line["branches"]):
            branches[*at, number] = branches.get((*at, number), 0) + int(branch["count"])


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
