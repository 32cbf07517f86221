"""Which faults are inserted, and that the tool distinguishes good tests from bad ones."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

import pytest
from tests.mutants import cpp_faults, python_faults, survivors
from tests.mutants.plan import ROOT, TARGETS
from tests.mutants.record import KILLED, NEVER_ENDED, SURVIVED, Outcome, Record, to_table

if TYPE_CHECKING:
    from pathlib import Path

    from tests.mutants.mutant import Mutant

pytestmark = pytest.mark.full

PYTHON = '''\
"""Text is left alone."""

LIMIT = 3


def within(a: int, b: bool) -> int:
    if a <= LIMIT and not b:
        return min(a, 7)
    note(a=a)
    return -a
'''
CPP = """\
// a < b is no code here
const int LIMIT = 0x10;
int within(int a, bool b) {
    if (a <= LIMIT && !b) return a + 1;
    ++count;
    return static_cast<int>(a);
}
"""


def changes(mutants: list[Mutant]) -> set[str]:
    return {f"{one.line} {one.within}: {one.after}" for one in mutants}


def test_faults_in_python() -> None:
    """Each kind of fault is inserted where it can be, and every mutant is a different program."""
    found = python_faults.faults("x.py", PYTHON)
    assert changes(found) == {
        "3 : LIMIT = (4)",
        "7 within: if (not (a <= LIMIT and (not b))):",
        "7 within: if (a <= LIMIT or not b):",
        "7 within: if (not b):",
        "7 within: if (a <= LIMIT):",
        "7 within: if (a < LIMIT) and not b:",
        "7 within: if (a > LIMIT) and not b:",
        "7 within: if a <= LIMIT and (b):",
        "8 within: return None",
        "8 within: pass",
        "8 within: return (max(a, 7))",
        "8 within: return min(a, (8))",
        "9 within: pass",
        "9 within: (note())",
        "10 within: return None",
        "10 within: return (a)",
    }
    assert len({one.source for one in found}) == len(found)
    for one in found:
        compile(one.source, one.file, "exec")


def test_faults_in_cpp() -> None:
    """The same kinds of fault, token by token; comments and casts are left alone."""
    found = cpp_faults.faults("x.cpp", CPP)
    texts = changes(found)
    assert texts >= {
        "2 : const int LIMIT = 0x11;",
        "4 within: if (false) return a + 1;",
        "4 within: if (true) return a + 1;",
        "4 within: if (true && !b) return a + 1;",
        "4 within: if (a <= LIMIT && true) return a + 1;",
        "4 within: if (a <= LIMIT || !b) return a + 1;",
        "4 within: if (a < LIMIT && !b) return a + 1;",
        "4 within: if (a <= LIMIT && b) return a + 1;",
        "4 within: if (a <= LIMIT && !b) return a - 1;",
        "4 within: if (a <= LIMIT && !b) return {};",
        "4 within: if (a <= LIMIT && !b) ;",
        "5 within: ;",
        "5 within: --count;",
    }
    assert not any(text.startswith("1") or "static_cast<=" in text for text in texts)


def test_every_target_is_there() -> None:
    """The plan names files and tests that exist."""
    for target in TARGETS:
        for name in (target.file, *target.tests):
            assert (ROOT / name.partition("::")[0]).is_file(), name


def outcome(number: int, outcome: str) -> Outcome:
    return Outcome("x.py", number, "f", f"a{number}", "b", outcome, 0.1, str(number), "e")


def test_the_list_of_survivors_is_exact() -> None:
    """A survivor without a reason is reported, and so is a reason without a survivor."""
    outcomes = [outcome(1, SURVIVED), outcome(2, SURVIVED), outcome(3, KILLED)]
    listed = [survivors.Survivor("x.py", "f", f"a{n}", "b", "Why.") for n in (1, 3)]
    listed.append(survivors.Survivor("other.py", "f", "a1", "b", "Not tested here."))
    survived = outcomes[:2]
    assert survivors.unlisted(survived, listed) == [outcomes[1]]
    assert survivors.outdated(outcomes, survived, listed) == ["x.py (f): a3 → b"]


def test_a_condition_that_calls_is_no_function() -> None:
    """A fault after such a condition is named by the function that contains it."""
    source = "int f(int a) {\n    if (g(a)) {\n        a = 1;\n    }\n    return a < 2;\n}\n"
    assert {one.within for one in cpp_faults.faults("x.cpp", source)} == {"f"}


def test_a_file_that_is_not_there_is_told() -> None:
    """A name that matches nothing tests nothing, and says so."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.mutants", "--only", "no_such_file"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "no file has no_such_file in its path" in done.stderr


def test_a_survivor_needs_a_reason(tmp_path: Path) -> None:
    """An entry without a reason is refused."""
    entry = '[[survivor]]\nfile = "x"\nwithin = "f"\nline = "a"\nbecomes = "b"\nreason = "{}"\n'
    path = tmp_path / "list.toml"
    path.write_text(entry.format("Why."))
    assert survivors.read(path)[0].name == ("x", "f", "a", "b")
    path.write_text(entry.format(" "))
    with pytest.raises(ValueError, match="without a reason"):
        survivors.read(path)
    path.write_text(entry.format("Why.") * 2)
    with pytest.raises(ValueError, match="twice"):
        survivors.read(path)


def test_the_share_counts_all_that_is_a_fault() -> None:
    """A mutant that never ends was caught; a survivor counts against the share, listed or not."""
    outcomes = [outcome(1, KILLED), outcome(2, NEVER_ENDED), outcome(3, SURVIVED)]
    assert to_table(outcomes).splitlines()[-1].split() == ["all", "3", "2", "1", "66.7%"]


def test_what_is_on_record_counts_while_all_is_the_same(tmp_path: Path) -> None:
    """Changed tests make an old outcome void; a kill may be trusted on demand, a survivor never."""
    path = tmp_path / "record.jsonl"
    killed, survived = python_faults.faults("x.py", "A = 1\nB = 2\n")
    record = Record(path, trusts_kills=False)
    record.add(killed, KILLED, 0.1, "tests")
    record.add(survived, SURVIVED, 0.1, "tests")
    for trusts_kills, evidence, expected in (
        (False, "tests", [KILLED, SURVIVED]),
        (False, "more tests", [None, None]),
        (True, "more tests", [KILLED, None]),
    ):
        again = Record(path, trusts_kills=trusts_kills)
        found = [again.find(one, evidence) for one in (killed, survived)]
        assert [one and one.outcome for one in found] == expected


def test_a_small_module_from_end_to_end(tmp_path: Path) -> None:
    """The faults of the smallest target are all caught, and nothing in the tree has changed."""
    target = ROOT / "server/wax/control/stopping_distance.py"
    before = target.read_bytes()
    record = tmp_path / "record.jsonl"
    done = subprocess.run(
        [sys.executable, "-m", "tests.mutants", "--only", target.stem, "--record", str(record)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "100.0%" in done.stdout
    assert len(record.read_text().splitlines()) > 10
    assert target.read_bytes() == before
