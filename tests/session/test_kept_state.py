"""What outlives the server, in a series of real rooms."""

from __future__ import annotations

import errno
import os
from typing import TYPE_CHECKING, Any

import pytest
from structlog.testing import capture_logs
from tests.session.rig import Rig, switching
from tests.until import until

from wax import state_dir
from wax.control.stop_latch import LatchedStop
from wax.protocol import messages
from wax.protocol.host_switches import AT_HOME, SWITCHES, HostSwitches
from wax.session import kept_state
from wax.session.kept_state import FILE, KeptFile, KeptState
from wax.session.stop_budget import BEFORE, HOST, HOUSE

if TYPE_CHECKING:
    from pathlib import Path

    from wax.protocol.events import StopRole
    from wax.protocol.host_switches import HostSwitch, SwitchAtHome
    from wax.sentence import Sentence


def started(folder: Path, **tables: Any) -> Rig:
    rig = Rig({"server": {"state_dir": str(folder)}, **tables})
    rig.kept.start()
    rig.room.resume()
    return rig


@pytest.mark.parametrize(
    ("who", "by", "role"),
    [
        ({"house"}, HOUSE, "house"),
        ({"guest"}, BEFORE, "observer"),
        ({"guest", "host"}, HOST, "host"),
    ],
)
async def test_a_stop_is_in_force_after_a_restart(
    tmp_path: Path, who: set[str], by: Sentence, role: StopRole
) -> None:
    """It outlives every restart, can be released as before, and programs are told."""
    rig = started(tmp_path)
    assert rig.loop.latched is None
    if "house" in who:
        rig.room.house_acts(messages.Stop(type="stop"))
    if "guest" in who:
        (await rig.enter("bob-1111")).says(type="stop")
    if "host" in who:
        (await rig.enter("hedy-111", is_host=True)).says(type="stop")
    for _ in range(2):
        until(rig.kept.close)
        rig = started(tmp_path)
        assert rig.robot.told[-1] == "stop"
        assert rig.loop.latched == LatchedStop(1, by, by_host=role == "host")
        told = {"type": "stop.pressed", "stop": 1, "role": role, "name": None}
        assert rig.heard.take() == [told]
    host = await rig.enter("hedy-111", is_host=True)
    host.says(type="release", stop=1, sent_server_ms=rig.clock.time_s * 1000, beat=host.beat)
    until(rig.kept.close)
    after = started(tmp_path)
    until(after.kept.close)
    assert after.loop.latched is None


@pytest.mark.parametrize("switch", SWITCHES.values(), ids=lambda one: one.kept)
async def test_what_the_host_has_switched_outlives_a_restart(
    tmp_path: Path, switch: HostSwitch
) -> None:
    """Nobody may be there to do it again."""
    rig = started(tmp_path)
    (await rig.enter("hedy-111", is_host=True)).says(**switching(switch))
    until(rig.kept.close)
    after = started(tmp_path)
    until(after.kept.close)
    assert after.decisions.switches == rig.decisions.switches != HostSwitches()


async def test_a_held_queue_waits_after_a_restart(tmp_path: Path) -> None:
    """No turn begins until the host resumes it."""
    rig = started(tmp_path)
    (await rig.enter("hedy-111", is_host=True)).says(type="hold_queue", held=True)
    until(rig.kept.close)
    after = started(tmp_path)
    until(after.kept.close)
    bob = await after.enter("bob-1111")
    bob.says(type="join")
    after.wait(0.3, bob)
    assert bob.last("room")["turn"]["operator"] is None


@pytest.mark.parametrize("switch", AT_HOME.values(), ids=lambda one: one.topic)
async def test_an_act_of_home_automation_outlives_a_restart(
    tmp_path: Path, switch: SwitchAtHome
) -> None:
    """It is kept as the host's acts are."""
    rig = started(tmp_path)
    rig.room.house_acts(switch.act(switch.topic != "open"))
    until(rig.kept.close)
    assert KeptFile(str(tmp_path)).before.switches == rig.decisions.switches != HostSwitches()


def test_the_file_of_an_older_version_is_read(tmp_path: Path) -> None:
    """Its names stay as they are."""
    (tmp_path / FILE).write_text(
        '{"stop":"operator","is_held":true,"is_blanked":true,"are_voices_muted":true,'
        '"max_fraction":0.25,"is_locked":true,"is_closed":true,"closed_until_s":5.0}   '
    )
    assert KeptFile(str(tmp_path)).before.model_dump() == {
        "stop": "operator",
        "is_held": True,
        "is_blanked": True,
        "are_voices_muted": True,
        "max_fraction": 0.25,
        "is_locked": True,
        "is_closed": True,
        "closed_until_s": 5.0,
        "camera_delay_ms": None,
    }


async def test_closed_for_the_day_it_opens_when_it_would_have(tmp_path: Path) -> None:
    """The opening hours count as before the restart."""
    hours = {"hours": ["mon-sun 10:00-11:00"]}
    rig = started(tmp_path, access=hours)
    (await rig.enter("hedy-111", is_host=True)).says(type="close", closed=True)
    opens_s = rig.decisions.switches.closed_until_s
    until(rig.kept.close)
    after = started(tmp_path, access=hours)
    until(after.kept.close)
    assert after.decisions.switches.closed_until_s == opens_s is not None


def kept(folder: Path) -> KeptFile:
    file = KeptFile(str(folder))
    file.start()
    return file


def test_it_is_written_at_once(tmp_path: Path) -> None:
    """A server that is killed gets no chance to write."""
    file = kept(tmp_path / "new")
    file.save(KeptState(stop="host"))
    until(lambda: KeptFile(str(tmp_path / "new")).before.stop == "host")
    until(file.close)


@pytest.mark.parametrize("content", [b"", b"{", b'{"stop": "somebody"}', b'{"max_fraction": 9}'])
def test_an_unreadable_file_counts_as_a_stop(tmp_path: Path, content: bytes) -> None:
    """It is the host's Stop, and nobody sees anything, until the next act overwrites the file."""
    (tmp_path / FILE).write_bytes(content)
    with capture_logs() as logs:
        file = kept(tmp_path)
    assert [line["log_level"] for line in logs] == ["warning"]
    doubt = KeptState(stop="host", is_blanked=True, are_voices_muted=True)
    assert file.before == doubt
    assert [one.code for one in file.problems()] == ["kept.unread"]
    until(lambda: not KeptFile(str(tmp_path)).problems())
    assert KeptFile(str(tmp_path)).before == doubt
    file.save(KeptState())
    until(file.close)
    assert KeptFile(str(tmp_path)).before == KeptState()


def test_a_failed_write_is_reported_and_retried(tmp_path: Path) -> None:
    """It is reported once; a folder that cannot be made held nothing."""
    (tmp_path / "file").write_text("")
    with capture_logs() as logs:
        file = kept(tmp_path / "file" / "wax")
        assert file.before == KeptState()
        file.save(KeptState(stop="observer"))
        until(lambda: [one.code for one in file.problems()] == ["kept.unwritten"])
        file.save(KeptState(stop="host"))
        (tmp_path / "file").unlink()
        until(file.close)
    assert ([line["log_level"] for line in logs], file.problems()) == (["warning"], [])
    assert KeptFile(str(tmp_path / "file" / "wax")).before.stop == "host"


def test_a_write_that_may_have_happened_is_undone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a write that failed at its very end, the old state is written again."""
    file = kept(tmp_path)
    sync = state_dir.sync
    monkeypatch.setattr(state_dir, "sync", lambda path: sync(path) if path.is_file() else _fail())
    file.save(KeptState(stop="host"))
    until(file.problems)
    monkeypatch.undo()
    file.save(KeptState())
    until(file.close)
    assert KeptFile(str(tmp_path)).before == KeptState()


def _fail(*_: object) -> None:
    raise OSError(5, "Input/output error")


def test_a_write_is_retried_until_it_succeeds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No act is needed for that; the host is told from the start until it succeeds."""
    monkeypatch.setattr(kept_state, "_AGAIN_S", 0.01)
    (tmp_path / "folder").touch()
    file = kept(tmp_path / "folder")
    assert file.problems()
    file.save(KeptState(stop="host"))
    (tmp_path / "folder").unlink()
    until(lambda: not file.problems())
    second = kept(tmp_path / "folder")
    assert second.problems()
    until(second.close)
    until(file.close)
    assert KeptFile(str(tmp_path / "folder")).before.stop == "host"


def test_a_full_disk_has_room_for_a_stop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Even the largest state fits, though no new file can be made and the old one cannot grow."""
    file = kept(tmp_path)
    until((tmp_path / FILE).exists)
    room_bytes = (tmp_path / FILE).stat().st_size
    opened = os.open

    def full(path: Path, flags: int, *mode: int) -> int:
        if flags & os.O_CREAT:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return opened(path, flags, *mode)

    monkeypatch.setattr(os, "open", full)
    largest = KeptState(
        **{name: True for name in KeptState.model_fields if name.startswith(("is_", "are_"))},
        stop="observer",
        max_fraction=1 / 3,
        closed_until_s=-1e300 / 3,
        camera_delay_ms=1000 / 3,
    )
    file.save(largest)
    until(file.close)
    monkeypatch.undo()
    assert (KeptFile(str(tmp_path)).before, file.problems()) == (largest, [])
    assert (tmp_path / FILE).stat().st_size == room_bytes


def test_the_host_is_told_from_the_start_that_a_stop_has_no_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The disk was full before there was a file."""
    monkeypatch.setattr(state_dir, "replace", _fail)
    file = kept(tmp_path)
    until(lambda: [one.code for one in file.problems()] == ["kept.unwritten"])
    until(file.close)


def test_an_unread_file_is_not_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For example in a folder that is mounted late: its Stop is in force after the next start."""
    monkeypatch.setattr(kept_state, "_AGAIN_S", 0.01)
    late = tmp_path / "late"
    late.mkdir()
    (late / FILE).write_text(KeptState(stop="host").model_dump_json())
    (tmp_path / "folder").touch()
    file = kept(tmp_path / "folder")
    why = file.problems()
    (tmp_path / "link").symlink_to(late)
    (tmp_path / "link").replace(tmp_path / "folder")  # atomically: the thread retries all the time
    until(lambda: file.problems() != why)
    file.save(KeptState(is_held=True))
    until(file.close)
    assert KeptFile(str(tmp_path / "folder")).before.stop == "host"


def test_two_servers_do_not_undo_each_others_stop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one folder the later one is told so, and writes nothing, not even once it is alone."""
    monkeypatch.setattr(kept_state, "_AGAIN_S", 0.01)
    first = kept(tmp_path)
    first.save(KeptState(stop="host"))
    until(lambda: KeptFile(str(tmp_path)).before.stop == "host")
    second = kept(tmp_path)
    assert second.problems()
    until(first.close)
    second.save(KeptState(is_held=True))
    until(second.close)
    assert KeptFile(str(tmp_path)).before.stop == "host"
    third = kept(tmp_path)
    assert third.problems() == []
    until(third.close)
