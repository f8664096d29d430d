'use strict';
/* The plots of the pages: of a report from the data in the page, of the live view from readings. dygraphs draws; here are looks, keys,
 * marks, the values under the pointer, zoom of plots side by side, and paper. A page without this script has its tables. */
const matrigCharts = (() => {
  const HUES = ['a', 'b', 'c', 'd', 'e', 'f'], DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [14, 4], [5, 2, 1.5, 2, 1.5, 2]];
  const PAPER_RATIO = 2; /* dots of the paper for one of the page */
  const hue = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
  const make = (into, tag, className, text) => {
    const e = into.appendChild(document.createElement(tag));
    if (className) e.className = className;
    if (text) e.textContent = text;
    return e;
  };
  const squared = (text) => text.replace('/s2', '/s²');
  const number = (v) => String(Number(v.toPrecision(5)));
  Dygraph.PLUGINS = [Dygraph.Plugins.Axes, Dygraph.Plugins.Grid]; /* its legend needs styles that a strict page refuses */

  const colours = () => ({ colors: [hue('line') || hue('a')], gridLineColor: hue('grid'), axisLineColor: hue('soft') });
  /* One plot in a box. Rows are [x, [low, value, high], ...]. */
  const plot = (box, rows, options) => new Dygraph(box, rows, {
    customBars: true, connectSeparatedPoints: true, legend: 'never', showLabelsOnHighlight: false, fillAlpha: 0.2, strokeWidth: 1.4, ...colours(), ...options,
    axes: {
      x: { pixelsPerLabel: box.clientWidth < 300 ? 42 : 60, axisLabelWidth: 60, axisLabelFormatter: number, ...(options.axes || {}).x },
      y: { pixelsPerLabel: 18, axisLabelWidth: 46, axisLabelFormatter: number, ...(options.axes || {}).y },
    },
  });

  /* ---- marks and shapes ---- */
  const CORNERS = [0, 4, 3, 4, 3], TURNED = [0, Math.PI / 4, -Math.PI / 2, 0, Math.PI / 2]; /* circle, square, triangles and a diamond */
  const mark = (context, look, x, y, r) => {
    const n = CORNERS[look % 5];
    context.beginPath();
    if (!n) context.arc(x, y, r, 0, 2 * Math.PI);
    for (let i = 0; i < n; i++) {
      const a = TURNED[look % 5] + i * 2 * Math.PI / n;
      context.lineTo(x + 1.3 * r * Math.cos(a), y + 1.3 * r * Math.sin(a));
    }
    context.closePath();
    context.fill();
  };
  const drawMark = (look) => (g, name, context, x, y, colour, size) => {
    context.fillStyle = colour;
    mark(context, look, x, y, size);
  };
  /* A line through [low, high] at each point. */
  const whiskers = (e) => {
    const { drawingContext: context, plotArea: area } = e;
    context.strokeStyle = e.color;
    context.setLineDash([]);
    context.lineWidth = 1;
    context.beginPath();
    for (const p of e.points) {
      if (isNaN(p.y_top) || isNaN(p.y_bottom)) continue;
      context.moveTo(p.canvasx, area.y + area.h * p.y_top);
      context.lineTo(p.canvasx, area.y + area.h * p.y_bottom);
    }
    context.stroke();
  };
  /* A few marks along a line tell it from others without colour; each look begins elsewhere. */
  const MARKS = 7;
  const marked = (look) => (e) => {
    Dygraph.Plotters.linePlotter(e);
    const points = e.points.filter((p) => !isNaN(p.yval) && p.yval !== null), step = Math.ceil(points.length / MARKS);
    e.drawingContext.fillStyle = e.color;
    for (let i = Math.floor(step * (look % 6) / 6); i < points.length; i += step) mark(e.drawingContext, look, points[i].canvasx, points[i].canvasy, 3);
  };
  /* Points with their intervals, those of each look beside those of the others: none hides another. */
  const APART_PX = 12;
  const apart = (s, spec) => (e) => {
    const looks = [...new Set(spec.series.filter((o) => o.k === 'apart').map((o) => o.l))];
    for (const p of e.points) p.canvasx += APART_PX * (looks.indexOf(s.l) - (looks.length - 1) / 2);
    whiskers(e);
    e.drawingContext.fillStyle = e.color;
    for (const p of e.points) if (!isNaN(p.canvasy)) mark(e.drawingContext, s.l, p.canvasx, p.canvasy, 3);
  };
  const FILLS = { closed: ['closed', 0.75], behind: ['closed', 0.28], reported: ['a', 0.3], band: ['a', 0.15],
    damaged: ['ink', 0.8], failed: ['warn', 0.9], repaired: ['a', 0.6], passed: ['d', 0.6] };
  /* Lines that go on from one rectangle to the next; an edge where there is room for it. */
  const hatch = (context, x, y, w, h) => {
    context.save();
    context.beginPath();
    context.rect(x, y, w, h);
    context.clip();
    context.strokeStyle = hue('warn');
    context.lineWidth = 0.9;
    context.beginPath();
    for (let c = Math.ceil((x + y) / 7) * 7; c < x + y + w + h; c += 7) { context.moveTo(c - y - h, y + h); context.lineTo(c - y, y); }
    context.stroke();
    if (w > 8 && h > 8) context.strokeRect(x, y, w, h);
    context.restore();
  };
  /* A shape between two corners in pixels. */
  const shape = (context, kind, x0, y0, x1, y1, top, text) => {
    const x = Math.min(x0, x1), y = Math.min(y0, y1), w = Math.abs(x1 - x0), h = Math.abs(y1 - y0);
    context.save();
    if (FILLS[kind]) {
      context.fillStyle = hue(FILLS[kind][0]);
      context.globalAlpha = FILLS[kind][1];
      context.fillRect(x, y, w, h);
    } else if (kind === 'warned') {
      hatch(context, x, y, w, h);
    } else if (kind === 'sensor') {
      context.fillStyle = hue('d');
      mark(context, 4, x0, top + 5, 4.5);
    } else if (kind === 'seen') {
      context.strokeStyle = context.fillStyle = hue('ink');
      context.lineWidth = 1.4;
      context.beginPath();
      context.arc(x0, y0, 5, 0, 2 * Math.PI);
      context.stroke();
    } else {
      const [name, dash, width] = { mark: ['soft', [2, 3], 1], stop: ['a', [], 1.6], lead: ['c', [], 2] }[kind] || ['ink', [], 1];
      context.strokeStyle = hue(name);
      context.setLineDash(dash);
      context.lineWidth = width;
      context.beginPath();
      context.moveTo(x0, y0);
      context.lineTo(x1, y1);
      context.stroke();
    }
    context.globalAlpha = 1;
    if (text) {
      context.fillStyle = hue('ink');
      context.font = '600 11px system-ui,sans-serif';
      const left = kind === 'seen' || x0 < context.measureText(text).width + 10;
      context.textAlign = left ? 'left' : 'right';
      context.fillText(text, x0 + (left ? 8 : -8), y0 + (kind === 'seen' ? 4 : -4));
    }
    context.restore();
  };
  const shapes = (spec) => (context, area, g) => {
    context.save();
    context.beginPath();
    context.rect(area.x, area.y, area.w, area.h);
    context.clip();
    const whole = (v, from, to) => (v === null ? [from, to] : [v, v]);
    for (const [kind, x0, x1, y0, y1, text] of spec.shapes) {
      const [xa, xb] = x0 === null ? [area.x, area.x + area.w] : [g.toDomXCoord(x0), g.toDomXCoord(x1)];
      const [ya, yb] = y0 === null ? [area.y, area.y + area.h] : [g.toDomYCoord(y0), g.toDomYCoord(y1)];
      shape(context, kind, xa, ya, xb, yb, area.y, text);
    }
    context.restore();
  };

  /* ---- data ---- */
  /* [decimals, differences...] */
  const read = (list) => {
    let sum = 0;
    return list && list.slice(1).map((v) => (v === null ? NaN : (sum += v) / 10 ** list[0]));
  };
  const readPlot = (given) => {
    const spec = { ...given, series: [], shapes: [] };
    for (const item of given.i) {
      if (Array.isArray(item)) { spec.shapes.push(item); continue; }
      const s = { ...item, x: read(item.x), y: read(item.y), half: read(item.e) };
      if (s.x.length > 1 && s.x[0] > s.x[s.x.length - 1]) for (const key of ['x', 'y', 'half']) if (s[key]) s[key].reverse();
      spec.series.push(s);
    }
    return spec;
  };
  const rowsOf = (spec) => {
    const all = [], rows = [], none = spec.series.map(() => null);
    spec.series.forEach((s, k) => s.x.forEach((x, i) => { if (!isNaN(x)) all.push([x, k, i]); }));
    all.sort((a, b) => a[0] - b[0] || a[1] - b[1] || a[2] - b[2]);
    let row = null;
    for (const [x, k, i] of all) {
      if (!row || row[0] !== x || row[k + 1] !== null) rows.push(row = [x, ...none]);
      const s = spec.series[k];
      const half = s.half ? s.half[i] : 0;
      row[k + 1] = [s.y[i] - half, s.y[i], s.y[i] + half];
    }
    if (!rows.length) rows.push([spec.xr ? spec.xr[0] : 0, ...(none.length ? none : [null])]);
    return rows;
  };
  const widened = (low, high) => {
    if (!(low <= high)) return [0, 1];
    const room = high > low ? 0.06 * (high - low) : Math.abs(high) * 0.1 || 1;
    return [low - room, high + room];
  };
  const rangeOf = (specs, zero) => {
    let low = zero ? 0 : Infinity, high = zero ? 0 : -Infinity;
    for (const spec of specs) {
      for (const s of spec.series) s.y.forEach((y, i) => { const half = s.half ? s.half[i] : 0; if (y - half < low) low = y - half; if (y + half > high) high = y + half; });
      for (const [kind, , , y0, y1] of spec.shapes) if (y0 !== null && kind !== 'sensor') { low = Math.min(low, y0, y1); high = Math.max(high, y0, y1); }
    }
    return widened(low, high);
  };
  const xRangeOf = (spec) => {
    const x = spec.series.flatMap((s) => s.x).concat(spec.shapes.flatMap((s) => (s[1] === null ? [] : [s[1], s[2]]))).filter((v) => !isNaN(v));
    return widened(x.reduce((a, b) => Math.min(a, b), Infinity), x.reduce((a, b) => Math.max(a, b), -Infinity));
  };

  /* ---- a figure of a report ---- */
  const lookOf = (s) => ({
    color: hue(s.k === 'sim' ? 'b' : s.k === 'faint' ? 'rule' : HUES[s.l % 6]),
    strokePattern: s.k === 'sim' ? [5, 3] : DASHES[s.l % 6].length ? DASHES[s.l % 6] : null,
    strokeWidth: ['points', 'dots', 'apart'].includes(s.k) ? 0 : 1.4,
    drawPoints: ['points', 'dots', 'marks', 'whiskers'].includes(s.k), marked: ['marked', 'apart'].includes(s.k), pointSize: s.k === 'dots' ? 1.6 : 3,
    drawPointCallback: drawMark(s.l), drawHighlightPointCallback: drawMark(s.l),
  });
  class Plot {
    constructor(figure, given) {
      this.figure = figure;
      this.spec = readPlot(given);
      this.root = make(figure.plots, 'div', 'plot');
      const head = make(this.root, 'p', 'head');
      make(head, 'strong', '', given.t);
      make(head, 'span', 'unit', squared(given.y));
      this.output = make(head, 'output');
      this.box = make(this.root, 'div', 'box');
      this.box.style.height = given.h + 'px';
      make(this.root, 'p', 'x', squared(given.x));
      this.xr = given.xr || xRangeOf(this.spec);
      this.graph = null;
    }
    draw(ratio) {
      const { spec } = this, labels = spec.series.map((s, k) => 's' + k);
      const escaped = (text) => text.replace(/&/g, '&amp;').replace(/</g, '&lt;');
      const ticks = (list) => list && (() => list.map(([v, text]) => ({ v, label: escaped(text) })));
      const series = {};
      spec.series.forEach((s, k) => { series['s' + k] = { ...lookOf(s), ...(s.k === 'whiskers' ? { plotter: (e) => { whiskers(e); Dygraph.Plotters.linePlotter(e); } } : s.k === 'marked' ? { plotter: marked(s.l) } : s.k === 'apart' ? { plotter: apart(s, spec) } : {}) }; });
      const y = spec.yt ? { ticker: ticks(spec.yt), drawGrid: false } : {};
      this.graph = plot(this.box, rowsOf(spec), {
        labels: ['x', ...(labels.length ? labels : ['none'])], series, dateWindow: this.xr, valueRange: this.yr, pixelRatio: ratio, axes: { y },
        underlayCallback: shapes(spec), highlightCallback: (e, at) => this.figure.show(this, at), unhighlightCallback: () => this.figure.show(null),
        drawCallback: (g, first) => { if (!first) this.figure.follow(this); }, interactionModel: INTERACTION(this),
      });
    }
    clear() { if (this.graph) this.graph.destroy(); this.graph = null; }
    whole() { if (this.graph) this.graph.updateOptions({ dateWindow: this.xr, valueRange: this.yr }); }
    /* Each curve's drawn point nearest to x. */
    show(at) {
      if (at === null) { this.output.textContent = ''; return; }
      const values = this.spec.series.map((s) => {
        if (s.k === 'faint') return '';
        let best = -1;
        s.x.forEach((x, i) => { if (!isNaN(s.y[i]) && (best < 0 || Math.abs(x - at) < Math.abs(s.x[best] - at))) best = i; });
        if (best < 0) return '';
        const half = s.half && s.half[best];
        return (s.n ? s.n + ' ' : '') + number(s.y[best]) + (half > 0 ? ' ± ' + Number(half.toPrecision(2)) : '');
      }).filter((t) => t);
      this.output.textContent = number(at) + ': ' + values.join(', ');
    }
  }
  /* Drag zooms, a double click gives all back; a finger scrolls the page and asks for values. */
  const INTERACTION = (p) => ({
    ...Object.fromEntries(Object.entries(Dygraph.defaultInteractionModel).filter(([name]) => !name.startsWith('touch'))),
    dblclick: () => p.figure.all.forEach((q) => q.whole()),
  });
  class Figure {
    constructor(root) {
      const given = JSON.parse(root.querySelector('script').textContent);
      this.root = root;
      this.keys = root.querySelector('.keys');
      this.plots = root.querySelector('.plots');
      this.given = given;
      this.all = given.p.map((p) => new Plot(this, p));
      const shared = given.share && rangeOf(this.all.map((p) => p.spec), given.zero);
      for (const p of this.all) p.yr = p.spec.yr || shared || rangeOf([p.spec], given.zero);
      this.following = false;
      this.drawn = false;
    }
    draw(ratio) { if (!this.drawn) { this.writeKeys(); this.all.forEach((p) => p.draw(ratio)); } this.drawn = true; }
    clear() { this.all.forEach((p) => p.clear()); this.drawn = false; }
    show(from, at) { for (const p of this.all) p.show(from && (p === from || p.spec.x === from.spec.x) ? at : null); }
    follow(from) {
      if (this.following) return;
      this.following = true;
      for (const p of this.all) if (p !== from && p.graph && p.xr.join() === from.xr.join()) p.graph.updateOptions({ dateWindow: from.graph.xAxisRange() });
      this.following = false;
    }
    key(text, paint) {
      const key = make(this.keys, 'span'), canvas = make(key, 'canvas'), ratio = PAPER_RATIO;
      Object.assign(canvas, { width: 30 * ratio, height: 12 * ratio });
      const context = canvas.getContext('2d');
      context.scale(ratio, ratio);
      paint(context);
      key.append(text);
    }
    writeKeys() {
      this.keys.replaceChildren();
      const named = new Set();
      for (const s of this.all.flatMap((p) => p.spec.series)) {
        if (!s.n || named.has(s.n)) continue;
        named.add(s.n);
        const look = lookOf(s);
        this.key(s.n, (context) => {
          context.strokeStyle = context.fillStyle = look.color;
          context.lineWidth = 1.6;
          if (look.strokeWidth) { context.setLineDash(look.strokePattern || []); context.beginPath(); context.moveTo(0, 6); context.lineTo(30, 6); context.stroke(); }
          context.setLineDash([]);
          if (look.drawPoints || look.marked) mark(context, s.l, 15, 6, look.pointSize);
        });
      }
      for (const [kind, text] of this.given.k || []) this.key(text, (context) => shape(context, kind, kind === 'seen' || kind === 'sensor' ? 15 : 2, kind in FILLS || kind === 'warned' ? 1 : 6, 28, kind in FILLS || kind === 'warned' ? 11 : 6, 1));
    }
  }

  /* ---- two landings on one axis, from the data of their own figures ---- */
  const OVERLAID = { 'speed and deceleration': 1, 'displacement of eight': 8 }; /* so many plots of each figure */
  const overlaid = (landing, look) => Object.entries(OVERLAID).flatMap(([name, most]) => {
    const figure = [...landing.querySelectorAll('figure.chart')].find((f) => f.getAttribute('aria-label').startsWith(name));
    return figure ? JSON.parse(figure.querySelector('script').textContent).p.slice(0, most).map((p) => ({
      ...p, h: 150, xr: p.xr && p.xr[0] < 0 ? undefined : p.xr, yr: undefined, x: p.x || 'time since touchdown (s)',
      i: p.i.filter((s) => Array.isArray(s) ? !look : s.k === 'line').map((s) => (Array.isArray(s) ? s : { ...s, n: 'RUN ' + landing.id.slice(3), l: look, k: look ? 'sim' : 'line' })),
    })) : [];
  });
  const overlay = (root, changed) => {
    const landings = [...document.querySelectorAll('section.landing')].filter((l) => overlaid(l, 0).length);
    const line = root.insertBefore(document.createElement('p'), root.firstChild), data = root.querySelector('script');
    const choices = [0, landings.length - 1].map((at, k) => {
      line.append(k ? ' and ' : 'Compare ');
      const choice = make(line, 'select');
      choice.setAttribute('aria-label', k ? 'second landing' : 'first landing');
      landings.forEach((l, i) => choice.add(new Option(l.querySelector('h2').textContent.split(',')[0], i, i === at, i === at)));
      choice.addEventListener('change', () => { write(); changed(); });
      return choice;
    });
    const write = () => {
      const [first, second] = choices.map((c, k) => overlaid(landings[c.value], k));
      data.textContent = JSON.stringify({ p: first.map((p) => ({ ...p, i: p.i.concat((second.find((q) => q.t === p.t && q.y === p.y) || { i: [] }).i) })) });
    };
    if (landings.length > 1) write();
    else root.closest('section').hidden = true;
  };

  /* ---- a page ---- */
  const start = () => {
    const both = document.querySelector('#overlay figure');
    if (both) overlay(both, () => {
      const entry = figures.find((f) => f.root === both);
      if (entry.figure) entry.figure.clear();
      both.querySelector('.plots').replaceChildren();
      entry.figure = null;
      of(entry).draw();
    });
    const figures = [...document.querySelectorAll('figure.chart')].map((root) => ({ root, figure: null }));
    const of = (entry) => entry.figure || (entry.figure = new Figure(entry.root));
    const near = new IntersectionObserver((seen) => {
      for (const s of seen) {
        const entry = figures.find((f) => f.root === s.target);
        if (s.isIntersecting) of(entry).draw(); else if (entry.figure) entry.figure.clear();
      }
    }, { rootMargin: '600px' });
    figures.forEach((f) => near.observe(f.root));
    const again = (ratio, all) => figures.forEach((f) => {
      const was = f.figure && f.figure.drawn;
      if (was) f.figure.clear();
      if (was || all) of(f).draw(ratio);
    });
    const dark = matchMedia('(prefers-color-scheme: dark)');
    dark.addEventListener('change', () => again());
    addEventListener('resize', () => { if (!document.documentElement.classList.contains('paper')) figures.forEach((f) => { if (f.figure && f.figure.drawn) f.figure.all.forEach((p) => p.graph.resize()); }); });
    addEventListener('beforeprint', () => { document.documentElement.classList.add('paper'); again(PAPER_RATIO, true); });
    addEventListener('afterprint', () => { document.documentElement.classList.remove('paper'); again(); });
    addEventListener('keydown', (e) => { if (e.key === 'Escape') figures.forEach((f) => { if (f.figure) f.figure.all.forEach((p) => p.whole()); }); });
  };
  if (document.querySelector('figure.chart')) start();
  return { plot, colours };
})();
