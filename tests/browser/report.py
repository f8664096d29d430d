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
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from cdp import Browser, Tap  # noqa: E402
from closer import check_closer  # noqa: E402

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
    tap.check("nothing hostile ran, or became an element", not browser.dialogs and browser.js("document.querySelectorAll('script, img, iframe, object, embed, link').length") == 1 and
              browser.js("document.querySelector('script').parentNode === document.body && !document.querySelector('script').src") and
              browser.js("document.querySelectorAll('style').length") == 1, browser.dialogs)
    source = open(page).read()
    tap.check("and the markup is told, escaped", "&lt;script&gt;" in source and source.lower().count("<script") == 1, re.findall(".{80}alert.{40}", source)[:3])
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


def drawn_on_pages(pdf):
    """How far down each page of a PDF of the browser something is drawn, as a share of its height. Lowest places of text and lines, by the
    matrices of its content streams (PDF 32000-1, 8.3.4 and 9.4.2: cm, q, Q, Tm, m, l, re)."""
    bodies = {int(n): body for n, body in re.findall(rb"(?:^|\n)(\d+) 0 obj\s(.*?)endobj", pdf, re.S)}
    drawn = []
    for body in bodies.values():
        if not re.search(rb"/Type\s*/Page\b", body):
            continue
        left, bottom, right, top = (float(v) for v in re.search(rb"/MediaBox\s*\[([^]]*)\]", body).group(1).split())
        stream = re.search(rb"stream\r?\n(.*?)\r?\nendstream", bodies[int(re.search(rb"/Contents\s+(\d+)", body).group(1))], re.S).group(1)
        assert top > bottom and right > left
        # decompressobj: when the data's last byte looks like the end of a line, it was taken for one
        drawn.append(1.0 - (lowest(zlib.decompressobj().decompress(stream).decode("latin-1")) - bottom) / (top - bottom) if top > right - left else 0.0)
    return drawn


def lowest(content):
    at, kept, values, low = (1, 0, 0, 1, 0, 0), [], [], 1e9
    for word in re.findall(r"\((?:\\.|[^\\)])*\)|<[0-9A-Fa-f]*>|[^\s()<>\[\]]+", content):
        if re.fullmatch(r"[-+.0-9]+", word):
            values.append(float(word))
            continue
        if word == "cm" and len(values) >= 6:
            a, b, c, d, e, f = values[-6:]
            at = (a * at[0] + b * at[2], a * at[1] + b * at[3], c * at[0] + d * at[2], c * at[1] + d * at[3],
                  e * at[0] + f * at[2] + at[4], e * at[1] + f * at[3] + at[5])
        elif word == "q":
            kept.append(at)
        elif word == "Q" and kept:
            at = kept.pop()
        elif word in ("Tm", "l") and len(values) >= 2: # a clip of the whole page is an re and draws nothing
            low = min(low, at[1] * values[-2] + at[3] * values[-1] + at[5])
        values = []
    return low


# What a reader looks for first, and how a browser shows it: the first screen, before anything is scrolled.
FIRST = ["date (UTC)", "place", "runway", "series", "landings", "operator", "gear weight", "touchdown speed", "stop", "largest movement", "zones warned of",
         "warnings, by what came", "what went wrong"]


def check_front(browser, db):
    show(browser, make_page(db, "front.html"))
    for width, height in ((1200, 900), (800, 1100), (390, 844)):
        browser.size(width, height)
        shown = browser.js("[...document.querySelectorAll('.cover dt')].map(t => [t.innerText, t.nextSibling.innerText, t.parentNode.getBoundingClientRect().bottom, "
                           "parseFloat(getComputedStyle(t.nextSibling).fontSize)])")
        first = {term: (text, bottom, size) for term, text, bottom, size in shown}
        tap.check("the first screen of %d points says it" % width, all(t in first and first[t][0].strip() and first[t][1] <= height and first[t][2] >= 14 for t in FIRST), shown)
        wide = browser.js("document.documentElement.scrollWidth")
        tap.check("the page is no wider than %d" % width, wide <= width, wide)
    small = browser.js("[...document.querySelectorAll('svg[role=img]')].map(s => [s.ariaLabel, 11 * s.getBoundingClientRect().width / s.viewBox.baseVal.width])"
                       ".filter(p => p[1] < 8)")
    tap.check("words in its plots can be read on a telephone", not small, small)
    browser.picture(OUT + "/report-390.png")
    links = browser.js("[...document.querySelectorAll('.cover a, #summary a')].map(a => a.href)")
    tap.check("the front leads to its landings", links and {l.split("#")[1] for l in links} == {"run1", "run2"}, links)


def check_print(browser, db):
    """On paper: white, even where dark is asked for; no page nearly empty; lines told apart without colour."""
    show(browser, make_page(db, "print.html"))
    browser.call("Emulation.setEmulatedMedia", {"media": "print", "features": [{"name": "prefers-color-scheme", "value": "dark"}]})
    tap.check("paper is white", browser.js("getComputedStyle(document.body).backgroundColor") in ("rgb(255, 255, 255)", "rgba(255, 255, 255, 1)"),
              browser.js("getComputedStyle(document.body).backgroundColor"))
    dashes = browser.js("['s0', 's1', 's2', 's3', 's4', 's5'].map(c => { const p = document.createElementNS('http://www.w3.org/2000/svg', 'path'); "
                        "p.setAttribute('class', 'line ' + c); document.querySelector('svg').append(p); return getComputedStyle(p).strokeDasharray; })")
    tap.check("each line has a dash of its own", len(set(dashes)) == 6, dashes)
    for name, paper in (("letter", {}), ("A4", {"paperWidth": 8.27, "paperHeight": 11.69}), ("A4 turned", {"paperWidth": 8.27, "paperHeight": 11.69, "landscape": True})):
        pdf = base64.b64decode(browser.call("Page.printToPDF", {"printBackground": False, **paper})["data"])
        drawn = drawn_on_pages(pdf)
        tap.check("the browser prints it on " + name, pdf[:5] == b"%PDF-" and len(drawn) >= 6, len(pdf), drawn)
        tap.check("no page but the last is nearly empty, upright", drawn and min(drawn[:-1]) > 0.5, drawn)
    browser.call("Emulation.setEmulatedMedia", {"media": "", "features": []})


def check_plots(browser, db):
    show(browser, make_page(db, "closer.html"))
    check_closer(tap, browser, db, OUT)


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
        check_front(browser, clean)
        check_print(browser, clean)
        check_plots(browser, clean)
        check_live(browser, db)
    finally:
        browser.close()
        shutil.rmtree(work, ignore_errors=True)
    return tap.end()


sys.exit(main())
