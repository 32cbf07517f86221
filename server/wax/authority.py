"""Whose certificates count on the way to a program of the host's."""

from __future__ import annotations

import ssl

from wax.errors import StartError, reason_of
from wax.folders import expanded
from wax.named_file import read_bytes


def client_tls(ca_file: str, key: str) -> ssl.SSLContext:
    """Return what trusts the authority in `ca_file` alone, or this machine's if it is empty.

    Raises `StartError`, which names the configuration's `key`.
    """
    path = expanded(ca_file) if ca_file else None
    try:
        if path is not None:
            read_bytes(path)  # OpenSSL would wait for a pipe, and read a device without end
        context = ssl.create_default_context(cafile=path)
        if path is not None:  # from Python 3.13 on, most that a host makes by hand are refused
            context.verify_flags &= ~ssl.VERIFY_X509_STRICT
        return context
    except OSError as error:  # an SSLError, too
        why = reason_of(error)
        raise StartError(f"{key}: {ca_file} holds no certificate: {why}") from error
