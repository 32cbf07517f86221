"""All webhooks together: one that fails affects no other."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, Any

import pytest
import structlog
from tests.hooks.receiver import Receiver, receiving, secret_file
from tests.tls_server import pair, server_context, serving
from tests.turned_clock import TurnedClock

from wax.config.hook import HookSettings
from wax.errors import StartError
from wax.hooks.hooks import Hook, Hooks
from wax.hooks.outbox import KEPT_S
from wax.hooks.post import session
from wax.protocol.events import FaultEvent, Removed, StopEvent, TapeKept

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from wax.protocol.events import Event

BANNED = Removed(type="viewer.banned", viewer=2, name="Eve")
KEPT = TapeKept(by="host")
FAULT = FaultEvent(type="fault.began", part="robot", which=None, why="gone")
STOP = StopEvent(type="stop.pressed", stop=1, role="host", name=None)


class Rig:
    """One hook with a clock and a receiver."""

    def __init__(self, receiver: Receiver, folder: Path) -> None:
        self.receiver = receiver
        self.folder = folder
        self.clock = TurnedClock()

    def settings(self, **keys: Any) -> HookSettings:
        known = {"url": self.receiver.url, "secret_file": secret_file(self.folder)}
        return HookSettings.model_validate(known | keys)

    def hook(self, **keys: Any) -> Hook:
        return Hook(1, self.settings(**keys), self.clock)

    def bodies(self) -> list[dict[str, Any]]:
        return [json.loads(body) for *_, body in self.receiver.asked]

    async def step(self, hook: Hook, times: int = 1) -> None:
        async with session(lambda: 0) as http:
            for _ in range(times):
                await hook.step(http)


@pytest.fixture
async def rig(tmp_path: Path) -> AsyncIterator[Rig]:
    async with receiving() as receiver:
        yield Rig(receiver, tmp_path)


async def test_only_what_a_hook_asks_for_is_posted(rig: Rig) -> None:
    """A hook posts the types it names, or all if it names none; in order, each once."""
    some, everything = rig.hook(events=["tape.kept"]), rig.hook()
    for event in (BANNED, KEPT):
        some.put(event)
        everything.put(event)
    await rig.step(some, 3)
    assert [one["type"] for one in rig.bodies()] == ["tape.kept"]
    rig.receiver.asked.clear()
    await rig.step(everything, 3)
    assert [one["type"] for one in rig.bodies()] == ["viewer.banned", "tape.kept"]
    assert (everything.news.taken, len(everything.news)) == (2, 0)


@pytest.mark.parametrize(("keys", "name"), [({}, None), ({"names": True}, "Eve")])
async def test_names_are_told_only_where_configured(
    rig: Rig, keys: dict[str, bool], name: str | None
) -> None:
    """An event names a person only if the hook's `names` is true, and says nothing else of them."""
    hook = rig.hook(**keys)
    hook.put(BANNED)
    await rig.step(hook)
    [body] = rig.bodies()
    assert body == {
        "version": 1,
        "timestamp": "",
        "name": name,
        "type": "viewer.banned",
        "viewer": 2,
    }


async def test_what_failed_is_tried_again_as_the_same(rig: Rig) -> None:
    """A retry waits until it is due and has the same id and body; no event overtakes it."""
    hook = rig.hook()
    hook.put(BANNED)
    hook.put(KEPT)
    rig.receiver.status = 500
    with structlog.testing.capture_logs() as logs:
        await rig.step(hook, 5)
    assert len(rig.receiver.asked) == 1
    assert [(line["event"], line["hook"], line["what"], line["why"]) for line in logs] == [
        (
            "a hook did not take an event",
            f"1 (127.0.0.1:{rig.receiver.port})",
            "viewer.banned",
            "It answers with status 500.",
        )
    ]
    assert "secret-path" not in str(logs)
    rig.receiver.status = 200
    rig.clock.time_s += 1.0
    await rig.step(hook, 2)
    first, again, last = rig.receiver.asked
    assert first[1]["webhook-id"] == again[1]["webhook-id"] != last[1]["webhook-id"]
    assert first[2] == again[2]
    assert [one["type"] for one in rig.bodies()][1:] == ["viewer.banned", "tape.kept"]


async def test_ten_minutes_of_nothing_lose_the_event(rig: Rig) -> None:
    """An event is lost after fifteen attempts and one log line; the host sees both states."""
    hooks = Hooks([rig.settings()], rig.clock, lambda: 0)
    [hook] = hooks._hooks
    hooks.put(KEPT)
    rig.receiver.status = 503
    with structlog.testing.capture_logs() as logs:
        async with session(lambda: 0) as http:
            await hook.step(http)
            assert [str(one) for one in hooks.problems()] == [
                f"An event waits for hook {hook.name}. It answers with status 503."
            ]
            while len(hook.news):
                rig.clock.time_s += 1.0
                await hook.step(http)
    assert (len(logs), len(rig.receiver.asked)) == (1, 15)
    assert rig.clock.time_s == pytest.approx(1000.0 + KEPT_S, abs=2)
    assert str(hooks.problems()[0]) == f"An event for hook {hook.name} was lost."
    assert hooks.status() == [
        {
            "name": hook.name,
            "problem": "It answers with status 503.",
            "disabled": False,
            "waiting": 0,
            "taken": 0,
            "refused": 0,
            "lost": 1,
        }
    ]


@pytest.mark.parametrize("status", [400, 404, 422])
async def test_what_is_refused_holds_nothing_up(rig: Rig, status: int) -> None:
    """A refused event is not sent again, is logged once for its type, and delays no other event."""
    hook = rig.hook()
    for event in (KEPT, KEPT, BANNED):
        hook.put(event)
    rig.receiver.status = status
    with structlog.testing.capture_logs() as logs:
        await rig.step(hook, 2)
        rig.receiver.status = 204
        await rig.step(hook, 2)
    assert [one["type"] for one in rig.bodies()] == ["tape.kept", "tape.kept", "viewer.banned"]
    assert (hook.refused, hook.waiting, hook.lost, len(logs)) == (2, 0, 0, 1)
    [told] = hook.problems()
    assert str(told).startswith(f"Hook {hook.name} refused 2 events for good")


@pytest.mark.parametrize("status", [408, 425, 429, 500, 503])
async def test_a_refusal_of_now_is_tried_again(rig: Rig, status: int) -> None:
    """After a temporary refusal the event stays queued."""
    hook = rig.hook()
    hook.put(KEPT)
    rig.receiver.status = status
    await rig.step(hook)
    assert (hook.refused, hook.waiting) == (0, 1)


async def test_a_receiver_that_is_gone_is_asked_no_more(rig: Rig) -> None:
    """After a 410, queued and new events are lost, and the host reads that the hook is off."""
    hook = rig.hook()
    hook.put(KEPT)
    hook.put(BANNED)
    rig.receiver.status = 410
    await rig.step(hook)
    hook.put(STOP)
    rig.receiver.status = 204
    await rig.step(hook, 3)
    assert len(rig.receiver.asked) == 1
    assert (hook.status()["disabled"], hook.waiting, hook.lost) == (True, 0, 3)
    [told] = hook.problems()
    assert "is off until the server is started again" in str(told)


async def test_what_both_ways_wait_for_is_told_once(rig: Rig) -> None:
    """A failure of both queues is one problem for the host, with their total, and one log line."""
    hook = rig.hook()
    hook.put(KEPT)
    hook.put(STOP)
    rig.receiver.status = 503
    with structlog.testing.capture_logs() as logs:
        await rig.step(hook)
    assert len(rig.receiver.asked) == 2
    [told] = hook.problems()
    assert str(told).startswith(f"2 events wait for hook {hook.name}.")
    assert [line["event"] for line in logs] == ["a hook did not take an event"]


@pytest.mark.parametrize("event", [STOP, FAULT])
async def test_what_is_urgent_does_not_wait_until_news_are_due(rig: Rig, event: Event) -> None:
    """An urgent event does not wait for the Retry-After that a news event received."""
    hook = rig.hook()
    hook.put(KEPT)
    rig.receiver.status, rig.receiver.retry_after = 503, "300"
    await rig.step(hook)
    hook.put(event)
    await rig.step(hook)
    assert [one["type"] for one in rig.bodies()] == ["tape.kept", event.type]


async def test_a_stop_does_not_wait_for_news(rig: Rig) -> None:
    """A Stop is posted while an attempt to post a news event still hangs."""
    hook = rig.hook()
    hook.put(KEPT)
    rig.receiver.does = "hangs"
    async with session(lambda: 0) as http:
        posting = asyncio.create_task(hook.run(http))
        await asyncio.wait_for(rig.receiver.arrived.get(), 5)
        rig.receiver.does = "answers"
        hook.put(STOP)
        await asyncio.wait_for(rig.receiver.arrived.get(), 5)
        posting.cancel()
    assert [one["type"] for one in rig.bodies()] == ["tape.kept", "stop.pressed"]


async def test_retry_after_is_waited_for(rig: Rig) -> None:
    """A retry waits for as long as Retry-After asks, and no second less."""
    hook = rig.hook()
    hook.put(KEPT)
    rig.receiver.status, rig.receiver.retry_after = 429, "30"
    await rig.step(hook)
    rig.clock.time_s += 29.0
    await rig.step(hook)
    assert len(rig.receiver.asked) == 1
    rig.clock.time_s += 1.0
    await rig.step(hook)
    assert len(rig.receiver.asked) == 2


async def test_a_bug_here_is_a_failed_attempt(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """An attempt that raises anything counts as failed, and nothing propagates."""
    hook = rig.hook()
    hook.put(KEPT)

    async def fail(*_: object, **__: object) -> tuple[int, bytes]:
        raise RuntimeError("bug")

    monkeypatch.setattr(hook, "post", fail)
    await rig.step(hook, 3)
    assert len(hook.news) == 1
    assert str(hook.news.problem) == "RuntimeError('bug')"


async def test_an_event_that_cannot_be_written_reaches_nobody(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`put` raises nothing into the control loop that calls it, and logs once."""
    hooks = Hooks([rig.settings()], rig.clock, lambda: 0)

    def fail(_: Event) -> None:
        raise RuntimeError("bug")

    monkeypatch.setattr(hooks._hooks[0], "put", fail)
    with structlog.testing.capture_logs() as logs:
        hooks.put(KEPT)
        hooks.put(KEPT)
    assert [line["event"] for line in logs] == ["events are lost"]


async def test_the_last_events_are_posted_at_the_end(rig: Rig) -> None:
    """`close` ignores Retry-After, and attempts each event once at most."""
    hooks = Hooks([rig.settings()], rig.clock, lambda: 0)
    rig.receiver.status, rig.receiver.retry_after = 503, "300"
    for event in (BANNED, KEPT):
        hooks.put(event)
    await hooks.close()
    assert len(rig.receiver.asked) == 1
    rig.receiver.status = 200
    await hooks.close()
    assert [one["type"] for one in rig.bodies()][1:] == ["viewer.banned", "tape.kept"]
    await hooks.close()
    assert len(rig.receiver.asked) == 3


async def test_an_authority_of_ones_own_is_read_at_the_start(rig: Rig) -> None:
    """A `ca_file` without a certificate is a `StartError` that names the key."""
    keys = {"url": "https://127.0.0.1/h", "ca_file": str(rig.folder / "gone")}
    with pytest.raises(StartError, match=r"^hook\[0\]\.ca_file: .*holds no certificate"):
        rig.hook(**keys)


@pytest.mark.parametrize(
    ("authority", "code"),
    [("own", None), ("other", "unreachable.other_authority"), ("", "unreachable.own_authority")],
)
async def test_a_receiver_by_tls_is_trusted_by_its_authority(
    rig: Rig, authority: str, code: str | None
) -> None:
    """Only `ca_file` is trusted; otherwise the host is told whether to set it or replace it."""
    own = pair(rig.folder)
    (other := rig.folder / "other").mkdir()
    files = {"own": str(own), "other": str(pair(other)), "": ""}
    with serving(server_context(own), b"HTTP/1.1 204 No Content\r\n\r\n") as port:
        hook = rig.hook(url=f"https://localhost:{port}/h", ca_file=files[authority])
        hook.put(KEPT)
        await rig.step(hook)
    assert hook.news.taken == (code is None)
    assert (None if hook.problem is None else hook.problem.code) == code
    assert code is None or "[[hook]] ca_file" in str(hook.problem)


async def test_the_secret_is_read_at_the_start(rig: Rig) -> None:
    """A secret that cannot be read is a `StartError` that names the key."""
    gone = rig.settings(secret_file=str(rig.folder / "gone"))
    with pytest.raises(StartError, match=r"^hook\[1\]\.secret_file: .*cannot be read"):
        Hooks([rig.settings(), gone], rig.clock, lambda: 0)
