"""Which certificate authorities are trusted for the host's own programs."""

from __future__ import annotations

import ssl

from wax.errors import StartError, reason_of
from wax.folders import expanded
from wax.named_file import read_bytes


def client_tls(ca_file: str, key: str) -> ssl.SSLContext:
    """Return a context that trusts only the authority in `ca_file`, or this machine's if empty.

    Raises `StartError`, which names the configuration's `key`.
    """
    path = expanded(ca_file) if ca_file else None
    try:
        if path is not None:
            read_bytes(path)  # OpenSSL would block on a pipe, and read a device without end
        context = ssl.create_default_context(cafile=path)
        if path is not None:  # strict checks (Python 3.13) refuse most authorities made by hand
            context.verify_flags &= ~ssl.VERIFY_X509_STRICT
        return context
    except OSError as error:  # an SSLError, too
        why = reason_of(error)
        raise StartError(f"{key}: {ca_file} holds no certificate: {why}") from error
