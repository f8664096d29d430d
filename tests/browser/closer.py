"""The report's plots looked at closer: values that the cursor tells against the exported readings and `matrig show`, zoom, and the way back.
By mouse, finger and key, as a person does it."""
import json
import re
import subprocess

MOVED, ALONG, SPEED, TENSIONS = ["[...document.querySelectorAll('#run1 svg')].find(s => s.ariaLabel.startsWith('%s'))" % label for label in
                                 ("displacement of eight", "change of tension along", "speed and deceleration", "band tensions")]
SAID = "[...document.querySelectorAll('.closer-box:not([hidden]) > *')].map(e => e.textContent)"
TICKS = "[...%s.querySelectorAll('g.tick[text-anchor=middle]')].filter(g => getComputedStyle(g).display !== 'none').map(g => [...g.children].map(t => [Number(t.textContent), t.getBBox().x + t.getBBox().width / 2]))"


class Closer:
    def __init__(self, tap, browser, out):
        self.tap, self.browser, self.out = tap, browser, out

    def frame(self, svg, panel):
        """Left, top, width and height of a plot, in the window."""
        self.browser.js("%s.scrollIntoView({block: 'center', behavior: 'instant'})" % svg)
        return self.browser.js("(() => { const r = %s.querySelectorAll('rect.frame')[%d].getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; })()" % (svg, panel))

    def mouse(self, kind, x, y, **more):
        self.browser.call("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, **more})

    def hover(self, svg, panel, share, down=0.5):
        left, top, width, height = self.frame(svg, panel)
        self.mouse("mouseMoved", left + share * width, top + down * height)
        return self.browser.js(SAID)

    def drag(self, svg, panel, share, to):
        left, top, width, height = self.frame(svg, panel)
        y = top + 0.5 * height
        self.mouse("mouseMoved", left + share * width, y)
        self.mouse("mousePressed", left + share * width, y, button="left", clickCount=1)
        self.mouse("mouseMoved", left + to * width, y, button="left", buttons=1)
        self.mouse("mouseReleased", left + to * width, y, button="left", clickCount=1)

    def press(self, key):
        code = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Home": 36, "End": 35, "Escape": 27, "+": 187, "-": 189}[key]
        for kind in ("keyDown", "keyUp"):
            self.browser.call("Input.dispatchKeyEvent", {"type": kind, "key": key, "windowsVirtualKeyCode": code, **({"text": key} if key in "+-" and kind == "keyDown" else {})})

    def markup(self, svg):
        return self.browser.js("%s.outerHTML" % svg)

    def whole(self, svg):
        """As if nothing had been looked at: the picture but the cursor."""
        return re.sub(r'<g class="closer closer-cursor">.*?</g>', "", self.markup(svg))


def number(pattern, lines):
    for line in lines:
        found = re.match(pattern, line)
        if found:
            return [float(g) for g in found.groups() if g is not None]
    return None


def readings(csv):
    """Gear position and the eight displacements, row by row, as exported."""
    lines = [line for line in csv.splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    columns = [names.index("gear_ft")] + [names.index("d%d_in" % (i + 1)) for i in range(8)]
    return [[float(cells[c]) if cells[c] else None for c in columns] for cells in (line.split(",") for line in lines[1:])]


def check_values(closer, db):
    rows = readings(subprocess.run(["build/matrig", "--quiet", "export", db, "1", "--format", "csv"], check=True, timeout=60, capture_output=True, text=True).stdout)
    right, told = 0, []
    for transducer, gear_ft in ((1, 41.0), (2, 55.0), (4, 72.0), (5, 79.5), (6, 88.0)):
        said = closer.hover(MOVED, transducer - 1, gear_ft / 120)
        at, value = number(r"gear position (\S+) ft", said), number(r"measured: (-?[\d.]+) in(?: at ([\d.]+) ft)?", said)
        told.append((transducer, said))
        if not at or not value or abs(at[0] - gear_ft) > 1.5:
            continue
        x_ft, y_in = value[1] if len(value) > 1 else at[0], value[0]
        # a tenth of a pixel of 232 for 120 ft, and the same of 150 for what is drawn upwards: 1 in at most
        near = [row[transducer] for row in rows if row[0] is not None and row[transducer] is not None and abs(row[0] - x_ft) <= 0.04]
        right += any(abs(v - y_in) <= 0.0008 for v in near)
    closer.tap.check("the cursor tells what was read where the wheel was", right == 5, right, *told)
    shown = json.loads(subprocess.run(["build/matrig", "--json", "show", db, "1"], check=True, timeout=60, capture_output=True, text=True).stdout)
    gages, good = [g for g in shown["tensions"] if g["band"] == 1], 0
    for gage in gages:
        said = closer.hover(ALONG, 0, gage["station_ft"] / 120)
        value = number(r"least: (-?[\d.]+) ± ([\d.]+) lb \(95 %\)$", said)
        told.append((gage["number"], said))
        good += bool(value) and abs(value[0] - (gage["least_lb"] - gage["before_lb"])) < 0.03 and abs(value[1] - 1.96 * gage["least_error_lb"]) < 0.06
    closer.tap.check("and the error that is drawn, at every gage", gages and good == len(gages), good, *told[5:])


def check_zoom(closer):
    browser, tap = closer.browser, closer.tap
    before, ticks = closer.markup(SPEED), browser.js(TICKS % SPEED)[-1]
    closer.drag(SPEED, 0, 0.4, 0.6)
    near = browser.js(TICKS % SPEED)[-1]
    per_s = (ticks[-1][1] - ticks[0][1]) / (ticks[-1][0] - ticks[0][0])  # pixels, as the page had it
    zero_px = ticks[0][1] - per_s * ticks[0][0]
    frame = browser.js("(() => { const b = %s.querySelector('rect.frame').getBBox(); return [b.x, b.width]; })()" % SPEED)
    low_s, high_s = [(frame[0] + share * frame[1] - zero_px) / per_s for share in (0.4, 0.6)]
    should = [frame[0] + frame[1] * (value - low_s) / (high_s - low_s) for value, _ in near]
    tap.check("a range that is dragged over fills the plot, its ticks where they belong", len(near) >= 4 and near[0][0] >= low_s - 0.01 and near[-1][0] <= high_s + 0.01 and
              near[1][0] - near[0][0] < ticks[1][0] - ticks[0][0] and all(abs(px - at) < 1.5 for (_, px), at in zip(near, should)), near, should)
    tap.check("the plots below it too", len(browser.js("[...%s.querySelectorAll('.closer-view')]" % SPEED)) == 3)
    said = closer.hover(SPEED, 0, 0.5)
    middle = number(r"time since touchdown (\S+) s", said)
    tap.check("the cursor tells the time that is shown there", middle and abs(middle[0] - (low_s + high_s) / 2) < 0.15, said, low_s, high_s)
    closer.browser.picture(closer.out + "/closer-zoomed.png")
    browser.media("print")
    tap.check("on paper nothing of it", browser.js("[...%s.querySelectorAll('[data-away]')].every(e => getComputedStyle(e).display !== 'none') && getComputedStyle(%s.querySelector('.closer-view')).display === 'none' && "
                                                   "getComputedStyle(document.querySelector('.closer-box')).display === 'none'" % (SPEED, SPEED)))
    browser.media("screen")
    closer.press("Escape")
    tap.check("Escape gives the same picture back", closer.markup(SPEED) == before)
    closer.drag(SPEED, 0, 0.2, 0.3)
    left, top, width, height = closer.frame(SPEED, 0)
    for count in (1, 2):
        for kind in ("mousePressed", "mouseReleased"):
            closer.mouse(kind, left + 0.5 * width, top + 0.5 * height, button="left", clickCount=count)
    tap.check("and so does a double click", closer.whole(SPEED) == before)
    closer.mouse("mouseWheel", left + 0.5 * width, top + 0.5 * height, deltaX=0, deltaY=-120)
    tap.check("the wheel zooms a picture that was clicked", browser.wait("%s.querySelector('.closer-view') !== null" % SPEED))
    closer.press("Escape")


def check_ticks(closer):
    """Nearly all of a plot has the ticks that all of it has, where none stands at its edge: chosen as the page's were."""
    browser, tap = closer.browser, closer.tap
    same = browser.js("""(() => { let same = 0; const wrong = [];
      for (const svg of document.querySelectorAll('svg.closer-on')) {
        const seen = () => [...svg.querySelectorAll('g.tick, .closer-view > g.tick')].filter(g => getComputedStyle(g).display !== 'none')
          .map(g => [...g.children].map(t => t.textContent).join(' ')).sort().join('|');
        const before = seen(), box = svg.querySelector('rect.frame[data-x]'), b = box.getBBox();
        if ([...svg.querySelectorAll('g.tick[text-anchor=middle] text')].some(t => [b.x, b.x + b.width].some(x => Math.abs(t.getAttribute('x') - x) < 1))) continue;
        const r = box.getBoundingClientRect(), y = r.top + r.height / 2;
        const send = (type, x) => svg.dispatchEvent(new PointerEvent(type, {clientX: x, clientY: y, pointerId: 1, pointerType: 'pen', bubbles: true}));
        svg.setPointerCapture = () => {};
        send('pointerdown', r.left + 0.0002 * r.width); send('pointermove', r.right - 0.0002 * r.width); send('pointerup', r.right - 0.0002 * r.width);
        const zoomed = svg.querySelector('.closer-view'), after = seen();
        svg.dispatchEvent(new KeyboardEvent('keydown', {key: 'Escape'}));
        if (zoomed && (before === after || after.split('|').every(t => before.split('|').some(b => b.includes(t))))) same++; else wrong.push([svg.ariaLabel, before, after]);
      }
      return [same, wrong]; })()""")
    tap.check("nearly the whole range has the same numbers at its ticks", same[0] >= 6 and not same[1], same)


def check_keys(closer):
    browser, tap = closer.browser, closer.tap
    before = closer.markup(TENSIONS)
    closer.mouse("mouseMoved", 1, 1)
    browser.js("%s.focus()" % TENSIONS)
    closer.press("Home")
    first = browser.js(SAID)
    closer.press("ArrowRight")
    second = browser.js(SAID)
    closer.press("ArrowDown")
    other = browser.js(SAID)
    time_s = [number(r"time since touchdown (\S+) s", said) for said in (first, second, other)]
    tap.check("arrows go from point to point, and from plot to plot", all(time_s) and time_s[0][0] < time_s[1][0] and first[0] == second[0] != other[0], first, second, other)
    ticks = len(browser.js(TICKS % TENSIONS)[0])
    closer.press("+")
    closer.press("+")
    tap.check("+ zooms in", browser.js("%s.querySelector('.closer-view') !== null" % TENSIONS), ticks)
    closer.press("-")
    closer.press("-")
    tap.check("- zooms out, to the same picture", closer.whole(TENSIONS) == before)
    closer.press("Escape")
    tap.check("Escape takes the cursor away", closer.markup(TENSIONS) == before and not browser.js(SAID))


def check_fingers(closer):
    browser, tap = closer.browser, closer.tap
    browser.size(390, 844)
    browser.call("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 2})
    left, top, width, height = closer.frame(SPEED, 0)
    y = top + 0.5 * height
    middle = (195 - left) / width  # of the window: a plot is wider, and scrolls

    def touch(kind, *shares):
        browser.call("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": left + s * width, "y": y, "id": i} for i, s in enumerate(shares)]})

    touch("touchStart", middle)
    said = browser.js(SAID)
    inside = browser.js("(() => { const r = document.querySelector('.closer-box').getBoundingClientRect(), s = %s.getBoundingClientRect(); return [r.left >= 0, r.right <= innerWidth, r.top >= 0, "
                        "r.bottom <= innerHeight, r.top >= s.bottom || r.bottom <= s.top, r.top, r.bottom, s.top, s.bottom]; })()" % SPEED)
    tap.check("a finger has the cursor, its values in the window and beside the picture", number(r"time since touchdown (\S+) s", said) and all(inside[:5]), said, inside)
    browser.picture(closer.out + "/closer-390.png")
    touch("touchStart", middle - 0.05, middle + 0.05)
    touch("touchMove", middle - 0.12, middle + 0.12)
    tap.check("two fingers zoom", browser.wait("%s.querySelector('.closer-view') !== null" % SPEED))
    touch("touchEnd")
    browser.call("Emulation.setTouchEmulationEnabled", {"enabled": False})
    browser.js("%s.focus()" % SPEED)
    closer.press("Escape")
    browser.size(1120, 1600)


def check_closer(tap, browser, db, out):
    """On a page that is shown."""
    closer = Closer(tap, browser, out)
    check_values(closer, db)
    browser.picture(out + "/closer.png")
    check_zoom(closer)
    check_ticks(closer)
    check_keys(closer)
    check_fingers(closer)
    browser.pump()
    tap.check("and all that asks for nothing, and is refused nothing", not browser.errors and len([u for u in browser.requests if not u.startswith("data:")]) == 1,
              browser.errors, browser.requests)
