#!/usr/bin/env python3
"""Checks the pages: links lead somewhere, every page can be reached, every head, detector and layout of
datasets that the program knows has its page, and commands work.

check_docs.py ROOT PROGRAM [--installed PREFIX]. Pages are README.md, CONTRIBUTING.md and docs/**/*.md. A block

    ```sh runnable
    arbox ...
    ```

is run by bash with -e in an empty folder that holds a link to the repository's examples, with the
program first on PATH; the blocks of one page share the folder, in order. With --installed the
blocks "```sh installed" are run instead, with PREFIX and CMAKE_PREFIX_PATH in their environment, and
links are not checked again. Prints what failed.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

BLOCKS = {kind: re.compile(rf"^```sh {kind}\n(.*?)^```", re.S | re.M)
          for kind in ("runnable", "installed")}
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)\s]*)?\)")
STARTS = ("README.md", "docs/architecture.md")


def pages_of(root):
    front = [root / "README.md", root / "CONTRIBUTING.md"]
    return [page for page in front if page.exists()] + sorted((root / "docs").rglob("*.md"))


def links_of(page):
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
    targets = [link for link in LINK.findall(text) if "://" not in link]
    return [(page.parent / target).resolve() for target in targets]


def broken_links(pages):
    return [f"{page}: broken link to {target}"
            for page in pages for target in links_of(page) if not target.exists()]


def unreachable(root, pages):
    waiting = [root / start for start in STARTS if (root / start).exists()]
    seen = set()
    while waiting:
        page = waiting.pop()
        if page in seen or page.suffix != ".md":
            continue
        seen.add(page)
        waiting += [target for target in links_of(page) if target.exists()]
    return [f"{page}: no page that begins at {' or '.join(STARTS)} leads to it"
            for page in pages if page.is_relative_to(root / "docs") and page not in seen]


def output_of(program, *words):
    return subprocess.run([program, *words], capture_output=True, text=True, check=True).stdout


def missing_pages(root, program):
    named = re.findall(r"^(head|detector|train)/(\w+)", output_of(program, "config", "list"), re.M)
    wanted = {f"docs/{'heads' if kind == 'head' else 'detectors'}/{name}.md" for kind, name in named}
    missing = [f"{page}: no such page" for page in sorted(wanted) if not (root / page).exists()]
    layouts = re.search(r"--to-layout TEXT:\{([^}]*)\}", output_of(program, "convert", "--help"))
    table = re.findall(r"^\| (`.*?) \|.*\]\(\w+\.md", (root / "docs/datasets/README.md").read_text(), re.M)
    paged = re.findall(r"`([^`]+)`", " ".join(table))
    missing += [f"docs/datasets/README.md: no page for the layout {layout}"
                for layout in layouts[1].split(",") if layout not in paged]
    print(f"{len(wanted)} heads and detectors, {len(paged)} layouts with their pages")
    return missing if len(wanted) > 6 and len(paged) > 12 else missing + ["heads, layouts: not found"]


def failed_blocks(root, page, program, prefix):
    failures = []
    blocks = BLOCKS["installed" if prefix else "runnable"].findall(page.read_text())
    environment = dict(os.environ, PATH=f"{program.parent}:{os.environ['PATH']}")
    if prefix:
        environment.update(PREFIX=prefix, CMAKE_PREFIX_PATH=prefix)
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(root / "examples", pathlib.Path(folder) / "examples")
        for block in blocks:
            result = subprocess.run(["bash", "-euo", "pipefail", "-c", block], cwd=folder,
                                    env=environment, capture_output=True, text=True)
            if result.returncode != 0:
                failures.append(f"{page}: exit code {result.returncode} of\n{block}"
                                f"{result.stdout[-2000:]}{result.stderr[-4000:]}")
    print(f"{page.relative_to(root)}: {len(blocks)} blocks, {len(failures)} failed")
    return failures, len(blocks)


def main():
    root, program = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    pages = pages_of(root)
    prefix = sys.argv[4] if sys.argv[3:4] == ["--installed"] else ""
    problems = [] if prefix else (
        broken_links(pages) + unreachable(root, pages) + missing_pages(root, program))
    count = 0
    for page in pages:
        failures, blocks = failed_blocks(root, page, program, prefix)
        problems += failures
        count += blocks
    if count == 0:
        problems.append("no runnable block found")
    print("\n".join(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
