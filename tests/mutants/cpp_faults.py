"""The same faults in C++, token by token; the compiler rejects those that are no programs.

It also shows which are no faults: a mutant with the same machine code is none.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tests.mutants.mutant import splice

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.mutants.mutant import Mutant

_TOKEN: Final = re.compile(
    r"""(?P<skip>\s+|\w+_cast<[\w\s]+>|//[^\n]*|/\*.*?\*/|^\#[^\n]*|"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*')
      | (?P<number>0[xX][0-9a-fA-F]+[uUlL]*|\d+[uUlL]*)
      | (?P<word>[A-Za-z_]\w*)
      | (?P<sign><<=|>>=|<<|>>|<=|>=|==|!=|&&|\|\||\+\+|--|\+=|-=|\*=|/=|&=|\|=|\^=|->|::|.)""",
    re.VERBOSE | re.DOTALL | re.MULTILINE,
)
_OTHER_SIGNS: Final[dict[str, tuple[str, ...]]] = {
    "<": ("<=", ">="),
    "<=": ("<", ">"),
    ">": (">=", "<="),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
    "&&": ("||",),
    "||": ("&&",),
    "+": ("-",),
    "-": ("+",),
    "*": ("/",),
    "/": ("*",),
    "&": ("|",),
    "|": ("&",),
    "^": ("&",),
    "<<": (">>",),
    ">>": ("<<",),
    "++": ("--",),
    "--": ("++",),
    "+=": ("-=",),
    "-=": ("+=",),
    "!": ("",),
}
_OTHER_WORDS: Final = {"true": "false", "false": "true", "least": "most", "most": "least"}
_CONDITIONAL: Final = {"if", "while"}
_FUNCTION: Final = re.compile(
    r"^ {0,4}(?!(?:if|for|while|switch|else|return)\b)[\w~][^\n;=]*?([\w~]+)\([^\n;]*(?:\{|:|,)",
    re.MULTILINE,
)


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    start: int

    @property
    def end(self) -> int:
        return self.start + len(self.text)


def faults(file: str, source: str) -> list[Mutant]:
    """Return every mutant of a source, in the order of its lines, whether it compiles or not."""
    tokens = [
        _Token(match.lastgroup or "", match.group(), match.start())
        for match in _TOKEN.finditer(source)
        if match.lastgroup != "skip"
    ]
    changes = sorted({*_of_tokens(tokens), *_of_conditions(tokens), *_of_statements(tokens)})
    return [
        splice(file, source, _within(source, start), (start, end), new)
        for start, end, new in changes
    ]


Change = tuple[int, int, str]


def _of_tokens(tokens: list[_Token]) -> Iterator[Change]:
    for token in tokens:
        if token.kind == "number":
            yield token.start, token.end, _one_more(token.text)
        elif token.text in _OTHER_WORDS:
            yield token.start, token.end, _OTHER_WORDS[token.text]
        else:
            for other in _OTHER_SIGNS.get(token.text, ()):
                yield token.start, token.end, other


def _of_conditions(tokens: list[_Token]) -> Iterator[Change]:
    """Negate each condition, and leave out each of its parts."""
    for at, token in enumerate(tokens):
        if token.text in _CONDITIONAL:
            end = _closing(tokens, at + 1)
            yield tokens[at + 1].end, tokens[end].start, "false"
            yield tokens[at + 1].end, tokens[end].start, "true"
        elif token.text in {"&&", "||"}:
            yield from _without_a_side(tokens, at)


def _without_a_side(tokens: list[_Token], at: int) -> Iterator[Change]:
    neutral = "true" if tokens[at].text == "&&" else "false"
    left, right = at, at
    depth = 0
    while left > 0:
        text = tokens[left - 1].text
        depth += (text == ")") - (text == "(")
        if depth < 0 or (not depth and text in {"&&", "||", "=", "return", "?", ";"}):
            break
        left -= 1
    depth = 0
    while right + 1 < len(tokens):
        text = tokens[right + 1].text
        depth += (text == "(") - (text == ")")
        if depth < 0 or (not depth and text in {"&&", "||", "?", ";"}):
            break
        right += 1
    yield tokens[left].start, tokens[at - 1].end, neutral
    yield tokens[at + 1].start, tokens[right].end, neutral


def _of_statements(tokens: list[_Token]) -> Iterator[Change]:
    """Leave out each statement, and replace each result by the least one."""
    begin, depth = 0, 0
    for at, token in enumerate(tokens):
        depth += (token.text == "(") - (token.text == ")")
        if depth or token.text not in {";", "{", "}", ":"}:
            continue
        if token.text == ";":
            first = _after_heads(tokens, begin, at)
            if first < at:
                yield tokens[first].start, tokens[at - 1].end, ""
                if tokens[first].text == "return" and first + 1 < at:
                    yield tokens[first + 1].start, tokens[at - 1].end, "{}"
        begin = at + 1 if token.text != ":" or _is_label(tokens, begin) else begin


def _after_heads(tokens: list[_Token], begin: int, end: int) -> int:
    """Skip `if (…)` and `else` before a statement without braces."""
    while begin < end:
        if tokens[begin].text in {"if", "while", "for"}:
            begin = _closing(tokens, begin + 1) + 1
        elif tokens[begin].text == "else":
            begin += 1
        else:
            break
    return begin


def _is_label(tokens: list[_Token], begin: int) -> bool:
    return tokens[begin].text in {"case", "default", "public", "private"}


def _closing(tokens: list[_Token], opening: int) -> int:
    depth = 0
    for at in range(opening, len(tokens)):
        depth += (tokens[at].text == "(") - (tokens[at].text == ")")
        if depth == 0:
            return at
    raise ValueError("a parenthesis is not closed")


def _one_more(number: str) -> str:
    digits = number.rstrip("uUlL")
    more = int(digits, 0) + 1
    text = f"0x{more:X}" if digits.lower().startswith("0x") else str(more)
    return text + number[len(digits) :]


def _within(source: str, at: int) -> str:
    """Return the name of the last function defined before a place."""
    found = ""
    for match in _FUNCTION.finditer(source):
        if match.start() > at:
            break
        found = match.group(1)
    return found
