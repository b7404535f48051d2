"""Finds all docstrings and pages of the repository, and cuts them into sentences."""

from __future__ import annotations

import ast
import inspect
import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

ROOT = Path(__file__).parent.parent.parent
CODE = ("src", "studies")
SECTIONS = ("Args:", "Attributes:", "Raises:", "Returns:", "Yields:")
END = re.compile(
    r"""
    (?<! \bEq\.) (?<! \bFig\.) (?<! \be\.g\.) (?<! \bal\.) (?<! \bno\.) (?<! \bSt\.) (?<! \.\.)  # no end of a sentence
    (?: (?<= [.!?]) | (?<= [.!?] ["')*`]) | (?<= [.!?]\*\*) )
    \s+ (?= ["'(*`\[A-Z0-9])
    """,
    re.VERBOSE,
)
"""Regular expression that finds the space between two sentences."""

PICTURE = re.compile(r"!\[[^\]]*\]\([^)]*\)")
"""A paragraph that is only a picture. Its words describe the picture to those who cannot see it."""


@dataclass(frozen=True)
class Text:
    """A docstring or a page."""

    name: str
    parts: tuple[tuple[str, bool], ...]
    """Pieces of the text, each with a flag.

    The flag is True for a sentence. It is False for headings, code and tables, which do not count as sentences.
    """


def sentences(paragraph: str) -> list[str]:
    """Return the sentences of a paragraph."""
    return [piece for piece in END.split(" ".join(paragraph.split())) if piece]


def paragraphs_of(docstring: str) -> Iterator[tuple[str, bool]]:
    """Yield the pieces of a docstring, each with a flag: True for a paragraph, False for a heading or a line of code.

    Each entry of a section such as "Args:" is a paragraph.
    """
    lines: list[str] = []
    in_section = False
    for line in [*inspect.cleandoc(docstring).splitlines(), ""]:
        heading = line in SECTIONS
        indent = len(line) - len(line.lstrip())
        starts = heading or not line or line.startswith("- ") or (in_section and indent <= 4)
        code = indent >= 4 and not in_section
        if (starts or code) and lines:
            yield " ".join(lines), True
            lines = []
        if heading or code:
            yield line, False
        elif line:
            lines.append(line.strip())
        in_section = heading or (in_section and (indent > 0 or not line))


def docstrings() -> list[Text]:
    """Return the docstrings of all modules, classes, functions and fields of the code."""
    found = []
    for path in sorted(path for folder in CODE for path in (ROOT / folder).rglob("*.py")):
        name = path.relative_to(ROOT).as_posix()
        for label, text in _documented(ast.parse(path.read_text()), name):
            parts = tuple(
                (sentence, counted)
                for paragraph, counted in paragraphs_of(text)
                for sentence in (sentences(paragraph) if counted else [paragraph])
            )
            found.append(Text(label, parts))
    return found


def _documented(node: ast.AST, name: str) -> Iterator[tuple[str, str]]:
    """Yield the name and the docstring of a node of the syntax tree, and of all nodes inside it."""
    if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        if not isinstance(node, ast.Module):
            name = f"{name}: {node.name}" if ": " not in name else f"{name}.{node.name}"
        if text := ast.get_docstring(node, clean=False):
            yield name, text
        for assigned, said in zip(node.body, node.body[1:], strict=False):
            if isinstance(assigned, ast.Assign | ast.AnnAssign) and isinstance(said, ast.Expr):
                if isinstance(said.value, ast.Constant) and isinstance(said.value.value, str):
                    target = assigned.target if isinstance(assigned, ast.AnnAssign) else assigned.targets[0]
                    yield (
                        f"{name}, {ast.unparse(assigned if len(ast.unparse(assigned)) < 80 else target)}",
                        said.value.value,
                    )
    for child in ast.iter_child_nodes(node):
        yield from _documented(child, name)


def pages() -> list[Text]:
    """Return every page of the documentation, including the README but not the changelog."""
    files = [*ROOT.glob("*.md"), *(path for path in (ROOT / "docs").rglob("*.md") if "_build" not in path.parts)]
    return [_page(path) for path in sorted(files) if path.name != "CHANGELOG.md"]


def _page(path: Path) -> Text:
    """Read a page, and cut its paragraphs and lists into sentences.

    Headings, code, tables and pictures remain whole.
    """
    source = path.read_text()
    lines = source.splitlines()
    parts: list[tuple[str, bool]] = []
    kind = ""
    for token in MarkdownIt("commonmark").enable("table").parse(source):
        if token.type in ("fence", "code_block", "table_open") and token.map:
            parts.append(("\n".join(lines[slice(*token.map)]), False))
        if token.type.endswith("_open"):
            kind = token.type
        if token.type == "inline" and kind == "heading_open":
            parts.append((f"## {token.content}", False))
        elif token.type == "inline" and PICTURE.fullmatch(token.content):
            parts.append((token.content, False))
        elif token.type == "inline" and kind == "paragraph_open":
            parts.extend((sentence, True) for sentence in sentences(_shown(token.content)))
    return Text(path.relative_to(ROOT).as_posix(), tuple(parts))


def _shown(markdown: str) -> str:
    """Return a Markdown paragraph without the addresses of its links, as a browser shows it."""
    return re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", markdown)


def sample(seed: int, n_docstrings: int, n_pages: int) -> list[Text]:
    """Choose random docstrings and pages for a reader.

    In the same version of the repository, a seed always gives the same sample.
    """
    chance = random.Random(seed)
    return [*chance.sample(docstrings(), n_docstrings), *chance.sample(pages(), n_pages)]
