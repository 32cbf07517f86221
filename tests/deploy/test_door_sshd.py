"""What `door.sh` says about the sshd that it finds; the real sshd says what it does with robots."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Final

import pytest

SCRIPT: Final = (Path(__file__).parents[2] / "config/deploy/door.sh").read_text(encoding="utf-8")
SSHD: Final = "/usr/sbin/sshd"
DEBIANS: Final = "KbdInteractiveAuthentication no\nUsePAM yes\nX11Forwarding yes\nPrintMotd no\n"
HARDENED: Final = [
    "AllowUsers admin",
    "AllowGroups ssh-users",
    "AuthenticationMethods publickey,password",
    "AllowTcpForwarding local",
    "AllowTcpForwarding no",
    "AuthorizedKeysFile /etc/ssh/keys/%u",
    "DisableForwarding yes",
    "PermitListen none",
    "PubkeyAcceptedAlgorithms rsa-sha2-512",
    "PubkeyAuthentication no",
]

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(sys.platform != "linux", reason="a door is a Debian"),
    pytest.mark.skipif(not Path(SSHD).exists(), reason="there is no sshd"),
]


class Machine:
    """A machine on which the script has written its rules, with keys and folders of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        if os.geteuid() == 0:
            Path("/run/sshd").mkdir(exist_ok=True)  # as Debian's unit does
        self.key = folder / "ssh_host_ed25519_key"
        keygen = shutil.which("ssh-keygen") or "/usr/bin/ssh-keygen"
        for key in (self.key, folder / "other"):
            subprocess.run([keygen, "-q", "-t", "ed25519", "-N", "", "-f", key], check=True)
        self.rules = folder / "sshd_config.d" / "wax-door.conf"
        self.rules.parent.mkdir()
        found = re.search(r"write \$RULES <<'END'\n(.*?)END\n", SCRIPT, re.DOTALL)
        assert found is not None
        self.rules.write_text(found[1], encoding="ascii")

    def says(
        self, lines: str = "", *, include: bool = True, host_key: str = "ssh_host_ed25519_key"
    ) -> str:
        """Return sshd's rules for robots, configured with these lines before the script's."""
        config = self._folder / "sshd_config"
        reads = f"Include {self.rules.parent}/*.conf" if include else ""
        key = f"HostKey {self._folder / host_key}"
        config.write_text(f"{key}\n{DEBIANS}{lines}\n{reads}\n", encoding="ascii")
        user = "user=wax-door,host=robot.invalid,addr=192.0.2.1"
        asked = [SSHD, "-T", "-f", str(config), "-C", user]
        return subprocess.run(asked, check=True, capture_output=True, text=True).stdout

    def objections(self, said: str) -> list[str]:
        function = re.search(r"^objections\(\) \{.*?^\}\n", SCRIPT, re.DOTALL | re.MULTILINE)
        assert function is not None
        places = f"HOME_DIR=/etc/wax-door RULES={self.rules} HOST_KEY={self.key}\n"
        command = ["sh", "-euc", f"{places}{function[0]}objections"]
        told = subprocess.run(command, input=said, check=True, capture_output=True, text=True)
        assert not told.stderr
        return told.stdout.splitlines()


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    return Machine(tmp_path_factory.mktemp("door"))


@pytest.mark.parametrize("line", ["", *HARDENED])
def test_a_hardened_sshd_lets_robots_in(machine: Machine, line: str) -> None:
    """Lines that guides recommend for everybody do not affect the tunnel's own user."""
    said = machine.says(line)
    assert f"\n{line.lower()}\n" not in said
    assert machine.objections(said) == []


@pytest.mark.parametrize("line", [one for one in HARDENED if not re.match("Allow(Us|Gr)", one)])
def test_what_another_match_block_says_first_is_named(machine: Machine, line: str) -> None:
    """If two blocks match that user, sshd follows the first, except that names are added up."""
    [told] = machine.objections(machine.says(f"Match all\n\t{line}\nMatch all"))
    assert f"grep -rin {line.split(maxsplit=1)[0]} /etc/ssh" in told


@pytest.mark.parametrize("line", ["DenyUsers root wax-*@203.0.113.0/24", "DenyGroups *"])
def test_a_denial_that_means_the_doors_user_is_named(machine: Machine, line: str) -> None:
    """A denial stays in force, since the script cannot undo it."""
    [told] = machine.objections(machine.says(line))
    assert line.rsplit(maxsplit=1)[-1] in told
    assert f"grep -rin {line.lower().split(maxsplit=1)[0]} /etc/ssh" in told


@pytest.mark.parametrize("lines", ["AllowUsers admin\nDisableForwarding yes", "Match User admin"])
def test_an_sshd_that_does_not_read_the_doors_rules_is_named(machine: Machine, lines: str) -> None:
    """There is one sentence, whatever the cause: no Include, or one inside another block."""
    [told] = machine.objections(machine.says(lines, include="Match" in lines))
    assert "Include /etc/ssh/sshd_config.d/*.conf" in told


def test_an_sshd_that_does_not_show_the_key_that_robots_know_is_named(machine: Machine) -> None:
    """Robots recognise the far end only by its Ed25519 key."""
    [told] = machine.objections(machine.says("HostKeyAlgorithms rsa-sha2-512,rsa-sha2-256"))
    assert "HostKeyAlgorithms" in told
    [told] = machine.objections(machine.says(host_key="other"))
    assert f"HostKey {machine.key}" in told
