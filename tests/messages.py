"""Draws messages that users read on the console, to be read by a person: `python -m tests.messages [--seed 1]`."""

from __future__ import annotations

import argparse
import ast
import random
import re
from collections.abc import Iterator

from tatamu.base import errors
from tests.test_structure import SOURCE

ERRORS = {name for name, each in vars(errors).items() if isinstance(each, type) and issubclass(each, Exception)}
NAMES = ERRORS | {"ValueError", "OutOfReachError", "NoPlacement", "Conclusion", "foreign", "_refuse", "_stop"}
NAMES |= {"print", "say", "warn", "_warn", "progress", "starting", "resumable", "Option", "Argument"}
NAMES |= {"notes", "remarks", "lines", "warnings"}
"""Names of the functions that receive messages, and of the variables that collect them."""
MIN_WORDS = 3
"""Texts with fewer words are parts of messages, such as units. Texts that begin with < are markup."""


def messages() -> Iterator[tuple[str, str]]:
    """Yield the place and the text of each message of the package. Placeholders are shown as {name}."""
    for path in sorted(SOURCE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            for text, line in _spoken(node):
                if text[:1] != "<" and len(re.findall(r"\b[a-z]{2,}\b", re.sub(r"\{.*?\}", "", text))) >= MIN_WORDS:
                    yield f"{path.relative_to(SOURCE)}:{line}", " ".join(text.split())


def _spoken(node: ast.AST) -> Iterator[tuple[str, int]]:
    """Yield the messages in a call, in an assignment to a list of notes, in a field of options, and in a command."""
    if isinstance(node, ast.Call) and NAMES & set(ast.unparse(node.func).split(".")):
        for argument in (*node.args, *(each.value for each in node.keywords if each.arg != "metavar")):
            yield from _texts(argument)
    elif isinstance(node, ast.Assign | ast.AugAssign):
        if ast.unparse(node.targets[0] if isinstance(node, ast.Assign) else node.target) in NAMES:
            yield from _texts(node.value)
    elif isinstance(node, ast.keyword) and node.arg == "description":
        yield from _texts(node.value)
    elif isinstance(node, ast.FunctionDef) and any("command(" in ast.unparse(each) for each in node.decorator_list):
        yield ast.get_docstring(node) or "", node.lineno


def _texts(node: ast.AST) -> Iterator[tuple[str, int]]:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value, node.lineno
    elif isinstance(node, ast.JoinedStr):
        yield "".join(_shown(part) for part in node.values), node.lineno
    else:
        for child in ast.iter_child_nodes(node):
            yield from _texts(child)


def _shown(part: ast.expr) -> str:
    return f"{{{ast.unparse(part.value)}}}" if isinstance(part, ast.FormattedValue) else str(ast.literal_eval(part))


def main() -> None:
    """Print messages in a random order."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="number of messages")
    parser.add_argument("--seed", type=int, default=0, help="seed of the random order")
    given = parser.parse_args()
    order = random.Random(given.seed)
    for place, text in sorted(dict.fromkeys(messages()), key=lambda _: order.random())[: given.count]:
        print(f"{place}: {text}")


if __name__ == "__main__":
    main()
