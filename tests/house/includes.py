#!/usr/bin/env python3
"""Holds what the files of a tree include against a table of layers, and says each arrow that goes up.

usage: includes.py LAYERS.txt [ROOT]

LAYERS.txt has a section for each top folder; # begins a comment. Globs are relative to that folder, * does not cross a slash.

    [hil]
    lines    600              no file is longer
    uses     common           other top folders, or files of these by their paths, that its files may include
    level    core/*           rooms from the bottom to the top; each glob is a room. A file includes its own room and rooms of
    level    periph/* fast/*  levels below, no other room of its own level. The first glob that fits a file is its room.
    private  core/part.h core/* debug/*    that header, and which files of this folder may include it
    knot     3                at most so many modules (a .c and the .h of its name) include one another in a circle

Without `level` each folder is a room, and any room may include any other, but not in a circle. That is looked for in every
section. A folder without a section is not looked at. An include of "..." names a file from ROOT (default: here).

Exit: 0 all is well, 1 something is not (a line each on stdout), 2 the table is wrong."""
import os
import re
import sys

INCLUDE = re.compile(r'\s*#\s*include\s+"([^"]+)"')
ENDINGS = (".c", ".h", ".def")


class Top:
    def __init__(self, name):
        self.name, self.lines, self.uses, self.levels, self.private, self.knot = name, None, None, [], [], None


def glob(text):
    """The pattern of a glob whose * stays within a folder."""
    return re.compile("".join("[^/]*" if c == "*" else re.escape(c) for c in text) + r"\Z")


def read_number(words, place):
    if len(words) != 1 or not words[0].isdigit():
        raise ValueError("%s: one number belongs there" % place)
    return int(words[0])


def read_table(path):
    tops = []
    for number, line in enumerate(open(path), 1):
        words, place = line.split("#", 1)[0].split(), "%s:%d" % (path, number)
        if not words:
            continue
        if re.fullmatch(r"\[[\w.-]+\]", words[0]) and len(words) == 1:
            tops.append(Top(words[0][1:-1]))
        elif not tops:
            raise ValueError("%s: a [folder] comes first" % place)
        elif words[0] == "lines":
            tops[-1].lines = read_number(words[1:], place)
        elif words[0] == "knot":
            tops[-1].knot = read_number(words[1:], place)
        elif words[0] == "uses":
            tops[-1].uses = (tops[-1].uses or set()) | set(words[1:])
        elif words[0] == "level" and len(words) > 1:
            tops[-1].levels.append([(text, glob(text)) for text in words[1:]])
        elif words[0] == "private" and len(words) > 2:
            tops[-1].private.append((words[1], [glob(text) for text in words[2:]]))
        else:
            raise ValueError("%s: `%s` is none of: [folder] lines uses level private knot" % (place, line.strip()))
    return tops


def files_of(root, top):
    for folder, folders, names in os.walk(os.path.join(root, top.name)):
        folders.sort()
        for name in sorted(names):
            if name.endswith(ENDINGS):
                yield os.path.relpath(os.path.join(folder, name), os.path.join(root, top.name))


def room_of(top, path):
    """Level and name of the room that a file is in; level None: the table has none for it."""
    if not top.levels:
        return 0, os.path.dirname(path) or "."
    for level, rooms in enumerate(top.levels):
        for text, pattern in rooms:
            if pattern.match(path):
                return level, text
    return None, path


def includes(path):
    """Line number and text of each include of a file of our own."""
    with open(path, encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            match = INCLUDE.match(line)
            if match:
                yield number, match.group(1)


def knots(arrows):
    """The strongly connected sets of a graph {from: {to: ...}} that have more than one member (Tarjan 1972), each sorted."""
    order, low, on, stack, found = {}, {}, set(), [], []
    for start in sorted(arrows):
        work = [] if start in order else [(start, iter(sorted(arrows.get(start, ()))))]
        if work:
            order[start] = low[start] = len(order)
            stack.append(start)
            on.add(start)
        while work:
            node, rest = work[-1]
            for to in rest:
                if to not in order:
                    order[to] = low[to] = len(order)
                    stack.append(to)
                    on.add(to)
                    work.append((to, iter(sorted(arrows.get(to, ())))))
                    break
                if to in on:
                    low[node] = min(low[node], order[to])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == order[node]:
                    members = []
                    while not members or members[-1] != node:
                        members.append(stack.pop())
                        on.discard(members[-1])
                    if len(members) > 1:
                        found.append(sorted(members))
    return found


class House:
    def __init__(self, root, tops):
        self.root, self.tops, self.findings = root, {top.name: top for top in tops}, []
        self.rooms, self.modules = {}, {} # arrows, each with one place where it is

    def say(self, text, *values):
        self.findings.append(text % values)

    def check_arrow(self, top, path, place, to):
        """One include of a file of ours; `to` is a path from the root."""
        other, _, inside = to.partition("/")
        if not os.path.exists(os.path.join(self.root, to)):
            self.say("%s: includes %s, which is not there; includes are named from the top", place, to)
        elif other != top.name:
            if top.uses is not None and other not in top.uses and to not in top.uses:
                self.say("%s: includes %s: %s/ may use %s", place, to, top.name, " ".join(sorted(top.uses)) or "nothing else")
        else:
            self.check_rooms(top, path, place, inside)

    def check_rooms(self, top, path, place, inside):
        (level, room), (to_level, to_room) = room_of(top, path), room_of(top, inside)
        module, to_module = os.path.splitext(path)[0], os.path.splitext(inside)[0]
        for header, users in top.private:
            if inside == header and not any(user.match(path) for user in users):
                self.say("%s: includes %s/%s, which is private to others", place, top.name, inside)
        if module != to_module:
            self.modules.setdefault(top.name, {}).setdefault(module, {}).setdefault(to_module, place)
        if room == to_room or level is None or to_level is None:
            return
        self.rooms.setdefault(top.name, {}).setdefault(room, {}).setdefault(to_room, place)
        if top.levels and to_level >= level:
            self.say("%s: includes %s/%s: %s is %s %s", place, top.name, inside, room,
                     "below" if to_level > level else "on the level of", to_room)

    def check_top(self, top):
        count = 0
        for path in files_of(self.root, top):
            whole = os.path.join(self.root, top.name, path)
            count += 1
            with open(whole, "rb") as file:
                lines = sum(1 for _ in file)
            if top.lines is not None and lines > top.lines:
                self.say("%s/%s: %d lines; no file has more than %d: split it by noun", top.name, path, lines, top.lines)
            if room_of(top, path)[0] is None:
                self.say("%s/%s: in no room of the table", top.name, path)
            for number, to in includes(whole):
                self.check_arrow(top, path, "%s/%s:%d" % (top.name, path, number), os.path.normpath(to))
        if not count:
            self.say("%s/: no files; does the table name the right folder?", top.name)
        self.check_circles(top)

    def check_circles(self, top):
        arrows = self.rooms.get(top.name, {})
        for members in knots(arrows):
            proof = [arrows[a][b] for a in members for b in sorted(arrows.get(a, ())) if b in members]
            self.say("%s/: rooms in a circle: %s (%s)", top.name, " ".join(members), ", ".join(proof))
        for members in knots(self.modules.get(top.name, {})) if top.knot is not None else ():
            if len(members) > max(top.knot, 1):
                self.say("%s/: %d modules include one another in a circle, at most %d may: %s", top.name, len(members), top.knot,
                         " ".join(members))


def main(arguments):
    if len(arguments) not in (1, 2):
        sys.stderr.write("usage: includes.py LAYERS.txt [ROOT]\n")
        return 2
    try:
        tops = read_table(arguments[0])
    except (OSError, ValueError) as error:
        sys.stderr.write("%s\n" % error)
        return 2
    house = House(arguments[1] if len(arguments) > 1 else ".", tops)
    for top in tops:
        house.check_top(top)
    for finding in house.findings:
        print(finding)
    return 1 if house.findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
