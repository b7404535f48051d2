"""The digest of the code on which a rollout depends, which tells simulations of another version apart."""

from __future__ import annotations

import ast
import hashlib
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent
"""Folder of all code on which a rollout depends."""


@cache
def source_digest() -> str:
    """Return a digest of the code that determines a rollout; comments, docstrings and layout do not change it."""
    digest = hashlib.sha256()
    for path in sorted(ROOT.rglob("*.py")):
        digest.update(f"{path.relative_to(ROOT).as_posix()} {code_of(path.read_text())}".encode())
    return digest.hexdigest()


def code_of(source: str) -> str:
    """Return the syntax tree of a module as text, without standalone strings such as docstrings."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [each for each in node.body if not _is_text(each)]
    return ast.dump(tree)


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
