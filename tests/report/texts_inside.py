#!/usr/bin/env python3
"""texts_inside.py FILE...: every text of every picture (SVG files, pages with SVG in them) lies inside its viewBox, and no two texts of a
picture cover each other. Exit 1 with those that do not.

Widths are those of DejaVu Sans, one of the widest fonts that `sans-serif` may be, to 5 %: characters in seven classes."""
import html.parser
import re
import sys

CLASSES = [(0.29, "iIjJl'|"), (0.34, " .,:;!/\\"), (0.39, "()[]ftr-·"), (0.52, "szcJvxyk?\"*°–"), (0.98, "mMwW@%"), (0.80, "OQNGDUH&+=<>#~±→−≤≥×")]
BOLD = 1.13
SLACK_PX = 2.0


def width_em(text):
    return sum(next((w for w, chars in CLASSES if c in chars), 0.62) for c in text)


class Rules:
    """Sizes and weights of classes; of the svg itself where no class says."""
    def __init__(self, css):
        self.size, self.bold, self.base = {}, set(), 12.0
        for selectors, body in re.findall(r"([^{}]+)\{([^{}]*)\}", css):
            size = re.search(r"font(?:-size)?:[^;]*?([\d.]+)px", body)
            for selector in selectors.split(","):
                name = re.search(r"\.([\w-]+)\s*$", selector)
                if name and size:
                    self.size[name.group(1)] = float(size.group(1))
                elif size and re.search(r"\bsvg\b[^.]*$", selector):
                    self.base = float(size.group(1))
                if name and re.search(r"font(-weight)?:[^;]*(bold|[6-9]00)", body):
                    self.bold.add(name.group(1))

    def of(self, classes):
        sizes = [self.size[c] for c in classes if c in self.size]
        return (sizes[-1] if sizes else self.base), any(c in self.bold for c in classes)


class Pictures(html.parser.HTMLParser):
    def __init__(self, rules):
        super().__init__()
        self.rules, self.pictures, self.open, self.text = rules, [], [], None

    def handle_starttag(self, tag, attributes):
        a = dict(attributes)
        if tag == "svg" and "viewbox" in a:
            self.pictures.append((a.get("aria-label", "?"), [float(v) for v in a["viewbox"].split()], []))
        if tag in ("svg", "g", "text"):
            self.open.append((tag, a))
        if tag == "text" and self.pictures:
            self.text = ""

    def handle_data(self, data):
        if self.text is not None:
            self.text += data

    def inherited(self, name):
        return next((a[name] for _, a in reversed(self.open) if name in a), None)

    def handle_endtag(self, tag):
        if tag == "text" and self.text is not None:
            self.finish(self.open[-1][1], re.sub(r"\s+", " ", self.text).strip())
            self.text = None
        if tag in ("svg", "g", "text") and self.open and self.open[-1][0] == tag:
            self.open.pop()

    def finish(self, a, text):
        classes = " ".join(x.get("class", "") for _, x in self.open).split()
        size, bold = self.rules.of(classes)
        size = float(self.inherited("font-size") or size)
        wide = width_em(text) * size * (BOLD if bold or self.inherited("font-weight") == "bold" else 1.0)
        anchor = self.inherited("text-anchor") or "start"
        before = {"start": 0.0, "middle": 0.5, "end": 1.0}[anchor] * wide
        x, y = float(a.get("x", 0)), float(a.get("y", 0))
        moved = re.fullmatch(r"translate\(([-\d.]+)[ ,]([-\d.]+)\)(?: rotate\((-?90)\))?", a.get("transform", ""))
        if moved and moved.group(3):
            mx, my = float(moved.group(1)), float(moved.group(2))
            box = (mx - 0.8 * size, my - wide + before, mx + 0.25 * size, my + before)
        else:
            x, y = (x + float(moved.group(1)), y + float(moved.group(2))) if moved else (x, y)
            box = (x - before, y - 0.8 * size, x - before + wide, y + 0.25 * size)
        if text:
            self.pictures[-1][2].append((text, box))


def faults(path):
    source = open(path, encoding="utf-8").read()
    pictures = Pictures(Rules(" ".join(re.findall(r"<style>(.*?)</style>", source, re.S))))
    pictures.feed(source)
    for label, (left, top, width, height), texts in pictures.pictures:
        for i, (text, box) in enumerate(texts):
            if box[0] < left - SLACK_PX or box[2] > left + width + SLACK_PX or box[1] < top - SLACK_PX or box[3] > top + height + SLACK_PX:
                yield "%s: %s: outside: '%s' (%s)" % (path, label, text, ", ".join("%.0f" % v for v in box))
            for other, b in texts[i + 1:]:
                if min(box[2], b[2]) - max(box[0], b[0]) > 4.0 and min(box[3], b[3]) - max(box[1], b[1]) > 5.0:
                    yield "%s: %s: '%s' covers '%s'" % (path, label, other, text)
    if not pictures.pictures or not any(texts for _, _, texts in pictures.pictures):
        yield "%s: no picture with any text in it" % path


bad = [fault for path in sys.argv[1:] for fault in faults(path)]
print("\n".join(bad[:40]))
sys.exit(1 if bad or len(sys.argv) < 2 else 0)
