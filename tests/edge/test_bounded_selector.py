"""Of the connections that came in, a pass of the event loop serves a few, and of ours all."""

from __future__ import annotations

import selectors
import socket
from contextlib import ExitStack
from typing import TYPE_CHECKING

import pytest

from wax.edge.bounded_selector import CONNECTIONS_IN_A_PASS, BoundedSelector, bounded_loop

if TYPE_CHECKING:
    from collections.abc import Iterator

MANY = 3 * CONNECTIONS_IN_A_PASS


@pytest.fixture
def held() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def selector(held: ExitStack) -> BoundedSelector:
    return held.enter_context(BoundedSelector())


@pytest.fixture
def listening(held: ExitStack, selector: BoundedSelector) -> socket.socket:
    made = held.enter_context(socket.create_server(("127.0.0.1", 0), backlog=MANY))
    selector.register(made, selectors.EVENT_READ)
    return made


def came_and_ended(held: ExitStack, listening: socket.socket) -> socket.socket:
    with socket.create_connection(listening.getsockname()):
        return held.enter_context(listening.accept()[0])


def served(selector: BoundedSelector) -> list[object]:
    return [key.fileobj for key, _ in selector.select(0)]


def test_connections_that_end_at_once_are_served_in_turns(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector
) -> None:
    ended = [came_and_ended(held, listening) for _ in range(MANY)]
    for one in ended:
        selector.register(one, selectors.EVENT_READ)
    passes = [served(selector) for _ in range(2 * MANY // CONNECTIONS_IN_A_PASS)]
    assert {len(one) for one in passes} == {CONNECTIONS_IN_A_PASS}
    for half in passes[:3], passes[3:]:  # although each stays ready
        assert {id(one) for found in half for one in found} == {id(one) for one in ended}


def test_a_newcomer_is_served_before_those_that_only_end(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector
) -> None:
    for _ in range(MANY):
        selector.register(came_and_ended(held, listening), selectors.EVENT_READ)
    for _ in range(MANY // CONNECTIONS_IN_A_PASS):
        selector.select(0)
    newcomer = came_and_ended(held, listening)
    selector.register(newcomer, selectors.EVENT_READ)
    assert newcomer in served(selector)
    assert newcomer not in served(selector)


def test_sockets_of_our_own_do_not_wait(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector
) -> None:
    """Media's, the driver's, a broker's, and that where the next connection comes in."""
    for _ in range(MANY):
        selector.register(came_and_ended(held, listening), selectors.EVENT_READ)
    broker = held.enter_context(socket.create_server(("127.0.0.1", 0)))
    outgoing = held.enter_context(socket.create_connection(broker.getsockname()))
    broker.accept()[0].close()
    datagrams = held.enter_context(socket.socket(type=socket.SOCK_DGRAM))
    datagrams.bind(("127.0.0.1", 0))
    datagrams.sendto(b"x", datagrams.getsockname())
    ours, theirs = map(held.enter_context, socket.socketpair())
    theirs.send(b"x")
    waiting = held.enter_context(socket.create_connection(listening.getsockname()))
    own = [outgoing, datagrams, ours, listening]
    for one in own[:-1]:
        selector.register(one, selectors.EVENT_READ)
    for _ in range(MANY):
        found = served(selector)
        assert all(one in found for one in own)
        assert len(found) == CONNECTIONS_IN_A_PASS + len(own)
    assert waiting.fileno() not in selector.get_map()


def test_timers_run_between_the_connections_of_a_crowd(
    held: ExitStack, listening: socket.socket
) -> None:
    """As asyncio knows them, by their descriptors."""
    loop = bounded_loop()
    held.callback(loop.close)
    loop.add_reader(listening, lambda: None)
    in_passes = [0]
    left = {came_and_ended(held, listening) for _ in range(MANY)}

    def end(one: socket.socket) -> None:
        in_passes[-1] += 1
        loop.remove_reader(one.fileno())
        left.discard(one)
        if not left:
            loop.stop()

    def in_a_pass() -> None:
        in_passes.append(0)
        loop.call_soon(in_a_pass)

    for one in left:
        loop.add_reader(one.fileno(), end, one)
    loop.call_soon(in_a_pass)
    loop.run_forever()
    assert max(in_passes) == CONNECTIONS_IN_A_PASS
