#!/usr/bin/env python3
"""The page of matrig record --measure: marks set with the mouse and the keys, the height recorded."""
import os
import re
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import tempfile
import time
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


def address_of(path):
    for _ in range(200):
        found = re.search(r"^picture: (http://\S+)", open(path).read(), re.M)
        if found:
            return found.group(1)
        time.sleep(0.05)
    raise RuntimeError("no address: " + open(path).read())


tap = Tap()
work = tempfile.mkdtemp(prefix="matrig.")
db = work + "/c.db"
picture(work + "/wave.png")
subprocess.check_call(["bash", "-c", '. tests/board/played.sh && campaign_of "$1" 1 >/dev/null', "bash", db])
subprocess.check_call(["build/matrig", "--quiet", "record", db, "picture", "1", "file=%s/wave.png" % work], stdout=subprocess.DEVNULL)
server = subprocess.Popen(["build/matrig", "record", db, "--measure", "1", "--port", "0"], stderr=open(work + "/said", "w"), stdout=subprocess.DEVNULL)
browser = Browser()
try:
    browser.open(address_of(work + "/said"), 1120, 760)
    browser.wait("document.querySelector('image')")
    box = browser.js("(() => { const b = document.getElementById('picture').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()")
    tap.check("the picture has its own pixels", box[2:] == [WIDTH, HEIGHT], box)

    def click(x, y):
        for kind in ("mousePressed", "mouseReleased"):
            browser.call("Input.dispatchMouseEvent", {"type": kind, "x": box[0] + x, "y": box[1] + y, "button": "left", "clickCount": 1})

    def told():
        return browser.js("document.getElementById('said').textContent")

    def record():
        browser.js("document.getElementById('said').textContent = ''; document.querySelector('form button').click()")
        browser.wait("document.getElementById('said').textContent")

    browser.js("document.getElementById('distance').value = '2 ft +- 0.02 ft'")
    click(100, 400)
    record()
    tap.check("marks that are missing are said", "not marks" in told(), told())
    click(500, 400)
    click(420, 330)
    click(420, 310)  # moves the mark
    record()
    browser.picture(OUT + "/picture.png")
    # 90 of 400 pixels of 2 ft
    tap.check("the height and its error", re.match(r"Height 0\.4500 ± 0\.00\d\d ft, recorded$", told()), told())
    browser.js("document.getElementById('distance').value = '4 ft'")
    record()
    tap.check("measured again", told().startswith("Height 0.9000 ± "), told())
    rows = sqlite3.connect(db).execute("select id, corrects, json_extract(fields, '$.height_ft'), json_extract(fields, '$.height_ft_marks') from records").fetchall()
    tap.check("each is a correction of the one before it", rows == [(1, None, None, None), (2, 1, 0.45, "2 ft +- 0.02 ft: 100,400 500,400 420,310 1"), (3, 2, 0.9, "4 ft: 100,400 500,400 420,310 1")], rows)
    tap.check("nothing comes from elsewhere, and no error but the refusal", all(r.startswith("http://127.0.0.1:") or r.startswith("data:") for r in browser.requests) and len(browser.errors) <= 1, browser.requests, browser.errors)
    server.send_signal(signal.SIGINT)
    tap.check("Ctrl-C ends it", server.wait(20) == 0)
finally:
    server.kill()
    browser.close()
    shutil.rmtree(work, ignore_errors=True)
sys.exit(tap.end())
