"""Faults in Python: each comparison, boundary, sum, condition, constant, result and statement.

Text is left alone: the words of a sentence are no decision. So are decorators, annotations and code
for the type checker only. A mutant that compiles to the same code is none.
"""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING, Final

from tests.mutants.mutant import splice

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.mutants.mutant import Mutant

_COMPARISONS: Final[dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
_ARITHMETIC: Final[dict[type[ast.operator], type[ast.operator]]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitAnd,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.Pow: ast.Mult,
}
_TWINS: Final = {"min": "max", "max": "min", "any": "all", "all": "any"}
_TWINS_OF_MATH: Final = {"floor": "ceil", "ceil": "floor"}
_FUNCTIONS: Final = (ast.FunctionDef, ast.AsyncFunctionDef)
_DELETABLE: Final = (
    ast.Assign,
    ast.AugAssign,
    ast.AnnAssign,
    ast.Raise,
    ast.Continue,
    ast.Break,
    ast.Delete,
    ast.Return,
)


def faults(file: str, source: str) -> list[Mutant]:
    """Return every mutant of a module, in the order of its lines, without duplicates."""
    plain = _code(source)
    found = {mutant.source: mutant for mutant in _Faults(file, source).all()}
    return sorted(
        (mutant for mutant in found.values() if _code(mutant.source) != plain),
        key=lambda mutant: mutant.line,
    )


def _code(source: str) -> bytes:
    """Return all that the interpreter sees, without line numbers."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.AnnAssign | ast.arg):
            node.annotation = ast.Constant(None) if isinstance(node, ast.AnnAssign) else None
    return ast.dump(tree).encode()


class _Faults:
    def __init__(self, file: str, source: str) -> None:
        self._file = file
        self._source = source
        lines = source.encode().split(b"\n")
        self._line_starts = [0]
        for line in lines:
            self._line_starts.append(self._line_starts[-1] + len(line) + 1)
        self._bytes = source.encode()
        self._in_function: set[int] = set()
        self._ends: set[int] = set()

    def all(self) -> Iterator[Mutant]:
        tree = ast.parse(self._source)
        for node in ast.walk(tree):
            if isinstance(node, _FUNCTIONS):
                self._in_function.update(map(id, ast.walk(node)))
                self._ends.add(id(node.body[-1]))
        yield from self._in(tree, "")

    def _in(self, node: ast.AST, within: str) -> Iterator[Mutant]:
        for new, old in self._changes(node):
            yield self._mutant(old, new, within)
        if isinstance(node, (*_FUNCTIONS, ast.ClassDef)):
            within = f"{within}.{node.name}".removeprefix(".")
        for child in self._children(node):
            yield from self._in(child, within)

    def _children(self, node: ast.AST) -> Iterator[ast.AST]:
        """Yield the nodes below a node that may be mutated."""
        skipped: list[ast.AST | None] = []
        if isinstance(node, _FUNCTIONS):
            skipped = [*node.decorator_list, node.returns]
        elif isinstance(node, ast.ClassDef):
            skipped = [*node.decorator_list]
        elif isinstance(node, ast.AnnAssign | ast.arg):
            skipped = [node.annotation]
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            skipped = [node.test, *node.body]
        elif isinstance(node, ast.JoinedStr):
            skipped = [*node.values]
        for child in ast.iter_child_nodes(node):
            if not any(child is one for one in skipped):
                yield child

    def _mutant(self, old: ast.AST, new: str, within: str) -> Mutant:
        start, end = (len(self._bytes[:at].decode()) for at in self._span(old))
        return splice(self._file, self._source, within, (start, end), new)

    def _span(self, node: ast.AST) -> tuple[int, int]:
        """Return the bytes of a node."""
        assert isinstance(node, ast.expr | ast.stmt | ast.keyword)
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return (
            self._line_starts[node.lineno - 1] + node.col_offset,
            self._line_starts[node.end_lineno - 1] + node.end_col_offset,
        )

    def _changes(self, node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
        """Yield the replacements of a node: the new text, and the node that it replaces."""
        if isinstance(node, ast.expr):
            for text in _expressions(node):
                yield f"({text})" if text else text, node
        if isinstance(node, ast.If | ast.IfExp | ast.While) and not _is_for_types(node):
            yield f"(not ({ast.unparse(node.test)}))", node.test
        if isinstance(node, ast.Return) and not _is_true_or_false(node.value):
            yield "return None", node
        if isinstance(node, ast.AugAssign) and type(node.op) in _ARITHMETIC:
            other = ast.AugAssign(node.target, _ARITHMETIC[type(node.op)](), node.value)
            yield ast.unparse(other), node
        # A result at the end of its function has been left out above.
        is_result = isinstance(node, ast.Return) and id(node) in self._ends
        if id(node) in self._in_function and _is_deletable(node) and not is_result:
            yield "pass", node


def _expressions(node: ast.expr) -> Iterator[str]:
    match node:
        case ast.Compare():
            yield from _comparisons(node)
        case ast.BoolOp():
            yield from _conditions(node)
        case ast.UnaryOp(op=ast.Not() | ast.USub() | ast.Invert()):
            yield ast.unparse(node.operand)
        case ast.BinOp() if type(node.op) in _ARITHMETIC and not _is_union(node):
            yield ast.unparse(ast.BinOp(node.left, _ARITHMETIC[type(node.op)](), node.right))
        case ast.Constant(value=bool(value)):
            yield str(not value)
        case ast.Constant(value=int(value) | float(value)):
            yield repr(value + 1)
        case ast.Call():
            yield from _calls(node)


def _comparisons(node: ast.Compare) -> Iterator[str]:
    for at, operator in enumerate(node.ops):
        for other in _COMPARISONS[type(operator)]:
            ops = [*node.ops[:at], other(), *node.ops[at + 1 :]]
            yield ast.unparse(ast.Compare(node.left, ops, node.comparators))


def _conditions(node: ast.BoolOp) -> Iterator[str]:
    """Exchange `and` and `or`, and leave out each part."""
    swapped = ast.Or() if isinstance(node.op, ast.And) else ast.And()
    yield ast.unparse(ast.BoolOp(swapped, node.values))
    for at in range(len(node.values)):
        rest = [*node.values[:at], *node.values[at + 1 :]]
        yield ast.unparse(rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest))


def _calls(node: ast.Call) -> Iterator[str]:
    match node.func:
        case ast.Name(id=name) if name in _TWINS:
            yield ast.unparse(ast.Call(ast.Name(_TWINS[name]), node.args, node.keywords))
        case ast.Attribute(value=ast.Name(id="math"), attr=name) if name in _TWINS_OF_MATH:
            func = ast.Attribute(ast.Name("math"), _TWINS_OF_MATH[name])
            yield ast.unparse(ast.Call(func, node.args, node.keywords))
    for keyword in node.keywords:
        rest = [one for one in node.keywords if one is not keyword]
        yield ast.unparse(ast.Call(node.func, node.args, rest))


def _is_for_types(node: ast.If | ast.IfExp | ast.While) -> bool:
    return ast.unparse(node.test) == "TYPE_CHECKING"


def _is_deletable(node: ast.AST) -> bool:
    match node:
        case ast.Expr(value=ast.Call() | ast.Await()):
            return True
        case ast.AnnAssign(value=None):
            return False
    return isinstance(node, _DELETABLE)


def _is_true_or_false(node: ast.expr | None) -> bool:
    """Return whether None would mean the same as this expression, or as its opposite."""
    return node is None or (isinstance(node, ast.Constant) and isinstance(node.value, bool))


def _is_union(node: ast.expr) -> bool:
    """Return whether it is a union of types, `A | B`, and not a computation."""
    match node:
        case ast.BinOp(op=ast.BitOr()):
            return _is_union(node.left) and _is_union(node.right)
        case ast.Name(id=name):
            return name[0].isupper() and not name.isupper()
    return False
