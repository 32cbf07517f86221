"""``python -m e2e.delay`` from outside: what it says to bad input, and what it leaves behind."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from e2e.browsers.window import installed
from e2e.harness.missing import missing
from e2e.link import Link, UnavailableError, leftovers
from e2e.measure.command import NOT_RUN
from e2e.measure.errors import NotRunError

ROOT = Path(__file__).parents[2]
LAB = (sys.executable, "-m", "e2e.delay")
START_WITHIN_S = 45


@pytest.fixture
async def _possible() -> None:
    """Say why where no link can be made, or where there is no browser."""
    try:
        installed("WAX_CHROMIUM", ["chromium"])
        async with Link("lan"):
            pass
    except (UnavailableError, NotRunError) as error:
        missing(str(error))


def run_lab(
    *arguments: str, before: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    command = [*LAB, *arguments]
    if before:
        apart = ["unshare", "--mount", "--propagation", "unchanged", "sh", "-c"]
        script = f'mount --make-rprivate /dev && {before} && exec "$@"'
        command = [*apart, script, "sh", *command]
    return subprocess.run(
        command,
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=50,
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--only", "E1/campsu"], "lab: no cell's name has E1/campsu in it, did you mean campus;"),
        (["--emulator", "--only", "campsu"], "lab: there is no case *campsu*"),
        (["--n", "0"], "--n 0: allowed is a whole number from 1 to 100"),
        (["--quick", "--long"], "give one of --quick, --long and --emulator"),
        (["--goals", "--quick"], "give --goals or --sound alone"),
    ],
)
def test_bad_input_is_one_sentence(arguments: list[str], said: str) -> None:
    """What is not there or makes no sense ends with 2, and the last line says what it is."""
    done = run_lab(*arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr.splitlines()[-1]


def test_the_list_needs_nothing(tmp_path: Path) -> None:
    """What would be measured is listed where nothing can be, with how long it takes."""
    done = run_lab("--list", "--quick", "--only", "lan", PATH="/nowhere")
    assert done.returncode == 0
    assert "E1/lan/thesis/100ms/8s/0" in done.stdout.splitlines()
    assert "step-down" not in done.stdout
    assert "about" in done.stderr


@pytest.mark.usefixtures("_possible")
def test_an_unwritable_folder_leaves_nothing() -> None:
    """Where the results cannot be kept, nothing is measured and nothing runs on."""
    done = run_lab("--quick", "--only", "E1", "--out", f"{__file__}/run")
    assert (done.returncode, done.stdout) == (2, "")
    assert "name another folder by --out" in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr


@pytest.mark.usefixtures("_possible")
def test_no_browser_is_one_sentence(tmp_path: Path) -> None:
    """Without a browser nothing is written; the sentence says what to install, and 77 that."""
    done = run_lab("--quick", "--out", str(tmp_path / "run"), WAX_CHROMIUM="", PATH="/usr/sbin")
    assert done.returncode == NOT_RUN
    assert done.stderr.startswith("lab not run: there is no ")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.usefixtures("_possible")
def test_a_browser_that_does_not_start_is_no_missing_one(tmp_path: Path) -> None:
    """What is there and broken ends with 2, which nobody takes for a lab that cannot be run."""
    browser = shutil.which("false")
    assert browser is not None
    done = run_lab("--quick", "--out", str(tmp_path / "run"), WAX_CHROMIUM=browser)
    assert done.returncode == 2
    assert done.stderr.startswith("lab: Chromium does not start")
    assert done.stderr.count("\n") == 1


@pytest.mark.skipif(os.geteuid() != 0, reason="only root has rights to give up")
@pytest.mark.parametrize(
    ("before", "said"),
    [
        ("mount -t tmpfs none /dev/net", "lab not run: /dev/net/tun is missing"),
        ("mount --bind /dev/null /dev/net/tun", "lab not run: no TUN device can be made here"),
        ('set -- setpriv --bounding-set=-all --inh-caps=-all "$@"', "lab not run: "),
    ],
)
@pytest.mark.usefixtures("_possible")
def test_no_link_is_one_sentence(tmp_path: Path, before: str, said: str) -> None:
    """Without the device, or the right to make namespaces, 77 says so and nothing is written."""
    done = run_lab("--quick", "--out", str(tmp_path / "run"), before=before)
    assert (done.returncode, done.stdout) == (NOT_RUN, "")
    assert done.stderr.startswith(said)
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.timeout(120)
@pytest.mark.usefixtures("_possible")
def test_an_interrupted_run_leaves_nothing_and_goes_on(tmp_path: Path) -> None:
    """Ctrl-C in a cell ends with 130, with no process left; resumed, the rest is measured."""
    run = tmp_path / "run"
    lab = subprocess.Popen(
        [*LAB, "--quick", "--only", "E2/lan/stock", "--out", str(run)],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    until_s = time.monotonic() + START_WITHIN_S
    while time.monotonic() < until_s and not list(run.glob("*/cells/*/stock.log")):
        time.sleep(0.1)  # until its server has been started
    time.sleep(1.0)
    assert lab.poll() is None
    os.killpg(lab.pid, signal.SIGINT)  # as a terminal does: to all that runs in its foreground
    _, said = lab.communicate(timeout=30)
    assert lab.returncode == 130
    assert "Traceback" not in said
    assert made_by(lab.pid) == []

    results = run / "lab-quick" / "results.jsonl"
    done = run_lab("--quick", "--only", "E2/lan/stock", "--out", str(run), "--resume")
    assert done.returncode == 0, done.stderr
    statuses = [json.loads(line)["status"] for line in results.read_text().splitlines() if line]
    assert statuses == ["ok"]
    assert (run / "lab-quick" / "report.html").exists()


def made_by(owner: int) -> list[int]:
    """Return the processes of a link that this process made."""
    mark = f"{leftovers.MARK}={owner}:".encode()
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                environment = (entry / "environ").read_bytes()
            except OSError:
                continue
            if mark in environment:
                found.append(int(entry.name))
    return found
