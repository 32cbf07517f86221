"""The machine: its clock, processor, disk and buffers, good and bad."""

from __future__ import annotations

import itertools
import sys
from typing import TYPE_CHECKING, Any

import pytest

from wax.commands.doctor import machine
from wax.config.settings import Settings
from wax.encode.auto_size import Prepared
from wax.encode.choice import Encoders
from wax.encode.trial import Trial

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

SMALL = {"renditions": [{"width": 160, "height": 120, "fps": 15.0, "bitrate_bps": 50_000}]}


def _no_clock() -> int:
    raise PermissionError("not in this container")


@pytest.mark.parametrize(
    ("read", "level"), [(lambda: 0x2001, "ok"), (lambda: 0x41, "warning"), (_no_clock, "ok")]
)
def test_a_clock_that_nothing_keeps_right_is_told(read: Callable[[], int], level: str) -> None:
    """An unsynchronized clock is a warning; a system that cannot say is ok."""
    assert machine.clock(read).level == level


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="adjtimex is Linux's")
def test_the_kernel_is_really_asked() -> None:
    """The kernel's clock status has only bits that the header defines."""
    assert 0 <= machine._clock_status() < 1 << 16


@pytest.mark.parametrize(
    ("step_s", "cores", "level"),
    [(0.0001, 2, "ok"), (0.003, 2, "ok"), (0.06, 8, "bad")],
)
def test_the_share_of_a_core_decides(step_s: float, cores: int, level: str) -> None:
    """An encoder that needs most of a core for one rendition is too slow."""
    settings = Settings.model_validate({"video": SMALL}).video
    readings = itertools.count(0.0, step_s)
    verdict = machine.processor(settings, seconds=0.1, cpu_s=lambda: next(readings), usable=cores)
    assert verdict.level == level, verdict
    assert "160x120" in verdict.sentence


def test_many_sizes_may_be_too_much() -> None:
    """Renditions that together need more than half the cores are too much."""
    settings = Settings().video
    readings = itertools.count(0.0, 0.01)
    verdict = machine.processor(settings, seconds=0.2, cpu_s=lambda: next(readings), usable=1)
    assert (verdict.level, "all 6 renditions" in verdict.sentence) == ("warning", True), verdict


H264 = {"codec": "h264", **SMALL}


@pytest.mark.parametrize(
    ("keys", "trial", "level", "says"),
    [
        ({}, None, "ok", "VP8 is encoded by the processor"),
        ({**H264, "encoder": "software"}, None, "ok", "H.264 is encoded by libx264."),
        (
            H264,
            Trial("h264_qsv", problem="it is not here"),
            "ok",
            "libx264; no hardware: h264_qsv: it is not here.",
        ),
        (
            H264,
            Trial("h264_qsv", ms={"160x120 at 50 kbit/s": 1.0}),
            "ok",
            "H.264 is encoded by h264_qsv.",
        ),
        (
            {**H264, "encoder": "h264_qsv"},
            Trial("h264_qsv", problem="it is not here"),
            "warning",
            "h264_qsv does not work here (it is not here)",
        ),
    ],
)
def test_what_encodes_is_told(
    keys: dict[str, Any], trial: Trial | None, level: str, says: str
) -> None:
    """The verdict names the encoder, and why hardware is not used or cannot be."""
    settings = Settings.model_validate({"video": keys}).video
    verdict = machine.encoder(settings, Encoders(settings, [trial] if trial else []))
    assert (verdict.level, says in verdict.sentence) == (level, True), verdict


@pytest.mark.parametrize(("is_slow", "level"), [(False, "ok"), (True, "warning")])
def test_the_size_of_the_picture_is_told(is_slow: bool, level: str) -> None:
    """The verdict has the size and why, and warns if this machine is too slow for more."""
    prepared = Prepared(Settings(), [], ["640x480: it is"], is_slow)
    verdict = machine.picture_size(prepared)
    assert (verdict.level, verdict.sentence) == (level, "The picture has 640x480: it is.")


def test_a_folder_that_can_be_written_is_well(tmp_path: Path) -> None:
    """A writable folder, even one to be created, is ok, with its free space."""
    verdict = machine.disk(tmp_path / "not" / "yet")
    assert (verdict.level, "GB are free" in verdict.sentence) == ("ok", True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("free", "level"), [(5 << 30, "ok"), (500 << 20, "warning"), (50 << 20, "bad")]
)
def test_a_full_disk_is_told(tmp_path: Path, free: int, level: str) -> None:
    """Little free space is a warning, hardly any is bad."""
    assert machine.disk(tmp_path, lambda _: free).level == level


def test_a_folder_that_cannot_be_is_bad(tmp_path: Path) -> None:
    """A file in place of the folder is bad."""
    (tmp_path / "file").write_text("")
    verdict = machine.disk(tmp_path / "file" / "wax")
    assert (verdict.level, "writable" in verdict.advice) == ("bad", True)


@pytest.mark.parametrize(
    ("text", "level"), [("4194304\n", "ok"), ("212992\n", "warning"), ("", "ok"), (None, "ok")]
)
def test_a_small_buffer_is_told(tmp_path: Path, text: str | None, level: str) -> None:
    """Debian's default buffer is too small for a crowd; an unknown size is ok."""
    path = tmp_path / "rmem_max"
    if text is not None:
        path.write_text(text)
    verdict = machine.udp_buffer(path)
    assert (verdict.level, "sysctl" in verdict.advice) == (level, level == "warning")
