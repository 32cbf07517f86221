"""`wax hook test`: each hook's answer, and the exit status."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest
from tests.hooks.receiver import receiving, secret_file
from tests.turned_clock import TurnedClock

from wax.__main__ import main
from wax.commands.doctor.command import _hook as examine
from wax.commands.hook.command import hook_test
from wax.config import settings as config
from wax.errors import ConfigError, StartError

if TYPE_CHECKING:
    from pathlib import Path


def settings(folder: Path, *urls: str, **keys: Any) -> config.Settings:
    hooks = [{"url": url, "secret_file": secret_file(folder), **keys} for url in urls]
    return config.parse({"hook": hooks}, "robot.toml")


async def test_each_gets_a_sample_and_is_told_of(tmp_path: Path) -> None:
    """Each hook gets a sample, and its answer is printed escaped; a failure makes the status 1."""
    said: list[str] = []
    async with receiving() as receiver:
        receiver.status, receiver.text = 200, "thanks\x1b[31m " + "x" * 5000
        one = settings(tmp_path, receiver.url, events=["tape.kept"])
        assert await hook_test(one, TurnedClock(), said.append) == 0
        both = settings(tmp_path, receiver.url, "http://127.0.0.1:9/")
        assert await hook_test(both, TurnedClock(), said.append) == 1
    name = f"1 (127.0.0.1:{receiver.port})"
    assert said[0].startswith(f"hook {name}: taken within ")
    assert r" ms, with status 200, and says: thanks\x1b[31m xxx" in said[0]
    assert len(said[0]) < 300
    assert said[2].startswith("hook 2 (127.0.0.1:9): not taken. Nobody listens at 127.0.0.1:9 ")
    body = json.loads(receiver.asked[0][2])
    assert (body["type"], body["timestamp"]) == ("hook.test", "1970-01-01T00:00:00.000+00:00")


async def test_there_must_be_a_hook() -> None:
    """Without a hook, `wax hook test` is wrong use."""
    with pytest.raises(ConfigError, match=r"no \[\[hook\]\] to test"):
        await hook_test(config.load(None), TurnedClock(), print)


def test_wrong_use_is_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Wrong use and an unreadable secret are sentences on standard error, each with its status."""
    assert main(["hook", "test"]) == 2
    path = tmp_path / "robot.toml"
    path.write_text('[[hook]]\nurl = "https://example.org/h"\nsecret_file = "/nowhere"\n')
    assert main(["hook", "--config", str(path), "test"]) == 1
    shown = capsys.readouterr().err
    assert "no [[hook]]" in shown
    assert "hook[0].secret_file: /nowhere cannot be read" in shown


def test_the_doctor_looks_at_each(tmp_path: Path) -> None:
    """`wax doctor` checks each hook's secret without posting."""
    [one] = settings(tmp_path, "https://example.org/h").hook
    assert examine(1, one).level == "ok"
    gone = one.model_copy(update={"secret_file": str(tmp_path / "gone")})
    with pytest.raises(StartError, match=r"hook\[0\]\.secret_file"):
        examine(1, gone)
