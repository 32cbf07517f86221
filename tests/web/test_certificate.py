"""The self-signed certificate of --https."""

from __future__ import annotations

import datetime
import ssl
from typing import TYPE_CHECKING

import pytest
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec

from wax.errors import StartError
from wax.web.certificate import LASTS, Certificate, self_signed

if TYPE_CHECKING:
    from pathlib import Path

NOW = datetime.datetime.now(datetime.UTC)
NAMES = ["localhost", "robot.local", "192.0.2.7", "::1"]


def test_it_is_reused(tmp_path: Path) -> None:
    """People accept it in their browser once, so the next start uses the same one."""
    first = self_signed(tmp_path / "state", NAMES, NOW).fingerprint()
    assert self_signed(tmp_path / "state", NAMES, NOW).fingerprint() == first


def test_nobody_else_reads_the_key(tmp_path: Path) -> None:
    """Nobody can, not even while it is written."""
    kept = self_signed(tmp_path / "state", NAMES, NOW)
    assert kept.key.stat().st_mode & 0o777 == 0o600
    assert kept.key.parent.stat().st_mode & 0o777 == 0o700


def test_it_is_renewed_in_time(tmp_path: Path) -> None:
    """It is replaced a month before it expires, or when key and certificate do not match."""
    first = self_signed(tmp_path, NAMES, NOW)
    old = first.fingerprint()
    later = NOW + LASTS - datetime.timedelta(days=29)
    assert self_signed(tmp_path, NAMES, later).fingerprint() != old
    first.key.write_bytes(self_signed(tmp_path / "other", NAMES, NOW).key.read_bytes())
    renewed = self_signed(tmp_path, NAMES, NOW).fingerprint()
    assert self_signed(tmp_path, NAMES, NOW).fingerprint() == renewed


def test_one_from_the_future_is_replaced(tmp_path: Path) -> None:
    """A first start with a wrong clock costs one certificate; a step of an hour costs none."""
    future = self_signed(tmp_path, NAMES, NOW + datetime.timedelta(days=5 * 365)).fingerprint()
    kept = self_signed(tmp_path, NAMES, NOW)
    right = kept.fingerprint()
    assert right != future
    assert kept.validity()[0] <= NOW
    assert self_signed(tmp_path, NAMES, NOW - datetime.timedelta(hours=1)).fingerprint() == right


def test_a_new_address_needs_a_new_certificate(tmp_path: Path) -> None:
    """A name that is gone needs none, since people must accept each new certificate."""
    first = self_signed(tmp_path, NAMES, NOW).fingerprint()
    assert self_signed(tmp_path, NAMES[1:], NOW).fingerprint() == first
    assert self_signed(tmp_path, [*NAMES, "192.0.2.8"], NOW).fingerprint() != first
    assert "192.0.2.8" in self_signed(tmp_path, NAMES, NOW).names()


@pytest.mark.parametrize("damage", [b"", b"nonsense", b"-----BEGIN CERTIFICATE-----\n"])
def test_a_damaged_one_is_replaced(tmp_path: Path, damage: bytes) -> None:
    """A half-written file does not prevent the start."""
    self_signed(tmp_path, NAMES, NOW).chain.write_bytes(damage)
    assert len(self_signed(tmp_path, NAMES, NOW).fingerprint()) == 32 * 3 - 1


def test_a_browser_could_check_the_name(tmp_path: Path) -> None:
    """A client that trusts it accepts the names and addresses that we serve, and no other."""
    kept = self_signed(tmp_path, NAMES, NOW)
    client = ssl.create_default_context(cafile=str(kept.chain))
    for name in NAMES:
        assert _shake_hands(kept.context(), client, name)
    with pytest.raises(ssl.SSLCertVerificationError):
        _shake_hands(kept.context(), client, "evil.example")


def _shake_hands(server: ssl.SSLContext, client: ssl.SSLContext, name: str) -> bool:
    to_server, to_client = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = [
        client.wrap_bio(to_client, to_server, server_hostname=name),
        server.wrap_bio(to_server, to_client, server_side=True),
    ]
    for _ in range(4):
        for end in list(ends):
            try:
                end.do_handshake()
                ends.remove(end)
            except ssl.SSLWantReadError:
                pass
    return not ends


def _hello(group: int, share: bytes) -> bytes:
    """Begin TLS 1.3 with a share of this one group (RFC 8446, 4.1.2 and 4.2.8)."""

    def sized(count: int, body: bytes) -> bytes:
        return len(body).to_bytes(count) + body

    named = group.to_bytes(2)
    extensions = {
        10: sized(2, named),
        13: sized(2, b"\x04\x03\x08\x04"),
        43: b"\x02\x03\x04",
        51: sized(2, named + sized(2, share)),
    }
    told = b"".join(kind.to_bytes(2) + sized(2, body) for kind, body in extensions.items())
    body = b"\x03\x03" + bytes(32) + b"\0" + sized(2, b"\x13\x01") + b"\x01\0" + sized(2, told)
    return b"\x16\x03\x01" + sized(2, b"\x01" + sized(3, body))


@pytest.mark.parametrize("is_old", [False, True])
def test_no_client_chooses_a_costly_key_exchange(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, is_old: bool
) -> None:
    """One is taken that every browser has, and none that blocks the event loop.

    It is X25519, and P-256 where Python cannot set that, as Debian 12's cannot.
    """
    if is_old:
        monkeypatch.setattr(ssl.SSLContext, "set_ecdh_curve", _set_older_group)
    elif not _sets_x25519():
        pytest.skip("this Python is such an old one")
    context = self_signed(tmp_path, NAMES, NOW).context()
    point = ec.generate_private_key(ec.SECP256R1()).public_key()
    p256 = point.public_bytes(
        serialization.Encoding.X962, serialization.PublicFormat.UncompressedPoint
    )
    answers = []
    for group, share in (
        (0x001D, b"\x09" + bytes(31)),
        (0x0017, p256),
        (0x0104, bytes(1023) + b"\x04"),
    ):
        came, goes = ssl.MemoryBIO(), ssl.MemoryBIO()
        end = context.wrap_bio(came, goes, server_side=True)
        came.write(_hello(group, share))
        with pytest.raises(ssl.SSLError) as stopped:
            end.do_handshake()
        answers.append(type(stopped.value))
    taken = [ssl.SSLError, ssl.SSLWantReadError]
    assert answers == [*(taken if is_old else reversed(taken)), ssl.SSLError]


def _sets_x25519() -> bool:
    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).set_ecdh_curve("X25519")
    except (ValueError, ssl.SSLError):
        return False
    return True


def _set_older_group(context: ssl.SSLContext, name: str) -> None:
    if name == "X25519":
        raise ssl.SSLError("unknown group")
    super(ssl.SSLContext, context).set_ecdh_curve(name)


def test_nobody_is_asked_for_a_key_s_password(tmp_path: Path) -> None:
    """An encrypted key is an error; OpenSSL would ask at the terminal, and a service has none."""
    kept = self_signed(tmp_path, NAMES, NOW)
    key = serialization.load_pem_private_key(kept.key.read_bytes(), None)
    locked = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.BestAvailableEncryption(b"secret"),
    )
    kept.key.write_bytes(locked)
    with pytest.raises(StartError, match=r"key\.pem is encrypted"):
        kept.context()


def test_files_that_cannot_be_used_are_named(tmp_path: Path) -> None:
    """The error names the file, whatever is wrong with it."""
    missing = Certificate(tmp_path / "none.pem", tmp_path / "none.key")
    with pytest.raises(StartError, match=r"none\.pem"):
        missing.context()
    with pytest.raises(StartError, match=r"none\.pem"):
        missing.fingerprint()
    (tmp_path / "file").write_text("")
    with pytest.raises(StartError, match="cannot keep a certificate"):
        self_signed(tmp_path / "file" / "state", NAMES, NOW)
