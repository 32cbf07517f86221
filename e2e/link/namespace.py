"""Makes anonymous network namespaces, held by the process that makes them, and their TUN devices.

Because they have no name, the kernel removes them when the last process in them ends, however it
ends. As root a namespace is made directly, otherwise inside a user namespace.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import shutil
import struct
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final

from e2e.measure.errors import NotRunError

SERVER_ADDRESS: Final = "10.77.0.1"
BROWSER_ADDRESS: Final = "10.77.0.2"
DEVICE: Final = "wax0"

_CLONE_NEWUSER: Final = 0x10000000
_CLONE_NEWNET: Final = 0x40000000
_USUAL_FOLDERS: Final = "/usr/sbin:/sbin:/usr/bin:/bin"
"""The folders of ``ip``, for users whose PATH lacks them."""

_TUN: Final = "/dev/net/tun"
_TUNSETIFF: Final = 0x400454CA  # linux/if_tun.h, with x86's and ARM's numbers
_IFF_TUN: Final = 0x0001
_IFF_NO_PI: Final = 0x1000


def tool(name: str, package: str) -> str:
    """Return the path of a system command; raises `NotRunError`, which says what to install."""
    if not sys.platform.startswith("linux"):
        raise NotRunError("the link needs network namespaces, which only Linux has")
    path = shutil.which(name, path=f"{os.environ.get('PATH', '')}:{_USUAL_FOLDERS}")
    if path is None:
        raise NotRunError(f"there is no command {name}; install the package {package}")
    return path


def enter_new_network() -> int:
    """Move this process, which must have one thread, into a new network namespace.

    Return the namespace's descriptor. Raises `NotRunError` where that is not allowed.
    """
    uid, gid = os.getuid(), os.getgid()
    if not _unshare(_CLONE_NEWNET):
        if not _unshare(_CLONE_NEWUSER | _CLONE_NEWNET):
            raise NotRunError(
                "no network namespace can be made here; run as root, allow unprivileged user "
                "namespaces, or give the container the capability SYS_ADMIN"
            )
        _be_root_inside(uid, gid)
    return os.open("/proc/self/ns/net", os.O_RDONLY | os.O_CLOEXEC)


def configure(device: str, address: str) -> None:
    """Bring up `lo` and `device` with `address` (such as ``10.0.0.1/24``) in this namespace.

    `device` is the default route, because a browser offers only an address that has one. Raises
    `NotRunError`.
    """
    ip(["link set lo up"])
    # No IPv6 address, so that only the programs send packets; fails harmlessly where IPv6 is off.
    with suppress(NotRunError):
        ip([f"link set {device} addrgenmode none"])
    ip(
        [
            f"address add {address} dev {device}",
            f"link set {device} txqueuelen 5000 up",
            f"route add default dev {device}",
        ]
    )


def ip(lines: list[str]) -> None:
    """Run lines of ``ip`` in this namespace; raises `NotRunError`."""
    run("ip", "iproute2", ["-batch", "-"], "\n".join(lines))


def run(name: str, package: str, arguments: list[str], text: str) -> None:
    """Run a command in this namespace with `text` as its input; raises `NotRunError`."""
    command = [tool(name, package), *arguments]
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise NotRunError(
            f"the network namespace cannot be set up: {name} said {done.stderr.strip()!r} to "
            f"{text!r}; run as root or give the container NET_ADMIN"
        )


def open_tun(name: str) -> int:
    """Make the device `name` in this process's network namespace; return its descriptor.

    Reads yield IP packets and do not block; the device disappears when the descriptor is closed.
    Raises `NotRunError`.
    """
    try:
        descriptor = os.open(_TUN, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
        request = struct.pack("16sH22x", name.encode("ascii"), _IFF_TUN | _IFF_NO_PI)
        fcntl.ioctl(descriptor, _TUNSETIFF, request)
    except OSError as error:
        raise NotRunError(
            f"no TUN device can be made by {_TUN} ({error.strerror}); load the kernel module tun, "
            "and run as root, or give the container that device and the capability NET_ADMIN"
        ) from error
    return descriptor


def _unshare(flags: int) -> bool:
    return bool(ctypes.CDLL(None).unshare(flags) == 0)  # Python 3.12 and newer have os.unshare


def _be_root_inside(uid: int, gid: int) -> None:
    try:
        Path("/proc/self/setgroups").write_text("deny", encoding="ascii")
        Path("/proc/self/uid_map").write_text(f"0 {uid} 1", encoding="ascii")
        Path("/proc/self/gid_map").write_text(f"0 {gid} 1", encoding="ascii")
    except OSError as error:
        raise NotRunError(
            "unprivileged user namespaces have no rights here; run as root, or allow them "
            "(on Ubuntu the setting kernel.apparmor_restrict_unprivileged_userns)"
        ) from error
