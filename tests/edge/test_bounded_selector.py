"""A pass of the event loop serves a few incoming connections, and all of our own sockets."""

from __future__ import annotations

import os
import selectors
import socket
from contextlib import ExitStack
from typing import TYPE_CHECKING

import pytest

from wax.edge.binding import listen
from wax.edge.bounded_selector import CONNECTIONS_IN_A_PASS, BoundedSelector, bounded_loop
from wax.edge.step_watch import StepWatch

if TYPE_CHECKING:
    from collections.abc import Iterator

    from _typeshed import FileDescriptorLike

MANY = 5 * CONNECTIONS_IN_A_PASS
KNOWN = "127.0.0.9"
ATTACKERS = [f"127.0.0.{number}" for number in range(2, 4)]


@pytest.fixture
def held() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def listening(held: ExitStack) -> socket.socket:
    (made,) = listen("127.0.0.1", 0)
    return held.enter_context(made)


@pytest.fixture
def selector(held: ExitStack, listening: socket.socket) -> BoundedSelector:
    made = BoundedSelector(lambda address: address, lambda: None, KNOWN.__eq__)
    held.enter_context(made)
    made.register(listening, selectors.EVENT_READ)
    return made


def came_and_ended(
    held: ExitStack, listening: socket.socket, address: str = "127.0.0.1"
) -> socket.socket:
    made = socket.create_connection(listening.getsockname(), source_address=(address, 0))
    with made:
        return held.enter_context(listening.accept()[0])


def crowd(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector, address: str = "127.0.0.1"
) -> list[socket.socket]:
    """Return many connections that stay ready."""
    ended = [came_and_ended(held, listening, address) for _ in range(MANY)]
    for one in ended:
        selector.register(one, selectors.EVENT_READ)
    return ended


def served(selector: BoundedSelector) -> list[FileDescriptorLike]:
    return [key.fileobj for key, _ in selector.select(0)]


def test_connections_that_end_at_once_are_served_in_turns(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector
) -> None:
    ended = crowd(held, listening, selector)
    passes = [served(selector) for _ in range(10)]
    assert {len(one) for one in passes} == {CONNECTIONS_IN_A_PASS}
    for half in passes[:5], passes[5:]:
        assert {id(one) for found in half for one in found} == {id(one) for one in ended}


def test_a_connection_read_again_is_not_served_before_its_turn(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector
) -> None:
    """A connection that pauses and resumes reading gains nothing."""
    first = crowd(held, listening, selector)[0]
    waited: list[int] = []
    for number in range(20):
        if first in served(selector):
            waited.append(number)
        selector.unregister(first)
        selector.register(first, selectors.EVENT_READ)
    assert len(waited) <= 20 * CONNECTIONS_IN_A_PASS / MANY


@pytest.mark.parametrize("is_new", [True, False])
def test_senders_take_turns(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector, *, is_new: bool
) -> None:
    """A Stop, even on an old connection, waits for at most one of every other sender's."""
    kept = came_and_ended(held, listening)
    if not is_new:
        selector.register(kept, selectors.EVENT_READ)
    for attacker in ATTACKERS:
        crowd(held, listening, selector, attacker)
    for _ in range(2):
        selector.select(0)
    if is_new:
        selector.register(kept, selectors.EVENT_READ)
    else:
        selector.modify(kept, selectors.EVENT_READ | selectors.EVENT_WRITE)
    assert kept in served(selector)


def test_known_senders_pass_strangers(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector
) -> None:
    """Strangers with many addresses delay no known sender; a known crowd leaves them one place."""
    strangers = [crowd(held, listening, selector, f"127.0.1.{number}") for number in range(3, 30)]
    known = came_and_ended(held, listening, KNOWN)
    selector.select(0)
    selector.register(known, selectors.EVENT_READ)
    first = served(selector)
    assert first[0] is known
    assert len(first) == CONNECTIONS_IN_A_PASS
    crowd(held, listening, selector, KNOWN)
    many = served(selector)
    assert len(many) == CONNECTIONS_IN_A_PASS + 1
    assert sum(any(one is many[-1] for one in some) for some in strangers) == 1


def test_sockets_of_our_own_do_not_wait(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector
) -> None:
    """Those of media, the driver and a broker, and the listening sockets, are always served."""
    crowd(held, listening, selector)
    broker = held.enter_context(socket.create_server(("127.0.0.1", 0)))
    outgoing = held.enter_context(socket.create_connection(broker.getsockname()))
    broker.accept()[0].close()
    datagrams = held.enter_context(socket.socket(type=socket.SOCK_DGRAM))
    datagrams.bind(listening.getsockname())  # the same port
    datagrams.sendto(b"x", datagrams.getsockname())
    ours, theirs = map(held.enter_context, socket.socketpair())
    theirs.send(b"x")
    reading, writing = os.pipe()
    held.callback(os.close, reading)
    os.close(writing)
    other = held.enter_context(listen("127.0.0.1", 0)[0])
    held.enter_context(socket.create_connection(other.getsockname()))
    held.enter_context(socket.create_connection(listening.getsockname()))
    own: list[FileDescriptorLike] = [outgoing, datagrams, ours, reading, other]
    for one in own:
        selector.register(one, selectors.EVENT_READ)
    for _ in range(MANY):
        found = served(selector)
        assert all(one in found for one in [*own, listening])
        assert len(found) == CONNECTIONS_IN_A_PASS + len(own) + 1


def test_a_descriptor_is_what_it_is_now(
    held: ExitStack, listening: socket.socket, selector: BoundedSelector
) -> None:
    """The number of a closed connection may become that of our own socket, and vice versa."""
    crowd(held, listening, selector)
    gone = came_and_ended(held, listening)
    selector.register(gone, selectors.EVENT_READ)
    number = gone.fileno()
    selector.unregister(gone)
    ours, theirs = map(held.enter_context, socket.socketpair())
    os.dup2(ours.fileno(), number)
    theirs.send(b"x")
    selector.register(number, selectors.EVENT_READ)
    assert number in served(selector)
    assert number in served(selector)


def test_the_event_loop_has_passes_between_the_connections_of_a_crowd(
    held: ExitStack, listening: socket.socket
) -> None:
    """The loop registers them by their descriptors."""
    loop = bounded_loop(lambda address: address, StepWatch())
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
