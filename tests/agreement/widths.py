"""A check of the kernels' sources: integers of less than 64 bits are widened before they are computed with.

numba computes with integers of 64 bits, whatever the width of an array's elements. Python, which runs the kernels where
NUMBA_DISABLE_JIT is set, computes with NumPy's scalars, and an element of 8 bits plus a number of Python has 8 bits
(NEP 50). Both give the same where each sum, difference, product, shift to the left and power of a narrow integer has an
operand of 64 bits, as in ``np.int64(bits[i]) + 1``, or where the result is cast to the width of that integer, as in
``np.uint8(bits[i] - np.uint8(1))``. ``int`` of an unsigned integer does not widen it: numba leaves its type as it is,
and the difference of two is unsigned.

The types are those of the annotations and casts; what has none, such as an element of ``NDArray[Any]``, is not checked.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

MAPPER = Path(__file__).parents[2] / "mapper"
_NARROW = {"uint8", "uint16", "uint32", "int8", "int16", "int32"}
_WIDE_CASTS = {"int64", "uint64", "intp", "uintp", "float32", "float64", "float", "sqrt", "exp", "log"}
_TYPE_ARGUMENT = {"empty": 1, "zeros": 1, "ones": 1, "full": 2, "astype": 0}  #: of calls that make arrays: its place
_RING = (ast.Add, ast.Sub, ast.Mult, ast.LShift, ast.BitOr, ast.BitAnd, ast.BitXor)  #: exact modulo a power of two
_GROWING = (ast.Add, ast.Sub, ast.Mult, ast.LShift, ast.Pow)


def _last_name(node: ast.expr) -> str:
    """Return ``b`` of ``b`` and of ``a.b``, and nothing of other expressions."""
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


@dataclass
class Declarations:
    """What annotations mean: aliases of arrays, and the members of named tuples and of functions, with annotations."""

    aliases: dict[str, str] = field(default_factory=dict)
    members: dict[str, dict[str, str]] = field(default_factory=dict)

    def add(self, tree: ast.Module) -> None:
        for node in tree.body:
            if isinstance(node, ast.FunctionDef):
                self.members[node.name] = {a.arg: ast.unparse(a.annotation or a) for a in node.args.args}
            elif isinstance(node, ast.ClassDef):
                fields = [one for one in node.body if isinstance(one, ast.AnnAssign)]
                self.members[node.name] = {_last_name(one.target): ast.unparse(one.annotation) for one in fields}
            elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                self.aliases[node.targets[0].id] = ast.unparse(node.value)

    def kind(self, annotation: str) -> str:
        """Return the type that an annotation means, as :meth:`Function.type_of` does."""
        text = self.aliases.get(annotation, annotation)
        of_elements = re.fullmatch(r"NDArray\[np\.(\w+)\]", text)
        if of_elements or text.startswith("np."):
            name = of_elements[1] if of_elements else text.removeprefix("np.")
            return name if name in _NARROW else "wide" if name in _WIDE_CASTS else ""
        return "wide" if text == "float" else text if text in self.members else ""


class Function:
    """The types of one function's names: a narrow integer's, ``wide``, a named tuple's, or none that is known."""

    def __init__(self, function: ast.FunctionDef, declared: Declarations) -> None:
        self._function = function
        self._declared = declared
        self._names = {arg.arg: declared.kind(ast.unparse(arg.annotation or arg)) for arg in function.args.args}
        before = None
        while before != self._names:  # a name may get its type from one that a later line of a loop sets
            before = dict(self._names)
            for target, value in self._assignments():
                if isinstance(target, ast.Name):
                    self._note(target.id, self.type_of(value))

    def _assignments(self) -> Iterator[tuple[ast.expr, ast.expr]]:
        for node in ast.walk(self._function):
            if isinstance(node, ast.For):
                yield node.target, node.iter
            elif isinstance(node, ast.Assign):
                for target in node.targets:
                    if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                        yield from zip(target.elts, node.value.elts, strict=True)
                    else:
                        yield target, node.value

    def _note(self, name: str, kind: str) -> None:
        """Take in a type of a name: of several a narrow one counts."""
        kinds = {self._names.get(name, kind), kind}
        narrow = kinds & _NARROW
        self._names[name] = min(narrow) if narrow else kind if len(kinds) == 1 else ""

    def type_of(self, node: ast.expr) -> str:
        """Return the type in Python of an expression, or of the elements of an array."""
        if isinstance(node, ast.Name):
            return self._names.get(node.id, "")
        if isinstance(node, ast.Constant):
            return "wide" if isinstance(node.value, float) else ""
        if isinstance(node, ast.Subscript):
            return self.type_of(node.value)
        if isinstance(node, ast.Attribute):
            return self._declared.kind(self._declared.members.get(self.type_of(node.value), {}).get(node.attr, ""))
        if isinstance(node, ast.UnaryOp):
            return self.type_of(node.operand)
        if isinstance(node, ast.IfExp):
            return self._joint([node.body, node.orelse])
        if isinstance(node, ast.BinOp):
            return "wide" if isinstance(node.op, ast.Div) else self._joint([node.left, node.right])
        if isinstance(node, ast.Call):
            return self._type_of_call(node)
        return ""

    def _type_of_call(self, node: ast.Call) -> str:
        name = _last_name(node.func)
        if name in _TYPE_ARGUMENT:
            given = [word.value for word in node.keywords if word.arg == "dtype"] or node.args[_TYPE_ARGUMENT[name] :]
            name = _last_name(given[0]) if given else "float64"
        if name in _NARROW:
            return name
        if name in _WIDE_CASTS:
            return "wide"
        if name in {"min", "max", "abs"}:
            return self._joint(node.args)
        if name in {"copy", "reshape"} and isinstance(node.func, ast.Attribute):
            return self.type_of(node.func.value)
        return name if name in self._declared.members and name[0].isupper() else ""

    def _joint(self, nodes: list[ast.expr]) -> str:
        """Return the type of what NumPy computes of these: wide if one is, else narrow if one is."""
        kinds = [self.type_of(node) for node in nodes]
        if "wide" in kinds:
            return "wide"
        return next((kind for kind in kinds if kind in _NARROW), "")

    def faults(self) -> Iterator[tuple[int, str]]:
        """Yield the line and the text of each computation whose width is not declared."""
        cast = set(self._cast())
        for node in ast.walk(self._function):
            operands: list[ast.expr] = []
            if isinstance(node, ast.BinOp) and isinstance(node.op, _GROWING):
                operands = [node.left, node.right]
            elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Invert):
                operands = [node.operand]
            elif isinstance(node, ast.AugAssign) and isinstance(node.op, _GROWING):
                # An element of an array is of its own width after the assignment, whatever was computed.
                if not (isinstance(node.target, ast.Subscript) and self.type_of(node.target) in _NARROW):
                    operands = [node.target, node.value]
            elif isinstance(node, ast.Call):
                yield from ((node.lineno, text) for text in self._faults_of_call(node))
            if operands and node not in cast and self._joint(operands) in _NARROW:
                assert isinstance(node, ast.expr | ast.stmt)
                yield node.lineno, ast.unparse(node)

    def _faults_of_call(self, node: ast.Call) -> Iterator[str]:
        name = _last_name(node.func)
        if name == "int" and self.type_of(node.args[0]).startswith("uint"):
            yield ast.unparse(node)
        for argument, annotation in zip(node.args, self._declared.members.get(name, {}).values(), strict=False):
            if annotation == "int" and self.type_of(argument) in _NARROW:
                yield f"{ast.unparse(argument)} as an argument of {name}"

    def _cast(self) -> Iterator[ast.AST]:
        """Yield the operations whose result is cast to, or stored in, the width of their narrow operands."""
        for node in ast.walk(self._function):
            if isinstance(node, ast.Call) and _last_name(node.func) in _NARROW:
                yield from self._exact(node.args[0], _last_name(node.func))
        for target, value in self._assignments():
            if isinstance(target, ast.Subscript):
                yield from self._exact(value, self.type_of(target))

    def _exact(self, node: ast.expr, kind: str) -> Iterator[ast.AST]:
        """Yield the operations of an expression that may be done in a width if their result is needed in it."""
        if isinstance(node, ast.BinOp) and isinstance(node.op, _RING):
            if {self.type_of(node.left), self.type_of(node.right)} & _NARROW <= {kind}:
                yield node
            yield from self._exact(node.left, kind)
            if not isinstance(node.op, ast.LShift):
                yield from self._exact(node.right, kind)


def _path_of(module: str) -> str:
    return module.removeprefix("mapper.").replace(".", "/") + ".py"


def faults(sources: dict[str, str]) -> list[str]:
    """Return each computation, in texts by path in ``mapper/``, that Python and numba do in different widths."""
    trees = {name: ast.parse(text) for name, text in sources.items()}
    found = []
    for name, tree in trees.items():
        # Of functions with one name in several modules, the module's own one counts, else the one that it imports.
        names = (node.module or "" for node in tree.body if isinstance(node, ast.ImportFrom))
        imported = [trees[path] for path in (_path_of(module) for module in names) if path in trees]
        declared = Declarations()
        for module in (*trees.values(), *imported, tree):
            declared.add(module)
        for function in (node for node in tree.body if isinstance(node, ast.FunctionDef)):
            found += [f"{name}:{line}: {text}" for line, text in sorted(set(Function(function, declared).faults()))]
    return found


def kernel_sources() -> dict[str, str]:
    """Return the texts of all kernels, and of the array types in their annotations, by their paths in ``mapper/``."""
    paths = [MAPPER / "core" / "array_types.py", *sorted(MAPPER.glob("*/kernels/*.py"))]
    return {str(path.relative_to(MAPPER)): path.read_text() for path in paths}
