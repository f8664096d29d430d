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
              ("readiness", "kind"), ("readiness", "checks"), ("readiness", "verdict"), ("gage_surveys", "edges"), ("gage_readings", "kind")}
    triggers = db.execute("select name, sql from sqlite_schema where type = 'trigger'").fetchall()
    for trigger, _ in triggers:
        db.execute("drop trigger " + trigger)  # those by which history stays
    for (table,) in db.execute("select name from sqlite_schema where type = 'table' and name not like 'sqlite_%'").fetchall():
        for column in db.execute("pragma table_info(%s)" % table).fetchall():
            if "TEXT" in column[2] and (table, column[1]) not in spared:
                changed += db.execute("update or ignore %s set %s = ?" % (table, column[1]), (HOSTILE,)).rowcount
    for _, sql in triggers:
        db.execute(sql)
    db.commit()
    db.close()
    return changed


SECTIONS = ["summary", "cumulative", "zones", "overlay", "tension", "record", "predictor", "compared", "journal", "survey", "run1", "run2", "provenance"]
FIGURES = ["cumulative displacement", "peak movement", "zones of each landing", "average change of band tension", "opening of joints", "speed and deceleration",
           "displacement of eight", "two landings in one plot", "displacement against distance", "zone map", "zone that the board reported", "band tensions", "change of tension along",
           "movement of the mat, measured and simulated"]
# Of each figure that is on the screen, by its plots: pixels of any colour in the lower canvas.
DRAWN = """(() => [...document.querySelectorAll('figure.chart')].map(f => [f.getAttribute('aria-label'), [...f.querySelectorAll('.box')].map(b => {
  const c = b.querySelector('canvas');
  if (!c) return 0;
  const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
  let n = 0;
  for (let i = 3; i < d.length; i += 4) n += d[i] > 0;
  return n; })]))()"""


def whole(browser, width=1120):
    """The page as high as it is, so that every plot is on the screen, and what is drawn there."""
    browser.size(width, browser.js("document.documentElement.scrollHeight") + 2000)
    browser.wait("[...document.querySelectorAll('figure.chart .plots')].every(p => p.querySelector('.box canvas'))")
    return browser.js(DRAWN)


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
    tap.check("nothing hostile ran, or became an element", not browser.dialogs and browser.js("document.querySelectorAll('script:not([type]), img, iframe, object, embed, link').length") == 1 and
              browser.js("document.querySelector('script:not([type])').parentNode === document.body && [...document.querySelectorAll('script')].every(s => !s.src)") and
              browser.js("document.querySelectorAll('style').length") == 1, browser.dialogs)
    source = open(page).read()
    tap.check("and the markup is told, escaped", "&lt;script&gt;" in source and source.lower().count("<script") == source.count('<script type="application/json">{') + 1, re.findall(".{80}alert.{40}", source)[:3])
    facts = browser.js("document.body.innerText")
    tap.check("touchdown speed and stop are there", re.search(r"35\.4\d+ ± 0\.0\d+ ft/s", facts) and re.search(r"90\.\d+", facts), facts[:1200])
    tap.check("units and errors are written as on paper", "ft/s²" in facts and "/s2" not in facts and "+-" not in facts, re.findall(r".{30}(?:/s2|\+-).{10}", facts)[:3])
    sections = browser.js("[...document.querySelectorAll('section')].map(s => s.id)")
    tap.check("every section is there", sections == SECTIONS, sections)
    figures = whole(browser)
    tap.check("and every figure, drawn", all(any(f.startswith(name) for f, _ in figures) for name in FIGURES) and all(plots and min(plots) > 50 for _, plots in figures), figures)
    tap.check("links stay in the page", browser.js("[...document.querySelectorAll('a')].every(a => a.getAttribute('href')[0] === '#' && "
                                                   "document.getElementById(a.getAttribute('href').slice(1)))"))
    browser.picture(OUT + "/report.png")


NUMBERS = "[...document.querySelectorAll('.dygraph-axis-label')].map(e => e.textContent)"


def check_looks(browser, db):
    for options in ((), ("--si",)):
        show(browser, make_page(db, "looks.html", *options))
        whole(browser)
        bad = browser.js(NUMBERS + ".filter(t => /nan|inf|undefined/i.test(t))")
        tap.check("numbers at the axes are numbers", not bad, bad[:12])
        wide = browser.js("[...document.querySelectorAll('.plot')].filter(p => p.querySelector('canvas').getBoundingClientRect().right > p.getBoundingClientRect().right + 1).length")
        tap.check("a plot is no wider than its place", wide == 0, wide)
        bare = browser.js("[...document.querySelectorAll('figure.chart .plot')].filter(p => !/ \\(|mats|^$/.test(p.querySelector('.unit').textContent)).map(p => p.innerText)")
        tap.check("what a plot shows has its unit beside it", not bare, bare[:3])


def check_overlay(browser, db):
    """Two landings on one axis: each plot has a line of each, the keys name them, and another choice draws anew."""
    show(browser, make_page(db, "overlay.html"))
    whole(browser)
    tap.check("each landing begins with its outcome, and is marked as emulated", browser.js(
        "[...document.querySelectorAll('.landing')].every(l => /\\(emulated board, synthetic data\\)$/.test(l.children[0].textContent) && /^Outcome: /.test(l.children[1].textContent) && l.children[2].children.length === 5)"))
    both = "document.querySelector('#overlay')"
    keys = both + ".querySelector('.keys').textContent"
    tap.check("two landings are on one axis", browser.js(keys) == "RUN 1RUN 2" and browser.js(both + ".querySelectorAll('.plot').length") == 9, browser.js(keys))
    browser.js("(() => { const c = document.querySelector('#overlay select'); c.value = 1; c.dispatchEvent(new Event('change')); })()")
    tap.check("another choice is drawn", browser.wait(keys + " === 'RUN 2'") and browser.wait(both + ".querySelectorAll('canvas').length >= 18"), browser.js(keys))


def plot(label, at=0):
    return "[...document.querySelectorAll('figure.chart')].filter(f => f.getAttribute('aria-label').startsWith('%s')).pop().querySelectorAll('.plot')[%d]" % (label, at)


def mouse(browser, kind, x, y, **more):
    browser.call("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, **more})


def check_plots(browser, db):
    """The pointer has the values that were drawn there; a range that is dragged over fills the plot, and those beside it; a double click gives it back."""
    show(browser, make_page(db, "plots.html"))
    whole(browser)
    browser.size(1120, 1600)
    speed = plot("speed and deceleration")
    browser.js(speed + ".scrollIntoView({block: 'center'})")
    browser.wait(speed + ".querySelector('canvas') && true")
    left, top, width, height = browser.js("(() => { const r = %s.querySelector('.box').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; })()" % speed)
    mouse(browser, "mouseMoved", left + 0.5 * width, top + 0.5 * height)
    said = browser.js(speed + ".querySelector('output').textContent")
    found = re.match(r"([0-9.]+): curve with 95 % band ([0-9.]+)", said)
    run = sqlite3.connect(db).execute("select min(board_us) from edges where landing = 2").fetchone()
    tap.check("the pointer has the values that were drawn there", run and found and 0.0 < float(found[1]) < 6.0 and 0.0 < float(found[2]) < 40.0, said)
    others = browser.js("[0, 1, 2].map(i => %s.parentNode.children[i].querySelector('output').textContent.split(':')[0])" % speed)
    tap.check("and so have the plots that share its axis", len(set(others[:2])) == 1, others)
    labels = "[...%s.querySelectorAll('.dygraph-axis-label-x')].map(e => Number(e.textContent))" % speed
    before = browser.js(labels)
    mouse(browser, "mousePressed", left + 0.4 * width, top + 0.5 * height, button="left", clickCount=1)
    mouse(browser, "mouseMoved", left + 0.6 * width, top + 0.5 * height, button="left", buttons=1)
    mouse(browser, "mouseReleased", left + 0.6 * width, top + 0.5 * height, button="left", clickCount=1)
    zoomed, below = browser.js(labels), browser.js(labels.replace(speed, plot("speed and deceleration", 1)))
    span = max(before) - min(before)
    tap.check("a range that is dragged over fills the plot, and those below it", zoomed == below and max(zoomed) - min(zoomed) < 0.35 * span, before, zoomed, below)
    browser.picture(OUT + "/plots-zoomed.png")
    for count in (1, 2):
        for kind in ("mousePressed", "mouseReleased"):
            mouse(browser, kind, left + 0.5 * width, top + 0.5 * height, button="left", clickCount=count)
    tap.check("a double click gives it back", browser.js(labels) == before, browser.js(labels))
    browser.pump()
    tap.check("and all that asks for nothing, and is refused nothing", not browser.errors and len([u for u in browser.requests if not u.startswith("data:")]) == 1,
              browser.errors, browser.requests)


def drawn_on_pages(path):
    """How far down each page of a PDF something is drawn above its page number, as a share of its height; upright pages alone."""
    pages = subprocess.run(["pdftoppm", "-r", "30", "-gray", path], check=True, capture_output=True).stdout
    drawn = []
    while pages:
        kind, size, most, pixels = pages.split(b"\n", 3)
        width, height = (int(v) for v in size.split())
        assert kind == b"P5" and most == b"255"
        rows = [r for r in range(int(0.94 * height)) if min(pixels[r * width:(r + 1) * width]) < 220]
        drawn.append((max(rows) + 1) / height if rows and height > width else 0.0)
        pages = pixels[width * height:]
    return drawn


# What a reader looks for first, and how a browser shows it: the first screen, before anything is scrolled.
FIRST = ["date (UTC)", "place", "runway", "series", "landings", "operator", "gear weight", "touchdown speed", "stop", "largest movement", "zone warned of",
         "warnings by outcome", "what went wrong"]


def check_front(browser, db):
    show(browser, make_page(db, "front.html"))
    for width, height in ((1200, 900), (800, 1100), (390, 844)):
        browser.size(width, height)
        shown = browser.js("[...document.querySelectorAll('.cover dt')].map(t => [t.textContent, t.nextSibling.innerText, t.parentNode.getBoundingClientRect().bottom, "
                           "parseFloat(getComputedStyle(t.nextSibling).fontSize)])")
        first = {term: (text, bottom, size) for term, text, bottom, size in shown}
        tap.check("the first screen of %d points says it" % width, all(t in first and first[t][0].strip() and first[t][1] <= height and first[t][2] >= 14 for t in FIRST), shown)
        # The page resizes its plots in the frame after the new size.
        fits = browser.wait("document.documentElement.scrollWidth <= %d" % width)
        tap.check("the page is no wider than %d" % width, fits, browser.js("document.documentElement.scrollWidth"))
    drawn = whole(browser, 390)
    tap.check("plots are drawn on a telephone, within its width", all(min(plots) > 50 for _, plots in drawn) and browser.js("document.documentElement.scrollWidth") <= 390, drawn)
    browser.picture(OUT + "/report-390.png")
    links = browser.js("[...document.querySelectorAll('.cover a, #summary a')].map(a => a.href)")
    tap.check("the front leads to its landings", links and {l.split("#")[1] for l in links} == {"run1", "run2"}, links)


def check_print(browser, db):
    """On paper: white, even where dark is asked for; no page nearly empty; lines told apart without colour."""
    show(browser, make_page(db, "print.html"))
    browser.call("Emulation.setEmulatedMedia", {"media": "print", "features": [{"name": "prefers-color-scheme", "value": "dark"}]})
    tap.check("paper is white", browser.js("getComputedStyle(document.body).backgroundColor") in ("rgb(255, 255, 255)", "rgba(255, 255, 255, 1)"),
              browser.js("getComputedStyle(document.body).backgroundColor"))
    for name, paper in (("letter", {}), ("A4", {"paperWidth": 8.27, "paperHeight": 11.69}), ("A4 turned", {"paperWidth": 8.27, "paperHeight": 11.69, "landscape": True})):
        pdf = base64.b64decode(browser.call("Page.printToPDF", {"printBackground": False, **paper}, 200)["data"])
        with open("%s/%s.pdf" % (OUT, name), "wb") as out:
            out.write(pdf)
        drawn = drawn_on_pages(out.name)
        tap.check("the browser prints it on " + name, pdf[:5] == b"%PDF-" and len(drawn) >= 6, len(pdf), drawn)
        empty = sum(1 for d in drawn[:-1] if 0.0 < d <= 0.45)
        tap.check("no page is nearly empty, upright, but the last of each part", drawn and empty <= 3, drawn)
        text = subprocess.run(["pdftotext", "-layout", out.name, "-"], check=True, capture_output=True, text=True).stdout.split("\f")[:-1]
        tap.check("each page has its number, and that the board was emulated", all("%d of %d" % (n + 1, len(text)) in t and "EMULATED BOARD, SYNTHETIC DATA" in t
                                                                                for n, t in enumerate(text)), text[:2])
        tap.check("each landing begins a page", all(sum(bool(re.search(r"\A\s*EMULATED[^\n]*\s+RUN %d: landing" % run, t)) for t in text) == 1 for run in (1, 2)), text)
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
        tap.check("its last state is shown", browser.wait("document.querySelector('#state-big').textContent === 'IDLE' && document.querySelector('#board-big').textContent === 'ended'"),
                  browser.js("document.body.innerText"))
        tap.check("an ended campaign is no alarm, and known as emulated", browser.js("!document.querySelector('.tile.bad')") and
                  browser.js("document.querySelector('#marks').textContent") == "EMULATED BOARD, SYNTHETIC DATA", browser.js("document.querySelector('header').innerText"))
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
        check_overlay(browser, clean)
        check_live(browser, db)
    finally:
        browser.close()
        shutil.rmtree(work, ignore_errors=True)
    return tap.end()


sys.exit(main())
