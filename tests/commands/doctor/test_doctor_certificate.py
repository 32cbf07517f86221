"""Certificates: missing or not, their names, validity and keys."""

from __future__ import annotations

import datetime
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest
from tests.commands.doctor.certificates import NOW, write_pair

from wax.commands.doctor.certificate import certificate
from wax.web.certificate import Certificate

if TYPE_CHECKING:
    from pathlib import Path

    from tests.commands.doctor.conftest import MakeNetwork


@pytest.mark.parametrize(
    ("days", "level", "says"),
    [
        ((-1, 15), "ok", "valid until 2030-06-16"),
        ((-1, 13), "warning", "soon"),
        ((-9, -1), "bad", "ended on 2030-05-31"),
        ((1, 9), "bad", "valid from 2030-06-02"),
    ],
)
def test_its_time_is_told(
    network: MakeNetwork,
    tmp_path: Path,
    days: tuple[int, int],
    level: str,
    says: str,
) -> None:
    """A certificate is valid, near its end, expired, or not yet valid."""
    begins, ends = (NOW + datetime.timedelta(days=day) for day in days)
    pair = write_pair(tmp_path, "robot.example.org", begins=begins, ends=ends)
    verdict = certificate(network(certificate=pair), NOW)
    assert (verdict.level, says in verdict.sentence) == (level, True), verdict


@pytest.mark.parametrize(
    ("has", "needs", "level"),
    [
        (["robot.example.org"], ["Robot.Example.org."], "ok"),
        (["*.example.org"], ["robot.example.org"], "ok"),
        (["*.example.org"], ["a.robot.example.org"], "bad"),
        (["*.example.org"], ["example.org"], "bad"),
        (["robot.example.org", "192.0.2.7"], ["192.0.2.7", "robot.example.org"], "ok"),
        (["robot.example.org"], ["robot.example.org", "robot.example.com"], "bad"),
        ([], ["robot.example.org"], "bad"),
        ([], [], "ok"),
    ],
)
def test_it_must_be_for_every_name(
    network: MakeNetwork, tmp_path: Path, has: list[str], needs: list[str], level: str
) -> None:
    """Names are compared as browsers do, and a missing one is named."""
    ours = network(certificate=write_pair(tmp_path, *has), names=tuple(needs))
    verdict = certificate(ours, NOW)
    assert verdict.level == level, verdict
    if level == "bad":
        assert needs[-1] in verdict.sentence


def test_a_pair_that_is_none_is_told(network: MakeNetwork, tmp_path: Path) -> None:
    """A wrong key, an invalid file and a missing file are bad."""
    (tmp_path / "other").mkdir()
    pair, other = write_pair(tmp_path, "a"), write_pair(tmp_path / "other", "a")
    junk = tmp_path / "junk.pem"
    junk.write_text("junk")
    wrong = ({"key": other.key}, {"chain": junk}, {"key": tmp_path / "none.pem"})
    for change in wrong:
        verdict = certificate(network(certificate=replace(pair, **change)), NOW)
        assert verdict.level == "bad", verdict
    assert "none.pem" in verdict.sentence


@pytest.mark.parametrize(("host", "level"), [("0.0.0.0", "warning"), ("localhost", "ok")])
def test_plain_http_is_for_this_machine(network: MakeNetwork, host: str, level: str) -> None:
    """Without a certificate, only a page on loopback is ok."""
    assert certificate(network(host=host), NOW).level == level


def test_a_certificate_of_our_own_is_told(network: MakeNetwork, tmp_path: Path) -> None:
    """A self-signed certificate is created at the first start, and is then a warning."""
    pair = Certificate(tmp_path / "chain.pem", tmp_path / "key.pem")
    ours = network(certificate=pair, is_self_signed=True, names=("robot.example.org",))
    assert "first start" in certificate(ours, NOW).sentence
    write_pair(tmp_path, "pi.local")
    verdict = certificate(ours, NOW)
    assert (verdict.level, "self-signed" in verdict.sentence) == ("warning", True)


@pytest.mark.parametrize(("is_self_signed", "advice"), [(False, "Renew"), (True, "Start")])
def test_whoever_has_made_it_renews_it(
    network: MakeNetwork, tmp_path: Path, is_self_signed: bool, advice: str
) -> None:
    """The advice is to renew one's own certificate; the server renews a self-signed one."""
    begins, ends = NOW - datetime.timedelta(days=9), NOW - datetime.timedelta(days=1)
    pair = write_pair(tmp_path, "robot.example.org", begins=begins, ends=ends)
    verdict = certificate(network(certificate=pair, is_self_signed=is_self_signed), NOW)
    assert verdict.advice.split()[0] == advice


def test_a_certificate_of_our_own_needs_a_folder(network: MakeNetwork) -> None:
    """Without a home directory, the advice names the key to set."""
    verdict = certificate(network(certificate=None, is_self_signed=True), NOW)
    assert (verdict.level, "state_dir" in verdict.advice) == ("bad", True)


def test_a_proxy_has_a_certificate_of_its_own(network: MakeNetwork) -> None:
    """Plain HTTP to a proxy on this machine is ok."""
    assert certificate(network(host="localhost", is_behind_proxy=True), NOW).level == "ok"
