#!/usr/bin/env python3
"""The page of matrig day in headless Chromium: what is next stands there, its buttons start the steps, what is to be typed is at the
terminal, nothing comes from elsewhere."""
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from cdp import Browser, Tap  # noqa: E402

os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
OUT = "build/browser"
tap = Tap()
work = tempfile.mkdtemp(prefix="matrig.")
db = work + "/<b>day.db"  # a name that is text, and stays so
said = open(work + "/said", "w+")
board = subprocess.Popen(["build/matrig-board", "--elf", "build/firmware/matrig.elf", "--serial", "pty:%s/tty" % work, "--rig", "hil/rest.run",
                          "--speed", "real"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
day = subprocess.Popen(["build/matrig", "day", db, "--serial", "pty:%s/tty" % work, "--can", "none", "--page", "0", "--who", "t"],
                       stdin=subprocess.PIPE, stdout=said, stderr=said)


def until(what, wait_s=60):
    end = time.monotonic() + wait_s
    while time.monotonic() < end:
        if what():
            return True
        time.sleep(0.02)
    return False


def typed(text):
    day.stdin.write(text.encode())
    day.stdin.flush()


def address():
    found = re.search(r"the day's page: (http://\S+)", open(work + "/said").read())
    return found and found.group(1)


def post(base, token, body):
    request = urllib.request.Request(base + "day", json.dumps(body).encode(), {"Content-Type": "application/json", "X-Matrig-Token": token})
    try:
        return urllib.request.urlopen(request, timeout=10).status
    except urllib.error.HTTPError as error:
        return error.code


def landing_state():
    return sqlite3.connect(db).execute("select group_concat(state) from landings").fetchone()[0]


NEXT = "document.getElementById('next').textContent"
SHOWS = NEXT + " === %s && document.querySelector('#buttons button:not(:disabled)') !== null"


def press(page, text):
    page.js("[...document.querySelectorAll('#buttons button')].find((b) => b.textContent.startsWith(%s)).click()" % json.dumps(text))


try:
    typed("y\n")
    until(address)
    url = address()
    base, token = url.split("day#")
    page = Browser()
    page.open(url, 1200, 900)
    tap.check("what is next is shown", page.wait(SHOWS % '"series"'), page.js("document.body.innerText"))
    tap.check("the campaign's name stays text", page.js("document.getElementById('source').textContent").startswith(db) and page.js("document.querySelector('#source b') === null"))
    press(page, "Do it")
    tap.check("what is to be typed is told to be at the terminal", page.wait(NEXT + " === 'series' && document.getElementById('reason').textContent === 'at the terminal'"))
    typed("first series\n\n")
    tap.check("and what was typed is seen", page.wait(SHOWS % '"survey"'))
    page.js("window.confirm = () => true")
    press(page, "Skip it")
    tap.check("a step is skipped by its button", page.wait(SHOWS % '"ready"'))
    tap.check("it is known as skipped", page.js("document.querySelector('#steps tr.skipped td:nth-child(3)').textContent") == "skipped")
    for width in (1200, 800, 390):
        page.size(width, 900)
        page.picture("%s/day-%d.png" % (OUT, width))
        wide = page.js("document.documentElement.scrollWidth")
        tap.check("nothing is wider than a screen of %d points" % width, wide <= width, wide)
    press(page, "Do it")
    tap.check("ready runs by its button, and says go", page.wait(SHOWS % '"land"', 40), open(work + "/said").read()[-1500:])
    press(page, "Do it")
    arm = "[...document.querySelectorAll('#buttons button')].some((b) => b.textContent === 'Arm' && !b.disabled)"
    tap.check("the log runs, and can be told to arm", page.wait(arm))
    tap.check("a key without the token does nothing", post(base, "0" * 32, {"keys": "ay"}) == 403 and landing_state() is None)
    tap.check("a key that is not taken now, and half a question, are refused", post(base, token, {"keys": "sy"}) == 409 and post(base, token, {"keys": "a"}) == 409)
    press(page, "Arm")
    tap.check("the board is armed by the page", until(lambda: landing_state() == "1"), open(work + "/said").read()[-800:])
    page.wait("[...document.querySelectorAll('#buttons button')].some((b) => b.textContent === 'Disarm' && !b.disabled)")
    press(page, "Disarm")
    tap.check("and disarmed", until(lambda: landing_state() == "0"))
    page.wait("[...document.querySelectorAll('#buttons button')].some((b) => b.textContent === 'End the log' && !b.disabled)")
    press(page, "End the log")
    tap.check("the log is ended by its button; nothing has landed", page.wait(SHOWS % '"land"', 30) and page.js("[...document.querySelectorAll('#buttons button')].every((b) => b.textContent !== 'Arm')"))
    tap.check("nothing was asked of elsewhere", page.js("performance.getEntriesByType('resource').every((r) => r.name.startsWith(location.origin))"))
    typed("q\n")
    tap.check("a day that has ended is told", page.wait("!document.getElementById('offline').hidden"))
    page.close()
finally:
    for process in (day, board):
        process.terminate()
        process.wait(20)
    shutil.rmtree(work, ignore_errors=True)
sys.exit(tap.end())
