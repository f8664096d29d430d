"""Names each line that has branches which no test takes, with the reason for its function.

usage: uncovered.py COVERAGE.json REASONS.txt

REASONS.txt has a line for each function, "FILE:FUNCTION: reason"; empty lines and those that begin with # are comments. Exit 1 when
a line has no reason; a reason without such a line is told."""
import json
import sys


def read_reasons(path):
    reasons = {}
    for number, line in enumerate(open(path), 1):
        if not line.strip() or line.startswith("#"):
            continue
        parts = line.strip().split(": ", 1)
        if len(parts) != 2 or parts[0].count(":") != 1 or parts[0] in reasons:
            sys.exit("%s:%d: not FILE:FUNCTION: reason, or a second one for the same function" % (path, number))
        reasons[parts[0]] = parts[1]
    return reasons


def function_at(functions, line):
    """The last function that begins at the line or before it."""
    before = [f for f in functions if f["lineno"] <= line]
    return max(before, key=lambda f: f["lineno"])["name"] if before else "?"


def missed_lines(coverage):
    """(file, function, line, branches not taken, branches), in the order of the source."""
    for f in sorted(coverage["files"], key=lambda f: f["file"]):
        for line in f["lines"]:
            missed = sum(not b["count"] for b in line["branches"])
            if missed:
                yield f["file"], function_at(f["functions"], line["line_number"]), line["line_number"], missed, len(line["branches"])


def main():
    reasons = read_reasons(sys.argv[2])
    unused = set(reasons)
    told, nameless, branches = None, 0, 0
    for path, function, number, missed, of in missed_lines(json.load(open(sys.argv[1]))):
        name = "%s:%s" % (path, function)
        unused.discard(name)
        nameless += name not in reasons
        branches += missed
        if told != name:
            print("%s: %s" % (name, reasons.get(name, "NO REASON in %s: test it, or say why it cannot be" % sys.argv[2])))
            told = name
        print("    %d: %d of %d not taken: %s" % (number, missed, of, open(path).read().splitlines()[number - 1].strip()))
    for name in sorted(unused):
        print("%s: has a reason in %s, but each of its branches is taken: delete it there" % (name, sys.argv[2]))
    print("%d branches are not taken; %d lines of them have no reason" % (branches, nameless))
    return 1 if nameless else 0


sys.exit(main())
