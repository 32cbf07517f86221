"""Searches one target for inputs that fail, guided by coverage (libFuzzer, by atheris).

``python -m tests.fuzz.search TARGET OPTIONS FOLDERS`` does that in a process of its own: libFuzzer
ends its process at the first such input, and writes it to a file of the corpus.
"""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.fuzz.target import Target

LONGEST_S: Final = 20 * 60
_KEPT: Final = ROOT / ".cache" / "fuzz"
"""The inputs that earlier searches kept, from which the next one starts."""

_INSTRUMENTED: Final = ("wax", "aiortc", "aioice", "mcap", "tomllib")
_HANGS_S: Final = 20
_MOST_MIB: Final = 2048
_FAILED: Final = {70, 71, 76, 77}
"""libFuzzer's statuses for time and memory exceeded, and for a crash."""


@dataclass(frozen=True, slots=True)
class Searched:
    """How many inputs were tried, and the file of the one that failed, if one did."""

    inputs: int
    took_s: float
    failed: Path | None
    report: str


def search(target: Target, inputs: int) -> Searched:
    """Try `inputs`, or as many as 20 minutes allow; raises `NotRunError` without atheris."""
    kept = _KEPT / target.name
    for folder in (kept, target.folder):
        folder.mkdir(parents=True, exist_ok=True)
    before = set(target.corpus())
    with tempfile.TemporaryDirectory(prefix="wax-fuzz-") as scratch:
        words, seeds = Path(scratch) / "words", Path(scratch) / "seeds"
        words.write_text("".join(f'"{_escaped(word)}"\n' for word in target.words))
        seeds.mkdir()
        for number, seed in enumerate((*target.seeds, *target.long_seeds)):
            (seeds / str(number)).write_bytes(seed)
        options = {
            "runs": inputs,
            "max_total_time": LONGEST_S,
            "max_len": target.max_bytes,
            "timeout": _HANGS_S,
            "rss_limit_mb": _MOST_MIB,
            "dict": words,
            "artifact_prefix": f"{target.folder}/",
            "print_final_stats": 1,
        }
        began_s = time.monotonic()
        done = subprocess.run(
            [sys.executable, "-m", "tests.fuzz.search", target.name]
            + [f"-{name}={value}" for name, value in options.items()]
            + [str(folder) for folder in (kept, seeds, target.folder)],
            cwd=ROOT,
            env=os.environ | {"TMPDIR": scratch},  # libFuzzer ends it without closing the output
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        took_s = time.monotonic() - began_s
    report = done.stdout + done.stderr
    if "No module named 'atheris'" in report:
        raise NotRunError("there is no atheris for this machine (it has Linux on x86-64)")
    found = re.findall(r"stat::number_of_executed_units:\s*(\d+)", report)
    if not found or done.returncode not in {0, *_FAILED}:
        raise MeasureError(f"it ended with {done.returncode}: {report.strip()[-300:]}")
    failed = sorted(set(target.corpus()) - before) if done.returncode else []
    if not target.corpus():
        target.folder.rmdir()
    if done.returncode and not failed:
        raise MeasureError(f"it failed without an input: {report.strip()[-300:]}")
    return Searched(int(found[-1]), took_s, failed[0] if failed else None, report)


def _escaped(word: bytes) -> str:
    return "".join(f"\\x{byte:02x}" for byte in word)


def main(words: Sequence[str]) -> None:
    """Search here, until libFuzzer ends the process."""
    atheris: Any = importlib.import_module("atheris")  # has no types, and not every machine has it
    name, *options = words
    # What guides the search must be imported in this block, and not earlier.
    with atheris.instrument_imports(include=list(_INSTRUMENTED), enable_loader_override=False):
        from tests.fuzz.plan import TARGETS  # noqa: PLC0415  # see above
        from tests.fuzz.target import quiet  # noqa: PLC0415  # see above
    with quiet():
        atheris.Setup([sys.argv[0], *options], TARGETS[name].try_cost)
        atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1:])
