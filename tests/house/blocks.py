#!/usr/bin/env python3
"""Runs the blocks of commands of a page, as a reader would, in a folder of their own; what cannot be run here is looked at instead.

usage: blocks.py PAGE [FOLDER] | blocks.py --look PAGE...

FOLDER is made; it gets links to the sources and to build/, and a copy of campaign.db when FOLDER/../campaign.db is there. A block begins with
```sh and a mark:

    sh            is run, all of a page in one shell that stops at the first line that fails
    sh board      is run with an emulated board at rest in place of the hardware: serial:/dev/ttyUSB0 is its pseudo-terminal, can:can0 its socket
    sh day        make test-day runs it
    sh hardware, sh network, sh long   are not run: their lines are bash, matrig has the commands and options, make the targets

Commands in a line of text (`matrig log --can`, `make demo`) are looked at likewise, but for changelog.md, which names what went. Without
FOLDER, and of the pages of --look, nothing is run, and all that is asked for is that.

Exit: 0 all is well; else what failed, on stdout."""
import functools
import glob
import os
import re
import subprocess
import sys

LIMIT_S = 600
GLOBAL = ("--json", "--quiet", "--si")
BOARD = ("build/matrig-board --elf build/firmware/matrig.elf --flash board.flash --nor board.nor --speed real --for 120 --rig hil/rest.run %s & board=$!\n"
         "%s\nkill $board; wait $board || true\n")
LINKS = (("serial:/dev/ttyUSB0", "--serial", "pty:board.tty"), ("can:can0", "--can", "unix:board.can"))


def fences_of(path):
    """(line, mark, text) of each block."""
    blocks, mark = [], None
    for number, line in enumerate(open(path, encoding="utf-8"), 1):
        if mark is None and line.startswith("```"):
            mark, begin, lines = line[3:].strip(), number, []
        elif mark is not None and line.startswith("```"):
            blocks.append((begin, mark, "".join(lines)))
            mark = None
        elif mark is not None:
            lines.append(line)
    return blocks


def blocks_of(path):
    """Those of commands."""
    return [b for b in fences_of(path) if b[1].split()[:1] == ["sh"]]


def spans_of(path):
    """(line, text) of commands between backquotes in the text."""
    if os.path.basename(path) == "changelog.md":
        return
    text = open(path, encoding="utf-8").read()
    for line, mark, block in fences_of(path):
        text = text.replace(block, "\n" * block.count("\n"))
    for found in re.finditer(r"(?<!`)`([^`]+)`(?!`)", text):
        if re.match(r"((build/)?matrig|make) ", found[1]):
            yield text.count("\n", 0, found.start()) + 1, " ".join(found[1].split())


def with_board(text):
    options = []
    for hardware, option, emulated in LINKS:
        if hardware in text:
            options += [option, emulated]
            text = text.replace(hardware, emulated)
    return BOARD % (" ".join(options), text)


def script_of(page, blocks):
    script = ['set -eE', 'trap \'echo "failed: $BASH_COMMAND"\' ERR', "trap 'kill $(jobs -p) 2>/dev/null || true' EXIT", 'PATH=$PWD/build:$PATH']
    for line, mark, text in blocks:
        script.append("echo '== %s:%d'" % (page, line))
        script.append(with_board(text) if mark == "sh board" else text)
    return "\n".join(script + ["echo all of it ran\n"])


@functools.lru_cache(maxsize=None)
def helped(root, command):
    return subprocess.run([root + "/build/matrig", command, "--help"], capture_output=True, text=True, timeout=20)


@functools.lru_cache(maxsize=None)
def makefiles(root):
    return "\n".join(open(path, encoding="utf-8").read() for depth in ("Makefile", "*/module.mk", "*/*/module.mk") for path in glob.glob(root + "/" + depth))


def look_at_command(root, words):
    """What is wrong with COMMAND OPTION... of matrig."""
    if not words or not re.fullmatch(r"[a-z]+", words[0]):
        return []
    told = helped(root, words[0])
    if told.returncode != 0:
        return ["matrig has no command %s" % words[0]]
    options = {option for w in words[1:] for option in re.findall(r"^--[a-z][a-z-]*|(?<=[|\[(])--[a-z][a-z-]*", w)}
    return ["matrig %s has no option %s" % (words[0], o) for o in sorted(options) if o != "--help" and not re.search(re.escape(o) + "(?![a-z-])", told.stdout)]


def look(root, text, prose=False):
    """What is wrong with commands that are not run; those of prose are no whole lines of bash."""
    wrong = []
    if not prose:
        done = subprocess.run(["bash", "-n"], input=text, capture_output=True, text=True, timeout=20)
        if done.returncode != 0:
            wrong.append(done.stderr.strip())
    makefile = makefiles(root)
    for line in re.sub(r"\\\n", " ", text).split("\n"):
        words = line.split("#", 1)[0].split()
        if words[:1] == ["make"]:
            wrong += ["make has no target %s" % w for w in words[1:] if re.fullmatch(r"[a-z-]+", w) and not re.search(r"^%s:" % w, makefile, re.M)]
        for i, word in enumerate(words):
            if word in ("build/matrig", "matrig"):
                wrong += look_at_command(root, [w for w in words[i + 1:] if w not in GLOBAL])
    return wrong


def prepare(root, folder):
    os.makedirs(folder)
    for name in ("build", "common", "docs", "firmware", "hil", "host", "tests"):
        os.symlink(os.path.join(root, name), os.path.join(folder, name))
    kept = os.path.join(folder, "..", "campaign.db")
    if os.path.exists(kept):
        with open(kept, "rb") as source, open(os.path.join(folder, "campaign.db"), "wb") as copy:
            copy.write(source.read())


def wrong_on(page, folder=None):
    root, blocks, wrong = os.getcwd(), blocks_of(page) if folder else [], []
    run = [b for b in blocks if b[1] in ("sh", "sh board")]
    for line, text in spans_of(page):
        wrong += ["%s:%d: `%s`: %s" % (page, line, text, w) for w in look(root, text, prose=True)]
    for line, mark, text in blocks:
        if mark not in ("sh", "sh board"):
            wrong += ["%s:%d: %s" % (page, line, w) for w in look(root, text)]
    if run:
        prepare(root, folder)
        said = os.path.join(folder, "said.txt")
        with open(said, "w") as out:
            code = subprocess.run(["timeout", "-k", "5", str(LIMIT_S), "bash", "-c", script_of(page, run)], cwd=folder, stdin=subprocess.DEVNULL, stdout=out,
                                  stderr=subprocess.STDOUT).returncode
        tail = open(said, errors="replace").read().split("\n")
        if code != 0 or "all of it ran" not in tail:
            wrong.append("%s: exit %d\n%s" % (page, code, "\n".join(tail[-15:])))
    print("%d blocks, %d run" % (len(blocks), len(run)))
    for line in wrong:
        print(line)
    return bool(wrong)


if sys.argv[1] == "--look":
    sys.exit(max([wrong_on(page) for page in sys.argv[2:]]))
sys.exit(wrong_on(sys.argv[1], os.path.abspath(sys.argv[2]) if sys.argv[2:] else None))
