#!/usr/bin/env python3
"""The report page, and the live page of a finished campaign, of a database whose every text is hostile: in headless Chromium nothing of
it runs, nothing is asked for elsewhere, and the figures are there."""
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from cdp import Browser, Tap  # noqa: E402

os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
OUT = "build/browser"
RUN = "tests/runs/landing5.run"
HOSTILE = "\"'><script>alert(1)</script><img src=http://192.0.2.1/x onerror=alert(2)><style>@import 'http://192.0.2.1/y'</style>"

tap = Tap()
work = tempfile.mkdtemp(prefix="matrig.")


def campaign(db):
    """Landing 5 as the emulated board says it at full speed, logged and compared."""
    subprocess.run(["build/matrig-board", "--elf", "build/firmware/matrig.elf", "--can", "file:%s/can" % work, "--serial", "file:%s/serial" % work,
                    "--rig", RUN], check=True, timeout=120, stderr=subprocess.DEVNULL)
    subprocess.run(["build/matrig", "--quiet", "log", "--can", "file:%s/can" % work, "--serial", "file:%s/serial" % work, "--db", db],
                   check=True, timeout=120, stdout=subprocess.DEVNULL)
    subprocess.run(["build/matrig", "--quiet", "compare", db, "1"], timeout=120, stdout=subprocess.DEVNULL)


def make_hostile(path):
    """Every text column of every table, but those whose words the program itself gives a meaning to, gets markup; returns how many."""
    db, changed = sqlite3.connect(path), 0
    spared = {("events", "kind"), ("gaps", "message"), ("gaps", "cause"), ("configurations", "text"), ("missing", "message"),
              ("readiness", "kind"), ("readiness", "checks"), ("readiness", "verdict")}
    for (table,) in db.execute("select name from sqlite_schema where type = 'table' and name not like 'sqlite_%'").fetchall():
        for column in db.execute("pragma table_info(%s)" % table).fetchall():
            if "TEXT" in column[2] and (table, column[1]) not in spared:
                changed += db.execute("update or ignore %s set %s = ?" % (table, column[1]), (HOSTILE,)).rowcount
    db.commit()
    db.close()
    return changed


def check_report(browser, db):
    page = work + "/report.html"
    done = subprocess.run(["build/matrig", "--quiet", "report", db, "-o", page], timeout=120, capture_output=True, text=True)
    tap.check("the report of a hostile campaign is made", done.returncode == 0, done.stderr)
    browser.open("file://" + page)
    time.sleep(0.5)
    browser.pump()
    tap.check("it asks for nothing but itself", [u for u in browser.requests if not u.startswith("data:")] == ["file://" + page], browser.requests)
    tap.check("nothing wrong on the console", not browser.errors, browser.errors)
    tap.check("nothing hostile ran, or became an element", not browser.dialogs and browser.js("document.querySelectorAll('script, img, iframe, object, embed, link').length") == 0 and
              browser.js("document.querySelectorAll('style').length") == 1, browser.dialogs)
    source = open(page).read()
    tap.check("and the markup is told, escaped", "&lt;script&gt;" in source and "<script" not in source.lower(), re.findall(".{80}alert.{40}", source)[:3])
    facts = browser.js("document.body.innerText")
    tap.check("touchdown speed and stop are there, and plots with axes", re.search(r"35\.4\d+ ± 0\.0\d+ ft/s", facts) and re.search(r"90\.\d+", facts) and
              browser.js("document.querySelectorAll('svg').length") >= 4, facts[:1200])
    browser.picture(OUT + "/report.png")


def check_live(browser, db):
    err = work + "/live.err"
    process = subprocess.Popen(["build/matrig", "live", db, "--port", "0"], stderr=open(err, "w"), stdin=subprocess.DEVNULL)
    try:
        address = None
        for _ in range(100):
            found = re.search(r"^live: (http://\S+)$", open(err).read(), re.M)
            if found:
                address = found.group(1)
                break
            time.sleep(0.05)
        if not tap.check("the finished campaign is served too", address, open(err).read()):
            return
        browser.requests.clear()
        browser.open(address)
        tap.check("its last state is shown", browser.wait("document.querySelector('#state-big').textContent === 'IDLE' && /SILENT/.test(document.querySelector('#board-big').textContent)"),
                  browser.js("document.body.innerText"))
        tap.check("with all of its strips", browser.wait("matrigLive.fine.count > 380"), browser.js("matrigLive.fine.count"))
        time.sleep(0.5)
        browser.pump()
        base = address.split("#")[0]
        tap.check("hostile links stay text", "<script>" in browser.js("document.querySelector('#source').textContent") and not browser.dialogs and
                  browser.js("document.querySelectorAll('img').length") == 0)
        tap.check("it cannot arm, and says where that is done", browser.js("document.querySelector('#arm').disabled") and
                  "--live" in browser.js("document.querySelector('#command-said').textContent"))
        tap.check("nothing from elsewhere, nothing wrong", all(u.startswith(base) or u.startswith("data:") for u in browser.requests) and not browser.errors,
                  browser.requests, browser.errors)
        browser.picture(OUT + "/follow-1120.png")
    finally:
        process.terminate()
        process.wait(10)


def main():
    os.makedirs(OUT, exist_ok=True)
    db = work + "/<b>campaign.db"
    campaign(db)
    changed = make_hostile(db)
    tap.check("%d texts are hostile" % changed, changed >= 8)
    browser = Browser()
    try:
        check_report(browser, db)
        check_live(browser, db)
    finally:
        browser.close()
        shutil.rmtree(work, ignore_errors=True)
    return tap.end()


sys.exit(main())
