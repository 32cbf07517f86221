"""Nothing but short answers goes to an address that has not answered a check of ours."""

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
    """The other end, which knows both ends' credentials."""

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
        """Send a check by a path; returns what comes back by it."""
        request = Message(Method.BINDING, Class.REQUEST)
        request.attributes["USERNAME"] = username or f"{self.agent.username}:browser"
        request.attributes["PRIORITY"] = 1
        if nominates:
            request.attributes["USE-CANDIDATE"] = None
        request.add_message_integrity((password or self.agent.password).encode())
        sent = self.agent.requested(parse_message(bytes(request)), path, now_s)
        assert all(one.path == path for one in sent)
        return [parse_message(one.data) for one in sent]

    def answer(
        self, probe: Message, path: Path = HERE, now_s: float = 0.0, *, password: str = "secret"
    ) -> bool:
        """Answer a check of the agent's by a path."""
        answer = Message(Method.BINDING, Class.RESPONSE, probe.transaction_id)
        answer.attributes["XOR-MAPPED-ADDRESS"] = ("192.0.2.1", 8081)
        answer.add_message_integrity(password.encode())
        return self.agent.answered(parse_message(bytes(answer)), path, now_s)

    def verify(self, path: Path = HERE, now_s: float = 0.0, *, nominates: bool = True) -> None:
        _, probe = self.check(path, now_s, nominates=nominates)
        assert self.answer(probe, path, now_s)


@pytest.fixture
def browser() -> Browser:
    return Browser()


def test_a_check_is_answered_and_checked(browser: Browser) -> None:
    """The answer says where it came from and is signed; so is our own check."""
    answer, probe = browser.check()
    assert answer.message_class == Class.RESPONSE
    assert answer.attributes["XOR-MAPPED-ADDRESS"] == (HERE.host, HERE.port)
    assert answer.check_message_integrity(browser.agent.password.encode())
    assert probe.attributes["USERNAME"] == f"browser:{browser.agent.username}"
    assert probe.check_message_integrity(b"secret")
    assert browser.agent.selected is None
    assert not browser.agent.heard(HERE, 0.0)


def test_an_address_that_answers_is_accepted(browser: Browser) -> None:
    """Nominated, it is where everything is sent."""
    browser.verify()
    assert browser.agent.heard(HERE, 0.0)
    assert browser.agent.selected == HERE


def test_the_nomination_may_come_later(browser: Browser) -> None:
    """The first address that answers is used until the browser has chosen."""
    browser.verify(HERE, nominates=False)
    assert browser.agent.selected == HERE
    browser.verify(THERE, 0.1, nominates=False)
    assert browser.agent.selected == HERE
    browser.check(THERE, 0.2, nominates=True)
    assert browser.agent.selected == THERE


def test_a_strangers_address_gets_nothing_but_answers(browser: Browser) -> None:
    """A viewer writes somebody else's address on a check: a few short datagrams, and no video."""
    browser.verify()
    sent = len(browser.check(STRANGER, nominates=True))
    now_s = 0.0
    while now_s < 10:
        now_s += 0.05
        sent += len(browser.agent.tick(now_s))
    assert browser.agent.selected == HERE
    assert sent <= 1 + 5
    assert not browser.agent.is_asking


def test_many_strangers_addresses_share_a_budget(browser: Browser) -> None:
    """A hundred of them in a second draw a dozen checks of ours."""
    probes = 0
    for number in range(100):
        path = Path(0, f"203.0.113.{number}", 53)
        probes += len(browser.check(path, number / 100)) - 1
    assert probes <= 8 + 4 + 1


@pytest.mark.parametrize("username", ["other:browser", "x", "", ":"])
def test_what_is_not_signed_for_us_gets_no_answer(browser: Browser, username: str) -> None:
    """Neither a guess nor another peer's check."""
    assert browser.check(password="wrong") == []
    assert browser.check(username=username or ":browser") == []


def test_before_the_offer_is_known_nothing_is_answered() -> None:
    """There is no password yet to check with."""
    browser = Browser()
    browser.agent.remote_username = None
    assert browser.check() == []


@pytest.mark.parametrize("fault", ["password", "path", "transaction", "error"])
def test_a_forged_answer_verifies_nothing(browser: Browser, fault: str) -> None:
    """Wrongly signed, from elsewhere, to another check, or a refusal."""
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
        assert not browser.agent.answered(parse_message(bytes(refusal)), HERE, 0.0)
    assert browser.agent.selected is None


def test_a_lost_check_is_sent_again(browser: Browser) -> None:
    """The same transaction, so that an answer to either counts."""
    _, probe = browser.check(nominates=True)
    assert browser.agent.tick(0.05) == []
    (again,) = browser.agent.tick(0.11)
    assert parse_message(again.data).transaction_id == probe.transaction_id
    assert browser.answer(probe, now_s=0.2)
    assert browser.agent.tick(5.0) == []


def test_a_rebound_address_takes_over(browser: Browser) -> None:
    """A router gives the browser another port; the browser only goes on checking."""
    browser.verify()
    browser.agent.heard(HERE, 10.0)
    browser.verify(THERE, 11.0, nominates=False)
    assert browser.agent.selected == HERE
    browser.check(THERE, 12.1)
    assert browser.agent.selected == THERE


def probes(datagrams: list[Datagram]) -> list[Message]:
    return [parse_message(one.data) for one in datagrams]


def test_a_browser_that_goes_on_elsewhere_is_checked_and_followed(browser: Browser) -> None:
    """It encrypts from another address: that is checked at once, and used once it has answered."""
    browser.verify()
    assert not browser.agent.is_quiet(0.2)
    assert browser.agent.is_quiet(0.3)
    (probe,) = probes(browser.agent.spoke(THERE, 0.3))
    assert probe.check_message_integrity(b"secret")
    assert browser.agent.spoke(THERE, 0.31) == []
    assert browser.agent.selected == HERE
    assert not browser.agent.heard(THERE, 0.32)
    assert browser.answer(probe, THERE, 0.35)
    assert browser.agent.selected == THERE


def test_a_browser_that_comes_back_is_followed_at_once(browser: Browser) -> None:
    """Its earlier address has been checked; but what was under way from there moves nothing."""
    browser.verify(HERE)
    browser.verify(THERE, 1.0)
    browser.agent.heard(HERE, 1.1)
    assert browser.agent.spoke(HERE, 1.1) == []
    assert browser.agent.selected == THERE
    browser.agent.heard(HERE, 1.5)
    assert browser.agent.spoke(HERE, 1.5) == []
    assert browser.agent.selected == HERE


def test_what_is_sent_on_from_elsewhere_draws_few_checks(browser: Browser) -> None:
    """Somebody on the way writes strangers' addresses on all that the browser sends."""
    browser.verify()
    sent = 0
    for number in range(100):
        path = Path(0, f"203.0.113.{number}", 53)
        sent += len(browser.agent.spoke(path, number / 100))
    assert sent <= 8 + 4 + 1
    assert browser.agent.selected == HERE


def test_paths_are_few(browser: Browser) -> None:
    """The one in use is never given up for a new one."""
    browser.verify()
    for number in range(50):
        browser.verify(Path(0, "192.0.2.9", number + 1), number * 2.0, nominates=False)
        browser.check(HERE, number * 2.0)
    assert browser.agent.selected == HERE
    assert (
        sum(browser.agent.heard(Path(0, "192.0.2.9", n + 1), 100.0) for n in range(50)) < MAX_PATHS
    )


def test_consent_ends(browser: Browser) -> None:
    """Half a minute without a check; datagrams alone do not count (RFC 7675)."""
    browser.verify()
    browser.agent.heard(HERE, 29.0)
    assert not browser.agent.is_lost(30.0)
    assert browser.agent.is_lost(30.1)
    browser.check(HERE, 30.1)
    assert not browser.agent.is_lost(60.0)


def test_nobody_consents_for_an_address_that_they_have_left(browser: Browser) -> None:
    """Checks from elsewhere that answer none of ours do not keep video going to the old one."""
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
def test_nothing_is_selected_that_has_not_answered(data: st.DataObject) -> None:
    """Whatever comes by whatever path, in any order."""
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
                for one in probes(browser.agent.spoke(path, now_s)):
                    open_probes[path] = one
            case "tick":
                browser.agent.tick(now_s)
            case what:
                for one in browser.check(path, now_s, nominates=what == "nominate"):
                    if one.message_class == Class.REQUEST:
                        open_probes[path] = one
        assert browser.agent.selected is None or browser.agent.selected in verified
        assert all(path in verified for path in paths if browser.agent.heard(path, now_s))
