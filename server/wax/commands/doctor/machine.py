"""Checks the machine: its clock, processor, limits, disk and buffers."""

from __future__ import annotations

import ctypes
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

from wax.capture.testcard import TestCardVideo
from wax.clock import SystemClock
from wax.commands.doctor.verdict import Verdict, bad, ok, warning
from wax.encode.choice import Encoders
from wax.errors import reason_of
from wax.machine import cores, threads
from wax.web import descriptors

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.config.settings import Settings
    from wax.config.video import VideoSettings
    from wax.encode.auto_size import Prepared

_NOT_SYNCHRONISED: Final = 0x40
"""STA_UNSYNC (linux/timex.h)."""
_RMEM: Final = Path("/proc/sys/net/core/rmem_max")
_WANTED_BYTES: Final = 1 << 20
"""The buffer that the socket of all viewers asks for: a quarter of a second of 40 small datagrams
a second from each of 100 viewers, which the kernel counts as about 1 kB each."""
_FULL_BYTES: Final = 100 << 20
_LITTLE_BYTES: Final = 1 << 30
_CORE_BUSY: Final = 0.8
_CORES_SHARE: Final = 0.5
"""Half of the cores are left to everything else, as in the server's own choice of encoders."""


class _Timex(ctypes.Structure):
    """The first fields of `struct timex` (adjtimex(2)), and padding for the rest."""

    _fields_ = (
        ("modes", ctypes.c_uint),
        ("offset", ctypes.c_long),
        ("frequency", ctypes.c_long),
        ("max_error_us", ctypes.c_long),
        ("estimated_error_us", ctypes.c_long),
        ("status", ctypes.c_int),
        ("rest", ctypes.c_byte * 256),
    )


def _clock_status() -> int:
    """Return the kernel's clock status; raises `OSError` if there is none."""
    if not sys.platform.startswith("linux"):
        raise OSError("it does not tell")
    timex = _Timex()
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.adjtimex(ctypes.byref(timex)) < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return int(timex.status)


def clock(read_status: Callable[[], int] = _clock_status) -> Verdict:
    """Ask the kernel whether its clock is synchronized."""
    try:
        status = read_status()
    except OSError as error:
        return ok(f"This system does not say whether its clock is right ({error}).")
    if status & _NOT_SYNCHRONISED:
        return warning(
            "Nothing keeps the clock of this machine right; records, links that expire and the time"
            " in the picture follow it.",
            "Type `sudo timedatectl set-ntp true`, or install chrony.",
        )
    return ok("The clock is kept right.")


def picture_size(prepared: Prepared) -> Verdict:
    """Report the size of the driving view and why it is this one."""
    told = f"The picture has {prepared.chosen[0]}."
    if prepared.is_slow:
        return warning(
            told, "Set width and height in [video] for more, which will be fewer pictures a second."
        )
    return ok(told)


def encoder(settings: VideoSettings, encoders: Encoders) -> Verdict:
    """Report the driving view's encoder, and why it is not hardware."""
    if settings.codec == "vp8":
        return ok('VP8 is encoded by the processor; hardware is for [video] codec = "h264".')
    if encoders.problem is not None:
        return warning(encoders.problem, 'Write [video] encoder = "auto", or "software".')
    names = {encoders.name_of(one) for one in settings.renditions}
    told = f"H.264 is encoded by {' and '.join(sorted(names))}"
    if len(names) == 1 and encoders.refused and "libx264" in names:
        why = "; ".join(f"{name}: {why}" for name, why in encoders.refused.items())
        told += f"; no hardware: {why}"
    return ok(f"{told}.")


def processor(
    settings: VideoSettings,
    encoders: Encoders | None = None,
    *,
    seconds: float = 1.0,
    cpu_s: Callable[[], float] = time.thread_time,
    usable: float | None = None,
) -> Verdict:
    """Encode the test card as configured for a second, and report the share of a core used."""
    usable = usable or cores.usable()
    card = TestCardVideo(settings, SystemClock())
    makers = encoders or Encoders(settings)
    made = [makers.make(one) for one in settings.renditions]
    spent_s = [0.0] * len(made)
    pictures = 0
    card.open()
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        picture = card.read()
        pictures += 1
        for number, one in enumerate(made):
            began_s = cpu_s()
            one.encode(picture, keyframe=False)
            spent_s[number] += cpu_s() - began_s
    card.close()
    # By the picture: a machine that is too slow gets fewer of them into the time.
    renditions = settings.renditions
    shares = [spent / pictures * one.fps for spent, one in zip(spent_s, renditions, strict=True)]
    told = f"Encoding {renditions[0].size} takes {shares[0]:.0%} of a core"
    if len(shares) > 1:
        told += f", all {len(shares)} renditions together {sum(shares):.0%}"
    told += f", of {usable:.3g} {'core' if usable == 1 else 'cores'}"
    advice = "Configure smaller or fewer video.renditions, or fewer pictures a second."
    if shares[0] > _CORE_BUSY:
        return bad(f"{told}: too much.", advice)
    if sum(shares) > _CORES_SHARE * usable:
        return warning(f"{told}: more than half, once every one is watched.", advice)
    return ok(f"{told}.")


def open_files(settings: Settings, most: int | None = None) -> Verdict:
    """Report whether the configured connections fit the server's limit of open files."""
    most = descriptors.limit(hard=True) if most is None else most
    if most is None:
        return ok("This system does not limit how many files a program may have open.")
    wanted = settings.server.max_connections
    fitting = descriptors.connections_that_fit(settings, most)
    told = f"A program of this user may have {most} files open"
    if fitting < wanted:
        return warning(
            f"{told}; beside the viewers' sockets {fitting} HTTP connections fit, not {wanted}.",
            "Raise it: `LimitNOFILE=` in the unit of systemd, or /etc/security/limits.conf.",
        )
    return ok(f"{told}, which is enough for {wanted} connections.")


def further_threads(*, running: bool) -> Verdict:
    """Try to start as many threads as the server needs, unless it runs."""
    if running:
        return ok("WAX, which is running, has its threads.")
    told = threads.problem(threads.SERVERS)
    if told:
        return bad(told, threads.ADVICE)
    return ok(f"This user may start the {threads.SERVERS} threads that WAX takes.")


def disk(folder: Path, free_bytes: Callable[[Path], int] | None = None) -> Verdict:
    """Try to write in the folder, or where it would be created, and check the free space."""
    there = folder
    while not there.exists() and there != there.parent:
        there = there.parent
    try:
        with tempfile.TemporaryFile(dir=there) as probe:
            probe.write(b"wax")
            probe.flush()
        free = free_bytes(there) if free_bytes else shutil.disk_usage(there).free
    except OSError as error:
        return bad(
            f"Nothing can be kept in {folder}: {reason_of(error)}.",
            "Make it writable for the user that runs WAX, or choose another folder.",
        )
    told = f"{folder} can be written to, {free / 1e9:.1f} GB are free"
    if free < _FULL_BYTES:
        return bad(f"{told}: nearly full.", "Make room, or choose a folder on another disk.")
    if free < _LITTLE_BYTES:
        return warning(f"{told}.", "Make room: records of some weeks take up to 1 GB.")
    return ok(f"{told}.")


def udp_buffer(path: Path = _RMEM) -> Verdict:
    """Check how many bytes the kernel can buffer while the server is busy."""
    try:
        most = int(path.read_text(encoding="ascii"))
    except (OSError, ValueError):
        return ok("This system does not say how large a UDP buffer may be.")
    if most < _WANTED_BYTES:
        return warning(
            f"A UDP buffer may have {most // 1024} KiB; with many viewers commands are lost in it.",
            f"Type `sudo sysctl -w net.core.rmem_max={_WANTED_BYTES}`, and write the same into"
            " /etc/sysctl.d/wax.conf.",
        )
    return ok(f"A UDP buffer may have {most // 1024} KiB.")
