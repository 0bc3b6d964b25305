#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the Python of a page as a notebook would: its ```python blocks in order, in one namespace, in an empty folder with the
repository's `config`. What a block prints must be what the ```text block behind it shows.

In a page:
  <!-- folder: NAME -->           the files of this folder, beside the page, are there from the start
  <!-- picture: NAME -->          the image that the next line shows is the file NAME, which a block wrote
"…" within a shown line stands for any text, a line "…" for any lines. Numbers are compared to 10 % or 0.05."""
import argparse
import contextlib
import importlib.machinery
import importlib.util
import io
import os
import pathlib
import re
import shutil
import sys
import tempfile
import traceback

ROOT = pathlib.Path(__file__).resolve().parents[2]


def comparison():
    """`compare` of the pages of commands, so that both kinds of page mean the same by "…" and by a number."""
    loader = importlib.machinery.SourceFileLoader("follow", str(ROOT / "tests" / "tutorials" / "follow"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("follow", loader))
    sys.dont_write_bytecode = True
    loader.exec_module(module)
    return module


class Block:
    """A block of code: its place in the page's lines, what it shows and what it prints."""

    def __init__(self, first, last):
        self.first, self.last = first, last  # indices of the fences
        self.shown_at = None  # (first, last) of the fences of the text behind it
        self.shown, self.printed = [], []


def read(lines):
    blocks, at = [], 0
    while at < len(lines):
        if lines[at] == "```python":
            end = lines.index("```", at + 1)
            blocks.append(Block(at, end))
            at = end
        elif lines[at] == "```text" and blocks and not any(line for line in lines[blocks[-1].last + 1:at]):
            end = lines.index("```", at + 1)
            blocks[-1].shown_at, blocks[-1].shown = (at, end), lines[at + 1:end]
            at = end
        at += 1
    return blocks


def run(block, lines, page, namespace):
    """The error's text, or None."""
    source = "\n" * (block.first + 1) + "\n".join(lines[block.first + 1:block.last]) + "\n"
    out = io.StringIO()
    try:
        with contextlib.redirect_stdout(out):
            exec(compile(source, str(page), "exec"), namespace)
    except Exception:
        return f"{page}:{block.first + 1}: this block fails\n{traceback.format_exc()}"
    block.printed = [line.rstrip() for line in out.getvalue().rstrip("\n").split("\n")]
    if block.printed == [""]:
        block.printed = []
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=pathlib.Path)
    parser.add_argument("--any-figures", action="store_true", help="compare the words alone: figures are those of one compiler")
    parser.add_argument("--update", action="store_true", help="write what is printed, and the pictures, into the page")
    options = parser.parse_args()
    page, compare = options.page.resolve(), comparison().compare
    lines = page.read_text().split("\n")
    blocks = read(lines)
    pictures = [(found[1], re.search(r"\((\S+)\)", lines[at + 1])[1]) for at, line in enumerate(lines)
                if (found := re.fullmatch(r"<!-- picture: (\S+) -->", line))]
    os.environ["MPLBACKEND"] = "Agg"
    problems = []
    with tempfile.TemporaryDirectory(prefix="waymark_page_") as name:
        folder = pathlib.Path(name)
        shutil.copytree(ROOT / "config", folder / "config")
        for line in lines:
            if found := re.fullmatch(r"<!-- folder: (\S+) -->", line):
                shutil.copytree(page.parent / found[1], folder, dirs_exist_ok=True)
        os.chdir(folder)
        namespace = {"__name__": "__main__"}
        for block in blocks:
            if problem := run(block, lines, page, namespace):
                problems.append(problem)
                break
            _, missing = compare(block, with_numbers=not options.any_figures)
            if missing is not None and not options.update:
                problems.append(f"{page}:{block.first + 1}:\n  shown:   {missing}\n  printed: " +
                                "\n           ".join(block.printed))
        for file, image in pictures:
            if not (folder / file).is_file():
                problems.append(f"{page}: no block writes {file}")
            elif options.update:
                shutil.copyfile(folder / file, page.parent / image)
        os.chdir(ROOT)
    if options.update and not problems:
        for block in reversed(blocks):
            shown = block.shown if compare(block)[1] is None and "…" in "".join(block.shown) else block.printed
            text = ["```text", *shown, "```"] if shown else []
            if block.shown_at:
                lines[block.shown_at[0]:block.shown_at[1] + 1] = text
            elif text:
                lines[block.last + 1:block.last + 1] = text
        page.write_text("\n".join(lines))
    print(f"{page}: {len(blocks)} blocks, " + ("as shown" if not problems else "NOT as shown"))
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems or not blocks else 0


if __name__ == "__main__":
    sys.exit(main())
