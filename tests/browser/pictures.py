#!/usr/bin/env python3
"""make pictures: the live page at the warning of landing 7 and the report of make demo, as PNG in docs/pictures; and docs/measured/demo.md with
the figures of that demo. The PNG are what the browser shows, cut to what README.md needs and made smaller by the browser."""
import base64
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from cdp import Browser  # noqa: E402

os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
OUT = "docs/pictures"
LARGEST = 120000  # bytes of a picture; README.md is read on a telephone


def address_of(path):
    for _ in range(200):
        found = re.search(r"^live: (http://\S+)$", open(path).read(), re.M)
        if found:
            return found.group(1)
        time.sleep(0.05)
    raise RuntimeError("no address: " + open(path).read())


def take(browser, name, left, top, width, height, scale):
    clip = {"x": left, "y": top, "width": width, "height": height, "scale": scale}
    data = base64.b64decode(browser.call("Page.captureScreenshot", {"format": "png", "clip": clip})["data"])
    with open("%s/%s" % (OUT, name), "wb") as out:
        out.write(data)
    print("%s/%s: %d bytes" % (OUT, name, len(data)))
    return len(data) <= LARGEST


def live(browser, work):
    """The page while the board warns."""
    links = ["--can", "unix:can", "--serial", "unix:serial"] # the page shows these names
    here, said = os.getcwd(), work + "/said"
    log = subprocess.Popen([here + "/build/matrig", "--quiet", "log", *links, "--db", "campaign.db", "--live", "0"], cwd=work,
                           stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=open(said, "w"))
    board = None
    try:
        browser.open(address_of(said), 1120, 900)
        board = subprocess.Popen([here + "/build/matrig-board", "--elf", here + "/build/firmware/matrig.elf", *links, "--speed", "real", "--rig",
                                  here + "/tests/runs/landing7.run"], cwd=work, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        if not browser.wait("window.matrigLive && matrigLive.state && matrigLive.state.warning.on && matrigLive.state.gear.station_ft > 30", 60):
            raise RuntimeError("the page shows no warning")
        if "-dirty" in browser.js("document.body.innerText"):
            raise RuntimeError("the firmware in the picture would be called -dirty: commit first, then make pictures")
        return take(browser, "live.png", 0, 0, 1120, 760, 0.75)
    finally:
        for process in (board, log):
            if process:
                process.terminate()
                process.wait(20)


def report(browser):
    """Of the last landing: displacement against the distance from the wheel, and the zone map below it."""
    browser.open(pathlib.Path("build/demo/report.html").resolve().as_uri(), 1000, 900)
    place = """[...document.querySelectorAll('figure.chart')].filter(f => f.getAttribute('aria-label').startsWith('%s')).pop().getBoundingClientRect().%s + window.scrollY"""
    for _ in range(2):  # all of it on the screen, where plots are drawn; they may change its height
        browser.size(1000, browser.js("document.documentElement.scrollHeight"))
        time.sleep(2)
    top = browser.js(place % ("displacement against distance", "top")) - 45
    height = browser.js(place % ("zone map", "bottom")) - top + 2
    return take(browser, "report.png", 0, top, 1000, height, 0.75)


def main():
    work = tempfile.mkdtemp(prefix="matrig.")
    browser = Browser()
    os.makedirs(OUT, exist_ok=True)
    try:
        small = [live(browser, work), report(browser)]
        with open("docs/measured/demo.md", "w") as page:
            subprocess.run(["python3", "tests/browser/played.py", "build/demo/campaign.db"], stdout=page, check=True)
    finally:
        browser.close()
        shutil.rmtree(work, ignore_errors=True)
    return 0 if all(small) else "a picture is larger than %d bytes" % LARGEST


sys.exit(main())
