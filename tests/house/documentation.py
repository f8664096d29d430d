#!/usr/bin/env python3
"""Holds README.md and docs/ against what they promise, and says each thing that is not so.

usage: documentation.py [ROOT]

- README.md has at most README_MOST bytes.
- Each link of every page (README.md, docs/, the READMEs of folders) leads somewhere: the file is there, and the heading in it.
- Each page of docs/ can be reached by links from README.md.
- A path of the sources that README.md or docs/ name as code is there.
- Each row of docs/glossary.md names its places: a file, and in it the symbol or word behind the colon.
- A block of commands has a mark that tests/house/blocks.py knows.

Exit: 0 all is well, 1 something is not (a line each on stdout)."""
import os
import re
import sys

README_MOST = 8 * 1024
TOPS = ("common", "docs", "firmware", "hil", "host", "tests")
BLOCKS = {"sh", "sh board", "sh day", "sh hardware", "sh network", "sh long", "text", "json", "c"}
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
CODE = re.compile(r"`([^`\n]+)`")
PATH = re.compile(r"(?:%s)/[\w./-]*" % "|".join(TOPS))


def pages_of(root):
    found = ["README.md"]
    for top in TOPS:
        for folder, folders, files in os.walk(os.path.join(root, top)):
            folders.sort()
            found += [os.path.relpath(os.path.join(folder, f), root) for f in sorted(files) if f.endswith(".md")]
    return found


def without_blocks(text):
    """The lines with their numbers that stand in no block, and the first line of each block."""
    prose, opened, inside = [], [], False
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith("```"):
            if not inside:
                opened.append((number, line[3:].strip()))
            inside = not inside
        elif not inside:
            prose.append((number, line))
    return prose, opened


def slugs_of(prose):
    """GitHub's anchors of the headings."""
    slugs = []
    for _, line in prose:
        if re.match(r"#{1,6} ", line):
            title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line.lstrip("#").strip()).replace("`", "")
            slug = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
            slugs.append(slug if slug not in slugs else "%s-%d" % (slug, slugs.count(slug)))
    return slugs


class Papers:
    def __init__(self, root):
        self.root, self.wrong, self.read, self.reached = root, [], {}, {}
        self.pages = pages_of(root)

    def say(self, page, number, text):
        self.wrong.append("%s:%d: %s" % (page, number, text))

    def page(self, path):
        if path not in self.read:
            text = open(os.path.join(self.root, path), encoding="utf-8").read()
            self.read[path] = without_blocks(text)
        return self.read[path]

    def check_link(self, page, number, target):
        if re.match(r"[a-z]+:", target):
            return
        path, _, anchor = target.partition("#")
        path = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        if not os.path.exists(os.path.join(self.root, path)):
            self.say(page, number, "the link %s leads nowhere: there is no %s" % (target, path))
            return
        if path.endswith(".md"):
            self.reached.setdefault(page, set()).add(path)
        if anchor and (not path.endswith(".md") or anchor not in slugs_of(self.page(path)[0])):
            self.say(page, number, "the link %s leads nowhere: %s has no such heading" % (target, path))

    def check_paths(self, page, number, line):
        for code in CODE.findall(line):
            for word in code.split():
                path = word.strip(",;:()").rstrip(".")
                if PATH.fullmatch(path) and "//" not in path and not os.path.exists(os.path.join(self.root, path)):
                    self.say(page, number, "there is no %s" % path)

    def check_page(self, page):
        prose, opened = self.page(page)
        ours = page == "README.md" or page.startswith("docs/")
        for number, line in prose:
            for target in LINK.findall(CODE.sub("", line)):
                self.check_link(page, number, target)
            self.check_paths(page, number, line)
        for number, mark in opened if ours else []:
            if mark not in BLOCKS:
                self.say(page, number, "a block is marked '%s'; use one of: %s" % (mark, ", ".join(sorted(BLOCKS))))

    def check_reached(self):
        reached, todo = {"README.md"}, ["README.md"]
        while todo:
            for page in self.reached.get(todo.pop(), ()):
                if page not in reached:
                    reached.add(page)
                    todo.append(page)
        for page in self.pages:
            if page.startswith("docs/") and page not in reached:
                self.say(page, 1, "no links lead here from README.md")

    def check_glossary(self):
        page, rows = "docs/glossary.md", 0
        if page not in self.pages:
            self.say(page, 1, "there is no glossary")
            return
        for number, line in self.page(page)[0]:
            cells = [c.strip() for c in line.strip("|").split("|")]
            if not line.startswith("|") or len(cells) != 3 or cells[0].lower() == "term" or not cells[0].strip("-"):
                continue
            rows += 1
            places = re.findall(r"`([^`]+)`(?:: `([^`]+)`)?", cells[2])
            if not places:
                self.say(page, number, "%s: no place is named" % cells[0])
            for path, symbol in places:
                where = os.path.join(self.root, path)
                if not os.path.isfile(where):
                    self.say(page, number, "%s: there is no %s" % (cells[0], path))
                elif symbol and symbol not in open(where, encoding="utf-8").read():
                    self.say(page, number, "%s: %s does not have '%s'" % (cells[0], path, symbol))
        if rows == 0:
            self.say(page, 1, "no terms")

    def check(self):
        size = os.path.getsize(os.path.join(self.root, "README.md"))
        if size > README_MOST:
            self.say("README.md", 1, "%d bytes; at most %d" % (size, README_MOST))
        for page in self.pages:
            self.check_page(page)
        self.check_reached()
        self.check_glossary()
        return self.wrong


found = Papers(sys.argv[1] if len(sys.argv) > 1 else ".").check()
for line in found:
    print(line)
sys.exit(1 if found else 0)
