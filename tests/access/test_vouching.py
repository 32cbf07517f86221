"""Who somebody is by a proxy's headers: what is not clear is not believed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from wax.access.vouching import PROOF_S, Vouching
from wax.config.proxy import ProxySettings

if TYPE_CHECKING:
    from wax.access.vouching import Vouched

READS = {"person": "Remote-User", "name": "Remote-Name", "groups": "Remote-Groups"}


def judge(said: dict[str, list[str]], **more: Any) -> Vouched:
    return Vouching(ProxySettings.model_validate(READS | more)).judge(said, 1000.0)


def code(vouched: Vouched) -> str | None:
    return None if vouched.refusal is None else vouched.refusal.code


def test_somebody_is_whom_the_proxy_names() -> None:
    """The same name is the same person everywhere, and is proved for less than a minute."""
    alice, again, bob = (judge({"remote-user": [name]}) for name in ("alice", " alice ", "bob"))
    assert alice == again
    assert alice.identity != bob.identity
    assert (alice.refusal, alice.until_s) == (None, 1000.0 + PROOF_S)
    assert "alice" not in alice.identity
    assert PROOF_S < 60.0


@pytest.mark.parametrize(
    ("said", "refused"),
    [
        ({}, "door.not_signed_in"),
        ({"remote-user": []}, "door.not_signed_in"),
        ({"remote-user": [""]}, "door.not_signed_in"),
        ({"remote-user": ["  "]}, "door.not_signed_in"),
        ({"remote-user": ["alice", "alice"]}, "door.unclear_sign_in"),
        ({"remote-user": ["", "alice"]}, "door.unclear_sign_in"),
        ({"remote-user": ["mallory, alice"]}, "door.unclear_sign_in"),
        ({"remote-user": ["{http.reverse_proxy.header.Remote-User}"]}, "door.unclear_sign_in"),
        ({"remote-user": ["ali\x01ce"]}, "door.unclear_sign_in"),
        ({"remote-user": ["alice\x7f"]}, "door.unclear_sign_in"),
        ({"remote-user": ["ali\udcffce"]}, "door.unclear_sign_in"),
        ({"remote-user": ["a" * 257]}, "door.unclear_sign_in"),
        ({"remote-user": ["alice"], "remote-groups": ["staff", "hosts"]}, "door.unclear_sign_in"),
        ({"remote-user": ["alice"], "remote-groups": ["x" * 4097]}, "door.unclear_sign_in"),
        ({"remote-user": ["alice"], "remote-name": ["A", "B"]}, "door.unclear_sign_in"),
        ({"remote-groups": ["hosts"], "remote-name": ["Alice"]}, "door.not_signed_in"),
        ({"remote_user": ["alice"]}, "door.not_signed_in"),
    ],
)
def test_what_is_not_clear_is_not_believed(said: dict[str, list[str]], refused: str) -> None:
    """Nobody is anybody by a header that is missing, empty, doubled, joined, spoilt or too long."""
    vouched = judge(said, host=["hosts"])
    assert code(vouched) == refused
    assert (vouched.identity, vouched.right) == ("", "stranger")


@pytest.mark.parametrize(
    ("groups", "right"),
    [
        ("", None),
        ("teachers", None),
        ("guests", "watch"),
        ("guests, pupils", "drive"),
        ("pupils|staff", "host"),
        ("staff,,pupils", "host"),
        ("STAFF", None),
        ("staff2", None),
        ("staff,expelled", None),
    ],
)
def test_groups_decide(groups: str, right: str | None) -> None:
    """The most that a group allows counts, unless another is refused; names must be the same."""
    lists = {"host": ["staff"], "drive": ["pupils"], "watch": ["guests"], "refuse": ["expelled"]}
    vouched = judge({"remote-user": ["alice"], "remote-groups": [groups]}, **lists)
    assert vouched.identity
    if right is None:
        assert (code(vouched), vouched.right) == ("door.not_for_group", "stranger")
    else:
        assert (code(vouched), vouched.right) == (None, right)


def test_without_lists_people_are_strangers_by_name() -> None:
    """Where no group may drive or watch, everybody whom the proxy names may what strangers may."""
    vouched = judge({"remote-user": ["alice"], "remote-groups": ["any"]}, host=["staff"])
    assert (vouched.refusal, vouched.right) == (None, "stranger")


@pytest.mark.parametrize(
    ("told", "shown"),
    [
        ("Jane Doe", "Jane Doe"),
        ("Doe, Jane", "Doe, Jane"),
        ("=?utf-8?q?Ferris_B=C3=BCller?=", "Ferris Büller"),
        ("=?no-such?q?Ferris?=", "=?no-such?q?Ferris?="),
        ("=?utf-8?b?a?=", "=?utf-8?b?a?="),
        ("=?utf-8?q?=FF?=", "=?utf-8?q?=FF?="),
        ("", ""),
    ],
)
def test_the_name_is_what_the_proxy_shows(told: str, shown: str) -> None:
    """A name may be encoded, as Tailscale does; one that is badly encoded stays as it is."""
    assert judge({"remote-user": ["j"], "remote-name": [told]}).name == shown


def test_a_proof_ends() -> None:
    """What was proved counts until its time is over; then only who it was is left."""
    vouched = judge({"remote-user": ["alice"], "remote-groups": ["staff"]}, host=["staff"])
    assert vouched.at(vouched.until_s - 0.1) is vouched
    ended = vouched.at(vouched.until_s)
    assert (ended.identity, ended.right) == (vouched.identity, "stranger")
    assert code(ended) == "door.not_signed_in"
