"""The secret that signs cookies and invitations, kept in the state folder."""

from __future__ import annotations

import secrets
from typing import Final

import structlog

from wax import state_dir
from wax.access.keyring import SECRET_BYTES
from wax.errors import StateError
from wax.named_file import read_bytes

_LOG = structlog.get_logger(__name__)

FILE: Final = "secret"


def load_secret(state: str) -> bytes:
    """Return the secret, created if missing; one that cannot be stored lasts as long as the server.

    `state` is the configured state folder.
    """
    try:
        path = state_dir.prepare(state_dir.find(state)) / FILE
        state_dir.make_private(path)
        kept = read_bytes(path)
        if len(kept) == SECRET_BYTES:
            return kept
        made = secrets.token_bytes(SECRET_BYTES)
        state_dir.replace(path, made)
    except (OSError, StateError) as error:
        _LOG.warning("invitations end with the server: its secret cannot be kept", error=str(error))
        return secrets.token_bytes(SECRET_BYTES)
    return made
