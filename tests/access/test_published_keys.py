"""The keys of a proxy that signs: read at the start, and again when there is a reason."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from tests.access.signing import CURVE, KEYS, RSA, jwks, of_curve, of_rsa
from tests.turned_clock import turn_loop

from wax.access import published_keys
from wax.access.published_keys import EVERY_S, LEAST_S, PublishedKeys
from wax.errors import StartError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from wax.access.signed_tokens import Keys


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "keys.json"
    path.write_bytes(KEYS)
    return path


@pytest.mark.parametrize(
    ("text", "why"), [(None, "does not exist"), (b"no", "holds no JWKS"), (b" " * 70_000, "more")]
)
def test_a_file_without_keys_is_a_sentence(file: Path, text: bytes | None, why: str) -> None:
    """A file that is missing, wrong or too large names itself and its key at the start."""
    file.unlink()
    if text is not None:
        file.write_bytes(text)
    with pytest.raises(StartError, match=f"access.proxy.keys: .*{why}"):
        PublishedKeys(str(file))


def test_the_old_keys_stay_while_none_are_to_be_had(file: Path) -> None:
    """Somebody whose key is known comes in, though the keys cannot be read again."""
    keys = PublishedKeys(str(file))
    file.unlink()
    asyncio.run(keys.refresh())
    assert keys.get("rsa") is not None
    file.write_bytes(jwks(of_rsa(RSA, "new")))
    asyncio.run(keys.refresh())
    assert (keys.get("rsa"), keys.get("new") is None) == (None, False)


async def test_an_address_that_does_not_answer_is_no_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """A server whose keys are not published yet starts all the same, with none."""

    def fails(_: str) -> bytes:
        raise StartError("nobody answers")

    monkeypatch.setattr(published_keys, "_fetched", fails)
    keys = PublishedKeys("https://id.example/certs")
    await keys.refresh()
    assert keys.get("rsa") is None
    monkeypatch.setattr(published_keys, "_fetched", lambda _: jwks(of_curve(CURVE, "curve")))
    await keys.refresh()
    assert keys.get("curve") is not None


async def test_many_unknown_keys_are_one_look(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """However many tokens name an unknown key, the keys are read once a minute; else each hour."""
    sources: list[str] = []

    async def read_now(_: str, call: Callable[[], Keys]) -> Keys:
        sources.append("read")
        return call()

    keys = PublishedKeys(str(file))
    monkeypatch.setattr(published_keys, "daemon_call", read_now)
    running = asyncio.create_task(keys.run())
    for minutes in range(1, 4):
        await _passes()
        assert len(sources) == minutes
        for _ in range(100):
            keys.get("unknown")
            await asyncio.sleep(0)
        assert len(sources) == minutes
        turn_loop(LEAST_S, monkeypatch)
    await _passes()
    turn_loop(LEAST_S, monkeypatch)
    await _passes()
    assert len(sources) == 4
    turn_loop(EVERY_S, monkeypatch)
    await _passes()
    assert len(sources) == 5
    running.cancel()


async def _passes() -> None:
    for _ in range(10):
        await asyncio.sleep(0)
