#!/usr/bin/env python3
"""The page of matrig record --measure: marks set with the mouse, and the command that records the height."""
import os
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from cdp import Browser, Tap  # noqa: E402

os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
OUT = "build/browser"
WIDTH, HEIGHT = 1800, 500  # wider than the window


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def picture(path):
    """A mat at y = 400 with a vee, whose crest is at (420, 310)."""
    rows = b""
    for y in range(HEIGHT):
        rows += b"\0" + b"".join(b"\x40\x40\x40" if 0 <= y - (400 - max(0, 90 - abs(x - 420))) < 5 else b"\xc8\xd7\xe6" for x in range(WIDTH))
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


tap = Tap()
work = tempfile.mkdtemp(prefix="matrig.")
db = work + "/c.db"
picture(work + "/wave.png")
subprocess.check_call(["bash", "-c", '. tests/board/played.sh && campaign_of "$1" 1 >/dev/null', "bash", db])
subprocess.check_call(["build/matrig", "--quiet", "record", db, "picture", "1", "file=%s/wave.png" % work], stdout=subprocess.DEVNULL)
subprocess.check_call(["build/matrig", "--quiet", "record", db, "--measure", "1", "-o", work + "/marks.html"], stdout=subprocess.DEVNULL)
browser = Browser()
try:
    browser.open("file://" + work + "/marks.html", 1120, 760)
    browser.wait("document.querySelector('image')")
    box = browser.js("(() => { const b = document.getElementById('picture').getBoundingClientRect(); return [Math.round(b.left), Math.round(b.top), b.width, b.height]; })()")
    tap.check("the picture has its own pixels", box[2:] == [WIDTH, HEIGHT], box)

    def click(x, y):
        for kind in ("mousePressed", "mouseReleased"):
            browser.call("Input.dispatchMouseEvent", {"type": kind, "x": box[0] + x, "y": box[1] + y, "button": "left", "clickCount": 1})

    def command():
        return browser.js("document.getElementById('command').textContent")

    def set_distance(text):
        browser.js("(() => { const d = document.getElementById('form').distance; d.value = %r; d.dispatchEvent(new Event('input', {bubbles: true})); })()" % text)

    set_distance("2 ft +- 0.02 ft")
    click(100, 400)
    tap.check("no command before all marks", command() == "", command())
    click(500, 400)
    click(420, 330)
    click(420, 310)  # moves the mark
    browser.picture(OUT + "/picture.png")
    subprocess.check_call(command().replace("matrig", "build/matrig", 1), shell=True, stdout=subprocess.DEVNULL)
    set_distance("4 ft")
    tap.check("the command follows the distance", "'4 ft: 100,400 500,400 420,310 1'" in command(), command())
    # 90 of 400 pixels of 2 ft
    rows = sqlite3.connect(db).execute("select id, corrects, json_extract(fields, '$.height_ft'), json_extract(fields, '$.height_ft_marks') from records").fetchall()
    tap.check("the command records the height", rows == [(1, None, None, None), (2, 1, 0.45, "2 ft +- 0.02 ft: 100,400 500,400 420,310 1")], rows)
    tap.check("the page loads the picture alone, without an error", all(r.startswith("file://") or r.startswith("data:") for r in browser.requests) and not browser.errors, browser.requests, browser.errors)
finally:
    browser.close()
    shutil.rmtree(work, ignore_errors=True)
sys.exit(tap.end())
