"""The signature by which a receiver checks who sent an event, and its secret."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from wax.errors import StartError
from wax.hooks.signature import headers, read_secret

if TYPE_CHECKING:
    from pathlib import Path

SECRET = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw"


@pytest.mark.parametrize("text", [SECRET, f"{SECRET}\n", SECRET.removeprefix("whsec_")])
def test_it_is_that_of_standard_webhooks(text: str, tmp_path: Path) -> None:
    """The headers match the test vector of Standard Webhooks' own libraries."""
    path = tmp_path / "secret"
    path.write_text(text)
    secret = read_secret(str(path), "hook[0].secret_file")
    assert headers(secret, "msg_p5jXN8AQM9LWM0D4loKWxJek", 1614265330, b'{"test": 2432232314}') == {
        "webhook-id": "msg_p5jXN8AQM9LWM0D4loKWxJek",
        "webhook-timestamp": "1614265330",
        "webhook-signature": "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=",
    }


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (None, "cannot be read: No such file or directory"),
        (b"", "is empty; make one: "),
        (b" \n", "is empty; make one: "),
        (b"whsec_", "holds a secret of 0 bytes, and it takes 24 to 64; make one: "),
        (b"c2hvcnQ=", "holds a secret of 5 bytes"),
        (b"QUFB" * 200, "holds a secret of 600 bytes"),
        (b"a pass phrase of more than a few letters", "holds no secret in Base64"),
        (b"\xff\xfe\x00", "holds no secret in Base64"),
        (b"QUFB" * 300_000, "cannot be read: it has more than 1048576 bytes"),
    ],
)
def test_a_bad_secret_is_a_sentence(data: bytes | None, says: str, tmp_path: Path) -> None:
    """The sentence names the key and the file, and quotes none of it; a large file is not read."""
    path = tmp_path / "secret"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(StartError) as refused:
        read_secret(str(path), "hook[1].secret_file")
    assert str(refused.value).startswith(f"hook[1].secret_file: {path} ")
    assert says in str(refused.value)
    assert "pass phrase" not in str(refused.value)


def test_a_folder_is_no_secret(tmp_path: Path) -> None:
    """A folder in place of the secret is a `StartError`."""
    with pytest.raises(StartError, match="cannot be read: it is a folder"):
        read_secret(str(tmp_path), "hook[0].secret_file")
