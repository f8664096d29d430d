#!/usr/bin/env python3
"""The report page, and the live page of a finished campaign, of a database whose every text is hostile: in headless Chromium nothing of
it runs, nothing is asked for elsewhere, and the figures are there."""
import base64
import os
import pathlib
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
    for shift in (0.0, 0.02):
        subprocess.run(["build/matrig", "--quiet", "survey", db, "--new", "--edges", "none"], timeout=60, text=True, check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL, input="".join("%.3f\n" % (33.6 + shift + 0.02 * (i % 7)) for i in range(168)))
    subprocess.run(["build/matrig", "--quiet", "landing", db, "1", "--observe", "wave", "--station", "91", "--panels", "2", "--who", "jk"], timeout=60, check=True,
                   stdout=subprocess.DEVNULL)


def make_hostile(path):
    """Every text column of every table, but those whose words the program itself gives a meaning to, gets markup; returns how many."""
    db, changed = sqlite3.connect(path), 0
    spared = {("events", "kind"), ("gaps", "message"), ("gaps", "cause"), ("configurations", "text"), ("missing", "message"),
              ("readiness", "kind"), ("readiness", "checks"), ("readiness", "verdict"), ("gage_surveys", "pattern"), ("gage_surveys", "edges"), ("gage_readings", "kind")}
    for (trigger,) in db.execute("select name from sqlite_schema where type = 'trigger'").fetchall():
        db.execute("drop trigger " + trigger)  # those by which history stays
    for (table,) in db.execute("select name from sqlite_schema where type = 'table' and name not like 'sqlite_%'").fetchall():
        for column in db.execute("pragma table_info(%s)" % table).fetchall():
            if "TEXT" in column[2] and (table, column[1]) not in spared:
                changed += db.execute("update or ignore %s set %s = ?" % (table, column[1]), (HOSTILE,)).rowcount
    db.commit()
    db.close()
    return changed


SECTIONS = ["summary", "cumulative", "zones", "tension", "record", "predictor", "compared", "journal", "survey", "run1", "run2", "provenance"]
PICTURES = ["cumulative displacement", "peak movement", "zones of each landing", "average change of band tension", "opening of joints", "speed and deceleration",
            "displacement of eight", "displacement against distance", "zone map", "zone that the board told of", "band tensions", "change of tension along", "movement of the mat, measured and simulated"]
# Text of a picture that another text covers, or that leaves its picture; a number or name must be readable.
COVERED = """(() => { const bad = [];
  for (const svg of document.querySelectorAll('svg[role=img]')) {
    const all = [...svg.querySelectorAll('text')].filter(t => t.textContent.trim()).map(t => [t, t.getBoundingClientRect()]);
    const s = svg.getBoundingClientRect();
    for (let i = 0; i < all.length; i++) {
      const [t, r] = all[i];
      if (r.left < s.left - 1 || r.right > s.right + 1 || r.top < s.top - 1 || r.bottom > s.bottom + 1) bad.push('outside: ' + svg.ariaLabel + ': ' + t.textContent);
      for (let k = i + 1; k < all.length; k++) {
        const q = all[k][1], w = Math.min(r.right, q.right) - Math.max(r.left, q.left), h = Math.min(r.bottom, q.bottom) - Math.max(r.top, q.top);
        if (w > 2 && h > 4) bad.push('covered: ' + svg.ariaLabel + ': ' + t.textContent + ' by ' + all[k][0].textContent);
      }
    }
  }
  return bad; })()"""


def make_page(db, name, *options):
    page = work + "/" + name
    done = subprocess.run(["build/matrig", "--quiet", *[o for o in options if o == "--si"], "report", db, "-o", page, *[o for o in options if o != "--si"]],
                          timeout=120, capture_output=True, text=True)
    tap.check("the report is made: " + " ".join([name, *options[:1]]), done.returncode == 0, done.stderr)
    return page


def show(browser, page):
    browser.requests.clear()
    browser.errors.clear()
    address = pathlib.Path(page).as_uri()  # a folder's name may have a blank in it
    browser.open(address)
    time.sleep(0.5)
    browser.pump()
    tap.check("it asks for nothing but itself", [u for u in browser.requests if not u.startswith("data:")] == [address], browser.requests)
    tap.check("nothing wrong on the console", not browser.errors, browser.errors)


def check_hostile(browser, db):
    page = make_page(db, "report.html")
    show(browser, page)
    tap.check("nothing hostile ran, or became an element", not browser.dialogs and browser.js("document.querySelectorAll('script, img, iframe, object, embed, link').length") == 0 and
              browser.js("document.querySelectorAll('style').length") == 1, browser.dialogs)
    source = open(page).read()
    tap.check("and the markup is told, escaped", "&lt;script&gt;" in source and "<script" not in source.lower(), re.findall(".{80}alert.{40}", source)[:3])
    facts = browser.js("document.body.innerText")
    tap.check("touchdown speed and stop are there", re.search(r"35\.4\d+ ± 0\.0\d+ ft/s", facts) and re.search(r"90\.\d+", facts), facts[:1200])
    sections = browser.js("[...document.querySelectorAll('section')].map(s => s.id)")
    tap.check("every section is there", sections == SECTIONS, sections)
    pictures = browser.js("[...document.querySelectorAll('svg[role=img]')].map(s => s.ariaLabel)")
    tap.check("and every picture", all(any(p.startswith(name) for p in pictures) for name in PICTURES), pictures)
    tap.check("links stay in the page", browser.js("[...document.querySelectorAll('a')].every(a => a.getAttribute('href')[0] === '#' && "
                                                   "document.getElementById(a.getAttribute('href').slice(1)))"))
    browser.picture(OUT + "/report.png")


def check_looks(browser, db):
    for options in ((), ("--si",)):
        show(browser, make_page(db, "looks.html", *options))
        bad = browser.js(COVERED)
        tap.check("all that is written in pictures can be read", not bad, bad[:12])
        numbers = browser.js("[...document.querySelectorAll('svg[role=img] path')].filter(p => /nan|inf/i.test(p.getAttribute('d'))).length")
        tap.check("and nothing is drawn nowhere", numbers == 0, numbers)


def check_print(browser, db):
    """On paper: white, even where dark is asked for; the landings on pages of their own; lines told apart without colour."""
    show(browser, make_page(db, "print.html"))
    browser.call("Emulation.setEmulatedMedia", {"media": "print", "features": [{"name": "prefers-color-scheme", "value": "dark"}]})
    tap.check("paper is white", browser.js("getComputedStyle(document.body).backgroundColor") in ("rgb(255, 255, 255)", "rgba(255, 255, 255, 1)"),
              browser.js("getComputedStyle(document.body).backgroundColor"))
    tap.check("a landing begins a page", browser.js("getComputedStyle(document.querySelector('#run2')).breakBefore") == "page")
    dashes = browser.js("['s0', 's1', 's2', 's3', 's4', 's5'].map(c => { const p = document.createElementNS('http://www.w3.org/2000/svg', 'path'); "
                        "p.setAttribute('class', 'line ' + c); document.querySelector('svg').append(p); return getComputedStyle(p).strokeDasharray; })")
    tap.check("each line has a dash of its own", len(set(dashes)) == 6, dashes)
    pdf = base64.b64decode(browser.call("Page.printToPDF", {"printBackground": False})["data"])
    tap.check("the browser prints it", pdf[:5] == b"%PDF-" and len(re.findall(rb"/Type\s*/Page\b", pdf)) >= 6, len(pdf))
    browser.call("Emulation.setEmulatedMedia", {"media": "", "features": []})


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
    two, clean = work + "/<i>two.db", work + "/clean.db"
    shutil.copy(db, two)
    subprocess.run(["python3", "tests/report/grow.py", two, "2"], check=True, timeout=60)
    shutil.copy(two, clean)
    make_hostile(two)
    changed = make_hostile(db)
    tap.check("%d texts are hostile" % changed, changed >= 8)
    browser = Browser()
    try:
        check_hostile(browser, two)
        check_looks(browser, clean)
        check_print(browser, clean)
        check_live(browser, db)
    finally:
        browser.close()
        shutil.rmtree(work, ignore_errors=True)
    return tap.end()


sys.exit(main())
