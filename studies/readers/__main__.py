"""Runs the readers' test, which counts the sentences that a newcomer must read twice.

The first command prints a random sample of docstrings and pages, in which all sentences are numbered:

    python -m studies.readers --seed 0

A reader who does not know the project notes the number of every sentence that he or she must read twice. The second
command prints the percentage of these sentences:

    python -m studies.readers --seed 0 --marked 12 40

A test has three readers with different seeds. The test is passed if at most 2 % of all sentences are marked.
"""

from __future__ import annotations

import argparse

from studies.readers.texts import Text, sample


def main() -> None:
    """Print a sample of docstrings and pages or, if numbers are given, the sentences that a reader marked in it."""
    parser = argparse.ArgumentParser(description="Draw docstrings and pages for a reader; count the marked sentences.")
    parser.add_argument("--seed", type=int, default=0, help="a number for each reader (default 0)")
    parser.add_argument("--docstrings", type=int, default=20, help="number of docstrings (default 20)")
    parser.add_argument("--pages", type=int, default=5, help="number of pages (default 5)")
    parser.add_argument("--marked", type=int, nargs="*", metavar="N", help="sentences that had to be read twice")
    options = parser.parse_args()
    texts = sample(options.seed, options.docstrings, options.pages)
    print("\n".join(listing(texts) if options.marked is None else verdict(texts, options.marked)))


def listing(texts: list[Text]) -> list[str]:
    """Return the lines of a sample of docstrings and pages, with numbered sentences."""
    lines, number = [], 0
    for text in texts:
        lines += ["", f"=== {text.name}", ""]
        for part, counted in text.parts:
            number += counted
            lines.append(f"[{number}] {part}" if counted else part)
    return [*lines, "", f"{number} sentences"]


def verdict(texts: list[Text], marked: list[int]) -> list[str]:
    """Return lines of text with all sentences that a reader marked, and with their percentage.

    Raises:
        SystemExit: If there is no sentence with a given number.
    """
    counted = [(text.name, part) for text in texts for part, is_sentence in text.parts if is_sentence]
    if wrong := [number for number in marked if not 1 <= number <= len(counted)]:
        raise SystemExit(f"--marked must be from 1 to {len(counted)}, given {wrong[0]}")
    lines = [f"{counted[number - 1][0]}: {counted[number - 1][1]}" for number in marked]
    return [*lines, f"{len(marked)} of {len(counted)} sentences marked: {100 * len(marked) / len(counted):.1f} %"]


if __name__ == "__main__":
    main()
