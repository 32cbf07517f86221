"""Identities and invitations are valid only with this server's signature."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.access.keyring import Keyring
from wax.errors import ForbiddenError
from wax.protocol.http_bodies import MAX_TOKEN_CHARS

SECRET = b"s" * 32


class Wall:
    """A wall clock that a test sets."""

    def __init__(self) -> None:
        self.now_s = 1_800_000_000.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def wall() -> Wall:
    return Wall()


@pytest.fixture
def keyring(wall: Wall) -> Keyring:
    return Keyring(SECRET, wall)


def test_an_identity_is_known_again(keyring: Keyring, wall: Wall) -> None:
    """An identity survives a restart with the same secret; two browsers' identities differ."""
    one, other = keyring.new_identity(), keyring.new_identity()
    assert keyring.identity_of(one) != keyring.identity_of(other)
    assert Keyring(SECRET, wall).identity_of(one) == keyring.identity_of(one)


@pytest.mark.parametrize("made", [None, "", ".", "abc", "abc.def", "é.è", "\0", "a" * 100_000])
def test_an_invented_identity_is_nobodys(keyring: Keyring, made: str | None) -> None:
    """A cookie without our signature gives no identity."""
    assert keyring.identity_of(made) is None


def test_another_servers_identity_is_nobodys(keyring: Keyring, wall: Wall) -> None:
    """An identity signed with another secret is invalid."""
    assert keyring.identity_of(Keyring(b"t" * 32, wall).new_identity()) is None


def test_an_invitation_is_no_identity(keyring: Keyring) -> None:
    """An invitation is no valid identity, nor an identity an invitation."""
    assert keyring.identity_of(keyring.invite("queue", uses=1, valid_s=60)) is None
    with pytest.raises(ForbiddenError):
        keyring.invitation_of(keyring.new_identity())


def test_an_invitation_says_what_it_is_for(keyring: Keyring, wall: Wall) -> None:
    """An invitation carries its purpose, uses and expiry, and an id of its own."""
    one = keyring.invitation_of(keyring.invite("watch", uses=3, valid_s=3600))
    other = keyring.invitation_of(keyring.invite("watch", uses=3, valid_s=3600))
    assert (one.purpose, one.uses, one.ends_s) == ("watch", 3, wall.now_s + 3600)
    assert one.id != other.id


@pytest.mark.parametrize(
    ("later_s", "sentence"),
    [(3600, "expired"), (1e9, "expired"), (-301, "clock is wrong"), (-1e9, "clock is wrong")],
)
def test_an_invitation_ends(keyring: Keyring, wall: Wall, later_s: float, sentence: str) -> None:
    """An invitation is refused after it expires, or if the clock was set back far."""
    token = keyring.invite("queue", uses=1, valid_s=3600)
    wall.now_s += later_s
    with pytest.raises(ForbiddenError, match=sentence):
        keyring.invitation_of(token)


def test_a_clock_that_was_corrected_a_little_ends_nothing(keyring: Keyring, wall: Wall) -> None:
    """A clock set back by up to five minutes refuses no invitation."""
    token = keyring.invite("queue", uses=1, valid_s=3600)
    wall.now_s -= 299
    assert keyring.invitation_of(token).uses == 1


@examples(300)
@given(st.data())
def test_a_changed_token_is_refused(data: st.DataObject) -> None:
    """A token with any character lost, added or changed is refused."""
    keyring = Keyring(SECRET, Wall())
    for token, read in (
        (keyring.invite("queue", uses=1, valid_s=60), keyring.invitation_of),
        (keyring.new_identity(), keyring.identity_of),
    ):
        at = data.draw(st.integers(0, MAX_TOKEN_CHARS)) % len(token)
        end = at + data.draw(st.integers(0, MAX_TOKEN_CHARS)) % (len(token) - at + 1)
        changed = token[:at] + data.draw(st.text(max_size=5)) + token[end:]
        if changed == token:
            continue
        try:
            found = read(changed)
        except ForbiddenError:
            found = None
        # base64 leaves bits unused at the end; changing only those changes nothing signed.
        assert found is None or found == read(token)


@examples(300)
@given(st.one_of(st.text(), st.text(alphabet="AZaz09-_.", max_size=2 * MAX_TOKEN_CHARS)))
def test_any_text_is_answered(text: str) -> None:
    """Any text is either a valid token or raises `ForbiddenError`."""
    keyring = Keyring(SECRET, Wall())
    assert keyring.identity_of(text) is None
    with pytest.raises(ForbiddenError):
        keyring.invitation_of(text)
