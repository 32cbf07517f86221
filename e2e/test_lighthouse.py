"""The page as Lighthouse judges it: on a slow phone, over a slow line."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import sys
from asyncio.subprocess import DEVNULL, PIPE
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, Final

import pytest

from e2e.harness import toml
from e2e.harness.chromium import FLAGS, find_chromium
from e2e.harness.missing import missing
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from e2e.conftest import Serve

RUNS: Final = 5
LEAST: Final = {"performance": 95, "accessibility": 95}
PROGRAM: Final = ROOT / ".cache/lighthouse/node_modules/lighthouse/cli/index.js"
POOR: Final = 0.9
"""An audit below this is named where a score is too low."""


def find_node() -> str:
    """Return the Node that builds the page: the one in .venv first."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    return shutil.which("node", path=path) or missing("no Node found: type make test-all")


async def judged(url: str, into: Path) -> dict[str, Any]:
    """Return Lighthouse's report of one visit, with its own emulation of phone and line."""
    if not PROGRAM.exists():
        missing("Lighthouse is not installed: type sh .make/lighthouse.sh")
    flags = [*FLAGS, "--headless=new", "--no-sandbox", "--disable-gpu"]
    process = await asyncio.create_subprocess_exec(
        *(find_node(), str(PROGRAM), url, "--quiet", "--no-enable-error-reporting"),
        *("--output=json", f"--output-path={into}", f"--only-categories={','.join(LEAST)}"),
        f"--chrome-flags={' '.join(flags)}",
        stdin=DEVNULL,
        stdout=PIPE,
        stderr=PIPE,
        env={**os.environ, "CHROME_PATH": find_chromium()},
    )
    _, complaint = await process.communicate()
    assert process.returncode == 0, f"Lighthouse fails: {complaint.decode()[-2000:]}"
    return _read(into)


def _read(path: Path) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    assert "runtimeError" not in report, report["runtimeError"]
    return report


def poor(report: dict[str, Any], category: str) -> list[str]:
    """Return what lowers this score, as Lighthouse calls it."""
    of_it = [one["id"] for one in report["categories"][category]["auditRefs"] if one["weight"]]
    audits = [report["audits"][name] for name in of_it]
    return [
        f"{one['id']}: {one['title']} ({one.get('displayValue') or one['score']})"
        for one in audits
        if one["score"] is not None and one["score"] < POOR
    ]


@pytest.mark.full
@pytest.mark.timeout(600)
async def test_lighthouse_is_content(serve: Serve, tmp_path: Path) -> None:
    """Performance and accessibility are 95 or more, in the median of five visits."""
    async with serve(tmp_path, toml.card_with(turns=toml.BRIEF_GRACE)) as server:
        reports = [
            await judged(server.url, tmp_path / f"report-{number}.json") for number in range(RUNS)
        ]
    for category, least in LEAST.items():
        scores = [100 * report["categories"][category]["score"] for report in reports]
        assert median(scores) >= least, (category, scores, poor(reports[-1], category))
