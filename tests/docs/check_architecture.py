#!/usr/bin/env python3
"""check_architecture.py PAGE DEPENDENCIES: the picture in docs/architecture.md shows what CMake links.

DEPENDENCIES has a line "target: used used ..." for each target. The picture (a mermaid block of lines
"a --> b") must show exactly the dependencies that do not follow from others.
"""
import re
import sys


def reachable(graph, start):
    seen, waiting = set(), list(graph.get(start, ()))
    while waiting:
        node = waiting.pop()
        if node not in seen:
            seen.add(node)
            waiting += graph.get(node, ())
    return seen


def reduced(graph):
    edges = set()
    for node, used in graph.items():
        for one in used:
            others = (reachable(graph, other) for other in used if other != one)
            if not any(one in reach for reach in others):
                edges.add((node, one))
    return edges


def main():
    page, listing = (open(path).read() for path in sys.argv[1:3])
    graph = {}
    for line in listing.splitlines():
        target, used = line.split(":")
        graph[target] = sorted(set(used.split()))
    picture = re.search(r"^```mermaid\n(.*?)^```", page, re.S | re.M)
    if picture is None:
        print("docs/architecture.md has no picture (a mermaid block)")
        return 1
    edges = re.findall(r"^\s*(\w+) --> (\w+)\s*$", picture[1], re.M)
    # Optional libraries are drawn, too.
    drawn = {edge for edge in edges if edge[0] in graph}
    linked = reduced(graph)
    for edge in sorted(linked - drawn):
        print(f"not drawn, but linked: {edge[0]} --> {edge[1]}")
    for edge in sorted(drawn - linked):
        print(f"drawn, but not linked (or following from others): {edge[0]} --> {edge[1]}")
    print(f"{len(drawn)} drawn, {len(linked)} linked")
    return 0 if drawn == linked and len(drawn) > 10 else 1


if __name__ == "__main__":
    sys.exit(main())
