"""The tunnel's ssh command, and what ssh's messages mean."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.door.door_lines import door_line

from wax.config.door import DoorSettings
from wax.door import line, ssh
from wax.door.tunnel import start

DOOR = DoorSettings(
    host="robot.example.org",
    port=20001,
    host_key=line.read(door_line()).host_key,
    key_file="/etc/wax/robot.door-key",
)


@pytest.mark.parametrize(
    ("said", "code"),
    [
        ("ssh: Could not resolve hostname robot.example.org: Name or service not known", "name"),
        ("ssh: connect to host robot.example.org port 22: Connection refused", "closed"),
        ("ssh: connect to host robot.example.org port 22: Connection timed out", "closed"),
        (
            "TCP 443: timed out\nkex_exchange_identification: Connection closed by remote host",
            "closed",
        ),
        ("no upgrade: HTTP/1.1 404 Not Found\nConnection closed by UNKNOWN port 65535", "no_https"),
        (
            "@ WARNING: REMOTE HOST IDENTIFICATION HAS CHANGED! @\nHost key verification failed.",
            "host_key",
        ),
        (
            "No ED25519 host key is known for wax-door and you have requested strict checking.",
            "host_key",
        ),
        (
            "Unable to negotiate with 203.0.113.9 port 22: no matching host key type found.",
            "host_key",
        ),
        (
            "no such identity: /x: No such file\nwax-door@h: Permission denied (publickey).",
            "key_file",
        ),
        ("wax-door@robot.example.org: Permission denied (publickey).", "key"),
        ("Error: remote port forwarding failed for listen port 20001", "taken"),
        ("Timeout, server robot.example.org not responding.", "stalled"),
        ("kex_exchange_identification: Connection closed by remote host", "ended"),
        ("Connection to robot.example.org closed by remote host.", "ended"),
        ("No user exists for uid 61234", "no_user"),
        ("ssh: what nobody knows yet", "failed"),
        ("", "failed"),
    ],
)
def test_each_failure_has_its_sentence(said: str, code: str) -> None:
    """The sentence names door.sh where the door may be at fault; debug lines do not count."""
    lines = ["debug1: Permission denied (gssapi)", *said.splitlines()]
    problem = ssh.problem(DOOR, lines)
    assert problem.code == f"tunnel.{code}"
    assert "…" not in str(problem)
    assert ("door.sh" in str(problem)) is (code in {"host_key", "key", "taken"})


@pytest.mark.system
@pytest.mark.skipif(shutil.which("ssh") is None, reason="there is no ssh")
def test_the_command_is_one_that_ssh_takes(tmp_path: Path) -> None:
    """The options are all valid, and override the user's own settings and agent."""
    folder = tmp_path / "a folder, 50%"
    folder.mkdir()
    (folder / "hosts").write_text(ssh.known_hosts(DOOR), encoding="ascii")
    words = ssh.command(DOOR, "https", folder / "hosts", "127.0.0.1:8080", "proxy me")
    dumped = subprocess.run(
        [words[0], "-G", *words[1:]], capture_output=True, text=True, check=True
    ).stdout
    said = dict(one.partition(" ")[::2] for one in dumped.splitlines())
    assert said["batchmode"] == said["exitonforwardfailure"] == said["identitiesonly"] == "yes"
    assert said["stricthostkeychecking"] == "true"
    assert said["identityagent"] == "none"
    assert said["userknownhostsfile"].strip('"') == str(folder / "hosts")
    assert said["remoteforward"] == "[127.0.0.1]:20001 [127.0.0.1]:8080"
    assert said["proxycommand"] == "proxy me"
    assert said["user"] == "wax-door"
    assert said["identityfile"].strip('"') == DOOR.key_file
    assert words[1:3] == ["-F", "none"]


@pytest.mark.system
def test_ssh_speaks_english(monkeypatch: pytest.MonkeyPatch) -> None:
    """The messages are English whatever the language of the machine."""
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    with start(["sh", "-c", "echo $LC_ALL >&2"]) as child:
        assert child.stderr is not None
        assert child.stderr.read() == b"C\n"


@pytest.mark.system
@pytest.mark.skipif(shutil.which("setpriv") is None, reason="util-linux is Linux's")
def test_ssh_ends_with_a_server_that_is_killed() -> None:
    """If the server is killed, its ssh ends too, and with it the tunnel."""
    program = (
        "import os, pathlib, signal\n"
        "from wax.door.tunnel import start\n"
        "pid = start(['sleep', '600']).pid\n"
        "print(pid, flush=True)\n"
        "while pathlib.Path(f'/proc/{pid}/comm').read_text() != 'sleep\\n': pass\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    said = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    child = Path(f"/proc/{int(said.stdout)}/stat")
    until_s = time.monotonic() + 10
    while child.exists() and child.read_text(encoding="ascii").split()[2] != "Z":
        assert time.monotonic() < until_s, "it goes on"
        time.sleep(0.02)
