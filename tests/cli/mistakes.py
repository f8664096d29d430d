"""mistakes.py MISTAKES FOLDER: TAP of each line of mistakes.txt, run as it stands and with --json; $d is FOLDER."""
import json
import os
import re
import subprocess
import sys

environment = {**os.environ, "d": sys.argv[2], "PATH": os.path.abspath("build") + ":" + os.environ["PATH"]}


def run(words):
    done = subprocess.run(["bash", "-c", words], env=environment, stdin=subprocess.DEVNULL, capture_output=True, timeout=60)
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def wrong(code, kind, pattern, words):
    """What is not as it should be: plain, one line on standard error alone; with --json, the same and one object on standard output."""
    plain, tagged = run(words), run(words.replace("matrig", "matrig --json", 1))
    for status, _, error in (plain, tagged):
        if status != code or error.count("\n") != 1 or not error.endswith("\n"):
            return plain, tagged
    if not re.search(pattern, plain[2]) or plain[1]:
        return plain
    try:
        told = json.loads(tagged[1])
        good = told["kind"] == kind and told["exit"] == code and tagged[2] == "matrig: %s\n" % told["error"]
    except (ValueError, KeyError):
        good = False
    return None if good else tagged


lines = [line.rstrip("\n").split("|", 2) for line in open(sys.argv[1]) if line.strip() and line[0] != "#"]
for code, kind, rest in lines:
    pattern, words = rest.rsplit("|", 1)
    found = wrong(int(code), kind, pattern, words)
    print("ok - " + words if found is None else "not ok - %s\n# %r" % (words, found))
