"""An address that has not answered a check of ours gets only short answers."""

from __future__ import annotations

import pytest
from aioice.stun import Class, Message, Method, parse_message
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.rtc.one_port.lite_agent import MAX_PATHS, Datagram, LiteAgent, Path

HERE = Path(0, "192.0.2.7", 5000)
THERE = Path(0, "192.0.2.8", 5000)
STRANGER = Path(0, "203.0.113.1", 53)


class Browser:
    """The browser's side, which knows both ends' credentials."""

    def __init__(self) -> None:
        self.agent = LiteAgent(now_s=0.0)
        self.agent.remote_username, self.agent.remote_password = "browser", "secret"

    def check(
        self,
        path: Path = HERE,
        now_s: float = 0.0,
        *,
        nominates: bool = False,
        password: str | None = None,
        username: str | None = None,
    ) -> list[Message]:
        """Send a check on a path; return what comes back on it."""
        request = Message(Method.BINDING, Class.REQUEST)
        request.attributes["USERNAME"] = username or f"{self.agent.username}:browser"
        request.attributes["PRIORITY"] = 1
        if nominates:
            request.attributes["USE-CANDIDATE"] = None
        request.add_message_integrity((password or self.agent.password).encode())
        sent = self.agent.handle_request(parse_message(bytes(request)), path, now_s)
        assert all(one.path == path for one in sent)
        return [parse_message(one.data) for one in sent]

    def answer(
        self, probe: Message, path: Path = HERE, now_s: float = 0.0, *, password: str = "secret"
    ) -> bool:
        """Answer a check by the agent on a path."""
        answer = Message(Method.BINDING, Class.RESPONSE, probe.transaction_id)
        answer.attributes["XOR-MAPPED-ADDRESS"] = ("192.0.2.1", 8081)
        answer.add_message_integrity(password.encode())
        return self.agent.handle_response(parse_message(bytes(answer)), path, now_s)

    def verify(self, path: Path = HERE, now_s: float = 0.0, *, nominates: bool = True) -> None:
        _, probe = self.check(path, now_s, nominates=nominates)
        assert self.answer(probe, path, now_s)


@pytest.fixture
def browser() -> Browser:
    return Browser()


def test_a_check_is_answered_and_triggers_our_own(browser: Browser) -> None:
    """The answer is signed and contains the sender's address; our own check is signed, too."""
    answer, probe = browser.check()
    assert answer.message_class == Class.RESPONSE
    assert answer.attributes["XOR-MAPPED-ADDRESS"] == (HERE.host, HERE.port)
    assert answer.check_message_integrity(browser.agent.password.encode())
    assert probe.attributes["USERNAME"] == f"browser:{browser.agent.username}"
    assert probe.check_message_integrity(b"secret")
    assert browser.agent.selected is None
    assert not browser.agent.note_datagram(HERE, 0.0)


def test_an_address_that_answers_is_accepted(browser: Browser) -> None:
    """A nominated address that answers our check gets all traffic."""
    browser.verify()
    assert browser.agent.note_datagram(HERE, 0.0)
    assert browser.agent.selected == HERE


def test_a_nomination_may_follow_verification(browser: Browser) -> None:
    """The first address that answers is used until the browser nominates one."""
    browser.verify(HERE, nominates=False)
    assert browser.agent.selected == HERE
    browser.verify(THERE, 0.1, nominates=False)
    assert browser.agent.selected == HERE
    browser.check(THERE, 0.2, nominates=True)
    assert browser.agent.selected == THERE


def test_a_forged_address_gets_only_short_answers(browser: Browser) -> None:
    """An address forged on a check gets a few short datagrams, and no video."""
    browser.verify()
    sent = len(browser.check(STRANGER, nominates=True))
    now_s = 0.0
    while now_s < 10:
        now_s += 0.05
        sent += len(browser.agent.tick(now_s))
    assert browser.agent.selected == HERE
    assert sent <= 1 + 5
    assert not browser.agent.is_asking


def test_forged_addresses_share_a_rate_limit(browser: Browser) -> None:
    """Checks from a hundred forged addresses in a second draw a dozen checks of ours."""
    probes = 0
    for number in range(100):
        path = Path(0, f"203.0.113.{number}", 53)
        probes += len(browser.check(path, number / 100)) - 1
    assert probes <= 8 + 4 + 1


@pytest.mark.parametrize("username", ["other:browser", "x", "", ":"])
def test_a_check_that_is_not_for_us_gets_no_answer(browser: Browser, username: str) -> None:
    """A check with a wrong password or another peer's name gets no answer."""
    assert browser.check(password="wrong") == []
    assert browser.check(username=username or ":browser") == []


def test_no_check_is_answered_before_the_offer() -> None:
    """Before the offer is known, no check is answered."""
    browser = Browser()
    browser.agent.remote_username = None
    assert browser.check() == []


@pytest.mark.parametrize("fault", ["password", "path", "transaction", "error"])
def test_a_forged_answer_verifies_nothing(browser: Browser, fault: str) -> None:
    """A wrongly signed, foreign, mismatched or error response verifies nothing."""
    _, probe = browser.check(nominates=True)
    if fault == "password":
        assert not browser.answer(probe, password="wrong")
    elif fault == "path":
        assert not browser.answer(probe, THERE)
    elif fault == "transaction":
        assert not browser.answer(Message(Method.BINDING, Class.REQUEST))
    else:
        refusal = Message(Method.BINDING, Class.ERROR, probe.transaction_id)
        refusal.attributes["ERROR-CODE"] = (487, "Role Conflict")
        refusal.add_message_integrity(b"secret")
        assert not browser.agent.handle_response(parse_message(bytes(refusal)), HERE, 0.0)
    assert browser.agent.selected is None


def test_a_lost_check_is_retransmitted(browser: Browser) -> None:
    """A retransmitted check keeps its transaction, so that either answer counts."""
    _, probe = browser.check(nominates=True)
    assert browser.agent.tick(0.05) == []
    (again,) = browser.agent.tick(0.11)
    assert parse_message(again.data).transaction_id == probe.transaction_id
    assert browser.answer(probe, now_s=0.2)
    assert browser.agent.tick(5.0) == []


def test_a_rebound_nat_port_takes_over(browser: Browser) -> None:
    """A browser that checks from a new port, given by its router, is followed there."""
    browser.verify()
    browser.agent.note_datagram(HERE, 10.0)
    browser.verify(THERE, 11.0, nominates=False)
    assert browser.agent.selected == HERE
    browser.check(THERE, 12.1)
    assert browser.agent.selected == THERE


def probes(datagrams: list[Datagram]) -> list[Message]:
    return [parse_message(one.data) for one in datagrams]


def test_authenticated_data_from_a_new_address_is_checked_and_followed(browser: Browser) -> None:
    """Authenticated data from a new address has it checked at once, and used once it answers."""
    browser.verify()
    assert not browser.agent.is_quiet(0.2)
    assert browser.agent.is_quiet(0.3)
    (probe,) = probes(browser.agent.note_authenticated(THERE, 0.3))
    assert probe.check_message_integrity(b"secret")
    assert browser.agent.note_authenticated(THERE, 0.31) == []
    assert browser.agent.selected == HERE
    assert not browser.agent.note_datagram(THERE, 0.32)
    assert browser.answer(probe, THERE, 0.35)
    assert browser.agent.selected == THERE


def test_a_browser_back_at_a_verified_address_is_followed(browser: Browser) -> None:
    """A browser back at a verified address is followed, unless its data was still in flight."""
    browser.verify(HERE)
    browser.verify(THERE, 1.0)
    browser.agent.note_datagram(HERE, 1.1)
    assert browser.agent.note_authenticated(HERE, 1.1) == []
    assert browser.agent.selected == THERE
    browser.agent.note_datagram(HERE, 1.5)
    assert browser.agent.note_authenticated(HERE, 1.5) == []
    assert browser.agent.selected == HERE


def test_data_with_forged_addresses_draws_few_checks(browser: Browser) -> None:
    """Data re-sent from many forged addresses draws few checks."""
    browser.verify()
    sent = 0
    for number in range(100):
        path = Path(0, f"203.0.113.{number}", 53)
        sent += len(browser.agent.note_authenticated(path, number / 100))
    assert sent <= 8 + 4 + 1
    assert browser.agent.selected == HERE


def test_the_number_of_paths_is_bounded(browser: Browser) -> None:
    """The number of paths is bounded, and the selected one is never dropped for a new one."""
    browser.verify()
    for number in range(50):
        browser.verify(Path(0, "192.0.2.9", number + 1), number * 2.0, nominates=False)
        browser.check(HERE, number * 2.0)
    assert browser.agent.selected == HERE
    assert (
        sum(browser.agent.note_datagram(Path(0, "192.0.2.9", n + 1), 100.0) for n in range(50))
        < MAX_PATHS
    )


def test_consent_expires(browser: Browser) -> None:
    """Consent expires after half a minute without a check (RFC 7675), despite other datagrams."""
    browser.verify()
    browser.agent.note_datagram(HERE, 29.0)
    assert not browser.agent.is_lost(30.0)
    assert browser.agent.is_lost(30.1)
    browser.check(HERE, 30.1)
    assert not browser.agent.is_lost(60.0)


def test_an_abandoned_address_loses_consent(browser: Browser) -> None:
    """Checks from elsewhere that answer none of ours do not keep video going to the old address."""
    browser.verify()
    for second in range(1, 31):
        browser.check(THERE, float(second), nominates=True)
        browser.agent.tick(float(second))
    assert browser.agent.selected == HERE
    assert browser.agent.is_lost(30.1)
    browser.check(HERE, 30.2)
    assert browser.agent.is_lost(30.3), "it must answer again, too"


@examples(200)
@given(st.data())
def test_only_verified_addresses_are_selected(data: st.DataObject) -> None:
    """No input, in any order, selects an address that has not answered a check."""
    browser = Browser()
    now_s = 0.0
    verified: set[Path] = set()
    open_probes: dict[Path, Message] = {}
    paths = [Path(0, "192.0.2.7", port) for port in range(1, 13)]
    for _ in range(data.draw(st.integers(1, 40))):
        now_s += data.draw(st.floats(0, 3))
        path = data.draw(st.sampled_from(paths))
        match data.draw(st.sampled_from(["check", "nominate", "answer", "forge", "speak", "tick"])):
            case "answer" if path in open_probes:
                if browser.answer(open_probes[path], path, now_s):
                    verified.add(path)
            case "forge" if path in open_probes:
                assert not browser.answer(open_probes[path], path, now_s, password="wrong")
            case "speak":
                for one in probes(browser.agent.note_authenticated(path, now_s)):
                    open_probes[path] = one
            case "tick":
                browser.agent.tick(now_s)
            case what:
                for one in browser.check(path, now_s, nominates=what == "nominate"):
                    if one.message_class == Class.REQUEST:
                        open_probes[path] = one
        assert browser.agent.selected is None or browser.agent.selected in verified
        assert all(path in verified for path in paths if browser.agent.note_datagram(path, now_s))
