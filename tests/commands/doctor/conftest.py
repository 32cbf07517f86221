"""Network configurations for the checks."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import pytest

from wax.commands.doctor.network import ServedNetwork

if TYPE_CHECKING:
    from collections.abc import Callable

    MakeNetwork = Callable[..., ServedNetwork]


@pytest.fixture
def network() -> MakeNetwork:
    """Return a function that makes a network open to all, with the given fields."""
    usual = ServedNetwork(
        host="0.0.0.0",
        tcp_port=8080,
        udp_port=8081,
        interfaces=(),
        public_addresses=(),
        stun=(),
        certificate=None,
        is_self_signed=False,
        is_behind_proxy=False,
        names=(),
    )

    def make(**fields: Any) -> ServedNetwork:
        return dataclasses.replace(usual, **fields)

    return make
