#!/usr/bin/env python3
"""Runs the blocks of commands of a page, as a reader would, in a folder of their own; what cannot be run here is looked at instead.

usage: blocks.py PAGE FOLDER

FOLDER is made; it gets links to the sources and to build/, and a copy of campaign.db when FOLDER/../campaign.db is there. A block begins with
```sh and a mark:

    sh            is run, all of a page in one shell that stops at the first line that fails
    sh board      is run with an emulated board at rest in place of the hardware: serial:/dev/ttyUSB0 is its pseudo-terminal, can:can0 its socket
    sh day        make test-day runs it
    sh hardware, sh network, sh long   are not run: their lines are bash, matrig has the commands and options, make the targets

Exit: 0 all is well; else what failed, on stdout."""
import glob
import os
import re
import subprocess
import sys

LIMIT_S = 150
BOARD = ("build/matrig-board --elf build/firmware/matrig.elf --flash board.flash --nor board.nor --speed real --for 120 --rig hil/rest.run %s & board=$!\n"
         "%s\nkill -INT $board; wait $board || true\n")
LINKS = (("serial:/dev/ttyUSB0", "--serial", "pty:board.tty"), ("can:can0", "--can", "unix:board.can"))


def blocks_of(path):
    """(line, mark, text) of each block of commands."""
    blocks, mark = [], None
    for number, line in enumerate(open(path, encoding="utf-8"), 1):
        if mark is None and line.startswith("```"):
            mark, begin, lines = line[3:].strip(), number, []
        elif mark is not None and line.startswith("```"):
            if mark.split()[:1] == ["sh"]:
                blocks.append((begin, mark, "".join(lines)))
            mark = None
        elif mark is not None:
            lines.append(line)
    return blocks


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


def helped(root, command):
    return subprocess.run([root + "/build/matrig", command, "--help"], capture_output=True, text=True, timeout=20)


def look(root, text):
    """What is wrong with commands that are not run."""
    wrong = []
    done = subprocess.run(["bash", "-n"], input=text, capture_output=True, text=True, timeout=20)
    if done.returncode != 0:
        wrong.append(done.stderr.strip())
    makefile = "\n".join(open(path, encoding="utf-8").read() for depth in ("Makefile", "*/module.mk", "*/*/module.mk")
                         for path in glob.glob(root + "/" + depth))
    for line in re.sub(r"\\\n", " ", text).split("\n"):
        words = line.split("#", 1)[0].split()
        if words[:1] == ["make"]:
            wrong += ["make has no target %s" % w for w in words[1:] if re.fullmatch(r"[a-z-]+", w) and not re.search(r"^%s:" % w, makefile, re.M)]
        for i, word in enumerate(words):
            if word in ("build/matrig", "matrig") and i + 1 < len(words) and re.fullmatch(r"[a-z]+", words[i + 1]):
                told = helped(root, words[i + 1])
                if told.returncode != 0:
                    wrong.append("matrig has no command %s" % words[i + 1])
                wrong += ["matrig %s has no option %s" % (words[i + 1], w) for w in words[i + 2:] if w.startswith("--") and w.split("=")[0] not in told.stdout]
    return wrong


def prepare(root, folder):
    os.makedirs(folder)
    for name in ("build", "common", "docs", "firmware", "hil", "host", "tests"):
        os.symlink(os.path.join(root, name), os.path.join(folder, name))
    kept = os.path.join(folder, "..", "campaign.db")
    if os.path.exists(kept):
        with open(kept, "rb") as source, open(os.path.join(folder, "campaign.db"), "wb") as copy:
            copy.write(source.read())


def main():
    page, folder = sys.argv[1], os.path.abspath(sys.argv[2])
    root, blocks, wrong = os.getcwd(), blocks_of(page), []
    run = [b for b in blocks if b[1] in ("sh", "sh board")]
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
    return 1 if wrong else 0


sys.exit(main())
