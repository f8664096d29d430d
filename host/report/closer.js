/* Look closer at a plot: a cursor with values, and zoom.
 *
 * All is read from the picture that is there: what its points stand for from data-x and data-y of the frame (host/base/svg.c), units
 * and names from labels and keys. A value is that of a point that is drawn, with its own place where that is not the cursor's; one that is
 * read between two points of a thinned line has ≈ before it. Without this script the page is the same. Nothing is asked for elsewhere. */
'use strict';
(() => {
  const NS = 'http://www.w3.org/2000/svg', LEAST_SHARE = 1 / 50, TENTH_PX = 0.1, SAME_PX = 0.11;
  const THINNED_PX = 0.3, COLUMN_PX = 5; /* what svg.h and chart.h thin lines by, at most */
  const words = e => (e.getAttribute('class') || '').split(' ');
  const is = (e, ...any) => any.some(word => words(e).includes(word));
  const look = e => words(e).pop();
  const number = (e, name) => parseFloat(e.getAttribute(name));
  const make = (into, tag, attributes) => {
    const e = into.appendChild(document.createElementNS(NS, tag));
    for (const name in attributes) e.setAttribute(name, attributes[name]);
    return e;
  };

  /* Corners of a path, [command M, L or Z, x, y]; of a circle its centre. */
  function corners(e) {
    if (e.tagName === 'circle') return [['M', number(e, 'cx'), number(e, 'cy')]];
    const parts = (e.getAttribute('d') || '').match(/[a-z]|-?(\d+\.?\d*|\.\d+)/gi) || [], out = [];
    let command = '', x = 0, y = 0;
    for (let i = 0; i < parts.length;) {
      if (/[a-z]/i.test(parts[i])) command = parts[i++];
      if (command === 'Z') { out.push(['Z', x, y]); continue; }
      const from = /[mlhv]/.test(command), way = command.toUpperCase();
      if (way !== 'V') x = parseFloat(parts[i++]) + (from ? x : 0);
      if (way !== 'H') y = parseFloat(parts[i++]) + (from ? y : 0);
      out.push([way === 'M' ? 'M' : 'L', x, y]);
      if (way === 'M') command = from ? 'l' : 'L';
    }
    return out;
  }
  const points = e => corners(e).filter(c => c[0] !== 'Z').map(([, x, y]) => ({x, y}));
  function centre(e) {
    const all = points(e);
    return {x: all.reduce((s, p) => s + p.x, 0) / all.length, y: all.reduce((s, p) => s + p.y, 0) / all.length};
  }
  const isMark = e => is(e, 'dot', 'open');
  const isBar = e => e.tagName === 'path' && /^M[^a-z]*[vh][^a-z]*$/i.test(e.getAttribute('d'));

  /* Ticks as svg_choose_ticks in svg.c chooses them. */
  function chooseTicks(low, high, most) {
    const exponent = Math.floor(Math.log10((high - low) / most));
    for (const [mantissa, places] of [[1, exponent], [2, exponent], [5, exponent], [10, exponent + 1]]) {
      const step = mantissa * Math.pow(10, exponent), first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
      if (last - first + 1 > most) continue;
      return {values: Array.from({length: Math.max(0, last - first + 1)}, (_, i) => (first + i) * step), decimals: Math.max(0, -places)};
    }
    return {values: [], decimals: 0};
  }
  const written = (value, decimals) => value.toFixed(Math.min(decimals, 20)).replace(/^-(0\.?0*)$/, '$1');

  /* An axis: where it begins, its size, and what it stands for. `share` 0 is low; `within`: what the tenths of its pixels are. */
  function readAxis(frame, name) {
    const [low, high] = frame.dataset[name].split(' ').map(Number);
    const from = number(frame, name), size = number(frame, name === 'x' ? 'width' : 'height');
    const axis = {name, key: name + frame.dataset[name], low, high, from, size, label: ''};
    axis.share = px => name === 'x' ? (px - from) / size : 1 - (px - from) / size;
    axis.pixel = share => from + size * (name === 'x' ? share : 1 - share);
    axis.value = px => low + axis.share(px) * (high - low);
    axis.within = TENTH_PX / 2 / size * Math.abs(high - low);
    axis.decimals = Math.max(0, -Math.floor(Math.log10(2 * axis.within)));
    axis.write = value => written(value, axis.decimals);
    axis.least = times => Number((times * axis.within).toPrecision(1)).toString();
    return axis;
  }
  const what = axis => axis.label.replace(/, [^,]*$/, '');
  const unit = axis => axis.label.includes(', ') ? ' ' + axis.label.replace(/^.*, /, '') : '';

  /* Names of looks from the keys: stroke or mark, or both, then a text beside them. */
  function readKeys(svg) {
    const names = new Map(), parts = new Set();
    for (const text of svg.querySelectorAll(':scope > text.tick')) {
      let mark = text.previousElementSibling;
      if (!mark || !['path', 'circle'].includes(mark.tagName) || is(mark, 'grid')) continue;
      const at = points(mark), right = Math.max(...at.map(p => p.x)), away = number(text, 'x') - right;
      if (away < 0 || away > 30 || Math.abs(centre(mark).y - number(text, 'y') + 4) > 3) continue;
      parts.add(text).add(mark);
      const stroke = mark.previousElementSibling;
      if (stroke && isMark(mark) && /h28$/.test(stroke.getAttribute('d') || '')) { parts.add(stroke); mark = stroke; }
      names.set(look(mark), [...names.get(look(mark)) || [], text.textContent]);
    }
    return {names, parts};
  }

  function readSeries(panel, keys) {
    const lines = [], marks = new Map(), bars = [], bands = [];
    for (const e of panel.content) {
      if (keys.parts.has(e) || is(e, 'faint', 'key')) continue;
      if (is(e, 'line') && isBar(e)) bars.push({look: look(e), at: points(e)});
      else if (is(e, 'line') && e.getAttribute('d')) {
        lines.push({look: look(e), points: points(e), corners: corners(e), band: bands.shift()});
      } else if (is(e, 'band') && e.tagName === 'path') {
        bands.push(points(e));
      } else if (is(e, 'dots') || isMark(e)) {
        if (!marks.has(look(e))) marks.set(look(e), {look: look(e), points: []});
        marks.get(look(e)).points.push(...is(e, 'dots') ? points(e).filter((_, i) => i % 2 === 0) : [centre(e)]);
      }
    }
    for (const l of lines) l.thinned = !marks.has(l.look) || marks.get(l.look).points.length < l.points.length;
    const all = [...lines, ...[...marks.values()].filter(m => !lines.some(l => l.look === m.look))].filter(s => s.points.length);
    const seen = new Map(), labels = panel.content.filter(e => e.tagName === 'text' && is(e, 'label')), end = s => s.points[s.points.length - 1].y;
    const byEnd = labels.length === all.length && [...all].sort((a, b) => end(a) - end(b));
    labels.sort((a, b) => number(a, 'y') - number(b, 'y'));
    for (const s of all) {
      const n = seen.get(s.look) || 0, names = keys.names.get(s.look) || [];
      seen.set(s.look, n + 1);
      s.label = byEnd ? labels[byEnd.indexOf(s)] : null;
      s.name = s.label && !names.length ? s.label.textContent : names[Math.min(n, names.length - 1)] || '';
      s.bars = bars.filter(b => b.look === s.look).map(b => b.at);
    }
    return all;
  }

  /* A panel is two axes, a frame, and what follows up to the next axes. */
  function readPanel(frame, keys) {
    const panel = {frame, x: readAxis(frame, 'x'), y: readAxis(frame, 'y'), axes: [], content: [], title: ''};
    for (let e = frame.previousElementSibling, grids = 0; e && grids < 2; e = e.previousElementSibling) {
      if (is(e, 'grid')) grids++;
      if (is(e, 'label')) panel[e.hasAttribute('transform') ? 'y' : 'x'].label = e.textContent;
      else panel.axes.push(e);
    }
    for (let e = frame.nextElementSibling; e && !is(e, 'grid') && !is(e, 'closer'); e = e.nextElementSibling) panel.content.push(e);
    const name = panel.content.find(e => is(e, 'name') && number(e, 'x') < panel.x.from + 8 && number(e, 'y') < panel.y.from + 20);
    panel.title = name ? name.textContent : '';
    panel.numbers = {x: panel.axes.some(e => e.getAttribute('text-anchor') === 'middle'), y: panel.axes.some(e => e.getAttribute('text-anchor') === 'end')};
    panel.series = readSeries(panel, keys);
    return panel;
  }

  /* What is labelled at the foot of a column or the left of a row only, is so for all of it. */
  function shareLabels(panels) {
    for (const name of ['x', 'y'])
      for (const p of panels.filter(p => !p[name].label)) {
        const other = name === 'x' ? 'y' : 'x';
        const from = panels.find(q => q[name].label && q[name].key === p[name].key && (q[other].from === p[other].from || q[name].from === p[name].from)) ||
          panels.find(q => q[name].label && q[name].key === p[name].key);
        if (from) p[name].label = from[name].label;
      }
    return panels.filter(p => p.x.label && p.y.label && p.series.length);
  }

  /* The error that is drawn at a point: a whisker through it, or the band around its line. */
  function drawnError(panel, series, point) {
    const bar = series.bars.find(([a, b]) => Math.abs(a.x - point.x) < SAME_PX && Math.abs(b.x - point.x) < SAME_PX &&
      Math.min(a.y, b.y) - SAME_PX <= point.y && Math.max(a.y, b.y) + SAME_PX >= point.y);
    let edges = bar && bar.map(p => p.y);
    if (!edges && series.band) {
      edges = [];
      series.band.forEach((b, i) => {
        const a = series.band[i - 1];
        if (a && Math.min(a.x, b.x) <= point.x && Math.max(a.x, b.x) >= point.x)
          edges.push(a.x === b.x ? b.y : a.y + (b.y - a.y) * (point.x - a.x) / (b.x - a.x));
      });
      if (edges.length < 2) return '';
    }
    if (!edges) return '';
    const top = Math.min(...edges), foot = Math.max(...edges), y = panel.y;
    if (top > y.from + SAME_PX && foot < y.from + y.size - SAME_PX && Math.abs(top + foot - 2 * point.y) < 1)
      {
      const half = Math.abs(y.value(top) - y.value(foot)) / 2;
      return half < 2 * y.within ? ` ± less than ${y.least(2)}` : ` ± ${y.write(half)}`;
    }
    return ' (' + y.write(y.value(foot)) + ' to ' + y.write(y.value(top)) + ')';
  }

  const box = document.createElement('div');
  box.className = 'closer-box';
  box.setAttribute('role', 'status');
  box.hidden = true;
  const say = (tag, text, className) => {
    const e = box.appendChild(document.createElement(tag));
    e.textContent = text;
    if (className) e.className = className;
  };

  let shownBy = null;
  class Picture {
    constructor(svg) {
      this.svg = svg;
      this.view = new Map();
      this.fingers = new Map();
      const keys = readKeys(svg);
      this.keys = keys;
      this.panels = shareLabels([...svg.querySelectorAll(':scope > rect.frame[data-x]')].map(f => readPanel(f, keys)));
      this.panel = this.panels[0];
      this.at = null;
    }

    range(axis) { return this.view.get(axis.key) || [0, 1]; }
    /* Where a pixel of the picture is shown, and back. */
    shown(axis, px) { const [a, b] = this.range(axis); return axis.pixel((axis.share(px) - a) / (b - a)); }
    meant(axis, px) { const [a, b] = this.range(axis); return axis.pixel(a + axis.share(px) * (b - a)); }

    locate(event) {
      const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
      const inside = this.panels.find(q => q.x.share(p.x) >= -0.01 && q.x.share(p.x) <= 1.01 && q.y.share(p.y) >= -0.05 && q.y.share(p.y) <= 1.05);
      return {x: p.x, y: p.y, panel: inside};
    }

    /* ---- cursor ---- */
    nearest(series, x, y) {
      let best = null, away = Infinity;
      for (const p of series.points) {
        const d = Math.abs(p.x - x) + (y === undefined ? 0 : 1e-4 * Math.abs(p.y - y));
        if (d < away) { best = p; away = d; }
      }
      return best;
    }
    /* The point of a line at x. */
    crossing(series, x) {
      for (let i = 1; series.corners && i < series.corners.length; i++) {
        const [, ax, ay] = series.corners[i - 1], [command, bx, by] = series.corners[i];
        if (command === 'L' && Math.min(ax, bx) <= x && Math.max(ax, bx) >= x && ax !== bx) return {x, y: ay + (by - ay) * (x - ax) / (bx - ax), between: true};
      }
      return null;
    }
    /* Far from what is drawn of a thinned line, what was left out there lies within THINNED_PX of it: a point of the line, marked as such. */
    reading(series, x, y) {
      const near = this.nearest(series, x, y);
      return series.thinned && Math.abs(near.x - x) > COLUMN_PX && this.crossing(series, x) || near;
    }
    stops() {
      const all = this.panel.series.flatMap(s => s.points.map(p => p.x)).sort((a, b) => a - b);
      return all.filter((x, i) => i === 0 || x - all[i - 1] > TENTH_PX / 2);
    }
    point(panel, x, y) {
      this.panel = panel;
      const near = panel.series.map(s => this.nearest(s, x, y));
      this.at = near.reduce((a, b) => Math.abs(b.x - x) < Math.abs(a.x - x) ? b : a).x;
      this.near = panel.series.map(s => this.reading(s, this.at, y));
      this.show();
    }
    step(by) {
      const stops = this.stops();
      if (this.at === null) this.at = this.meant(this.panel.x, this.panel.x.pixel(0.5));
      let i = stops.findIndex(x => x > this.at - TENTH_PX / 2);
      if (i < 0) i = stops.length - 1;
      i = Math.max(0, Math.min(stops.length - 1, i + by));
      const axis = this.panel.x, share = axis.share(stops[i]), [a, b] = this.range(axis);
      if (share < a || share > b) {
        const from = Math.max(0, Math.min(1 - (b - a), share - (b - a) / 2));
        this.set(axis, from, from + b - a);
      }
      this.point(this.panel, stops[i]);
    }
    clear() {
      this.svg.querySelectorAll('.closer-cursor').forEach(e => e.remove());
      box.hidden = true;
    }
    show() {
      this.clear();
      const g = make(this.svg, 'g', {class: 'closer closer-cursor'}), panel = this.panel;
      for (const p of this.panels.filter(p => p.x.key === panel.x.key)) {
        const x = this.shown(p.x, p.x.pixel(panel.x.share(this.at)));
        make(g, 'path', {d: `M${x} ${p.y.from}v${p.y.size}`, class: 'closer-line'});
      }
      this.near.forEach(p => {
        const x = this.shown(panel.x, p.x), y = this.shown(panel.y, p.y);
        if (panel.x.share(x) >= -1e-6 && panel.x.share(x) <= 1 + 1e-6 && panel.y.share(y) >= -1e-6 && panel.y.share(y) <= 1 + 1e-6)
          make(g, 'circle', {cx: x, cy: y, r: 4, class: 'closer-point'});
      });
      this.tell(panel);
    }
    tell(panel) {
      const {x, y} = panel;
      box.replaceChildren();
      if (panel.title) say('strong', panel.title);
      say('p', `${what(x)} ${x.write(x.value(this.at))}${unit(x)}`, 'closer-x');
      panel.series.forEach((s, i) => {
        const p = this.near[i], value = y.value(p.y);
        const bound = p.y <= y.from + 0.01 ? (y.high > y.low ? '≥ ' : '≤ ') : p.y >= y.from + y.size - 0.01 ? (y.high > y.low ? '≤ ' : '≥ ') : '';
        const place = Math.abs(p.x - this.at) > TENTH_PX / 2 ? ` at ${x.write(x.value(p.x))}${unit(x)}` : '';
        const error = drawnError(panel, s, p);
        say('p', `${s.name || what(y)}: ${p.between ? '≈ ' : bound}${y.write(value)}${error}${unit(y)}${error ? ' (95 %)' : ''}${place}`);
      });
      const between = this.near.some(p => p.between) ? ` ≈: on the line, thinned to ± ${y.least(2 * THINNED_PX / TENTH_PX)}${unit(y)}.` : '';
      const thinned = panel.series.some(s => s.thinned) ? ' (lines are thinned)' : '';
      say('p', `Nearest drawn points${thinned}, read to ± ${x.least(1)}${unit(x)}, ± ${y.least(1)}${unit(y)}.${between}`, 'closer-note');
      box.hidden = false;
      shownBy = this;
      this.place();
    }
    /* The values: beside the cursor; in a narrow window below the picture, or above it. */
    place() {
      const {x, y} = this.panel, m = this.svg.getScreenCTM(), px = this.shown(x, this.at) * m.a + m.e, top = y.from * m.d + m.f;
      const room = document.documentElement.clientWidth, narrow = room < 600;
      box.style.right = narrow ? '8px' : '';
      box.style.left = '8px';
      const wide = box.offsetWidth, tall = box.offsetHeight, all = this.svg.getBoundingClientRect();
      if (!narrow) box.style.left = (px + 14 + wide < room ? px + 14 : Math.max(4, px - 14 - wide)) + 'px';
      const beside = Math.max(4, Math.min(top + 8, innerHeight - tall - 4)), below = all.bottom + 4 + tall < innerHeight ? all.bottom + 4 : Math.max(4, all.top - tall - 4);
      box.style.top = (narrow ? below : beside) + 'px';
    }

    /* ---- zoom ---- */
    set(axis, a, b) {
      if (b - a >= 1) this.view.delete(axis.key);
      else {
        const size = Math.max(b - a, LEAST_SHARE), from = Math.max(0, Math.min(1 - size, (a + b - size) / 2));
        this.view.set(axis.key, [from, from + size]);
      }
      this.draw();
    }
    scale(axis, share, factor) {
      const [a, b] = this.range(axis), size = Math.min(1, Math.max(LEAST_SHARE, (b - a) * factor)), middle = a + share * (b - a);
      const from = Math.max(0, Math.min(1 - size, middle - share * size));
      this.set(axis, from, from + size);
    }
    back() {
      this.view.clear();
      this.draw();
      this.clear();
      this.at = null;
    }
    draw() {
      this.svg.querySelectorAll('.closer-view').forEach(e => e.remove());
      this.svg.querySelectorAll('[data-away]').forEach(e => e.removeAttribute('data-away'));
      this.panels.filter(p => this.view.has(p.x.key) || this.view.has(p.y.key)).forEach(p => this.drawPanel(p));
    }
    drawTicks(g, panel, axis) {
      const [a, b] = this.range(axis), low = axis.low + a * (axis.high - axis.low), high = axis.low + b * (axis.high - axis.low), isX = axis.name === 'x';
      const {values, decimals} = chooseTicks(Math.min(low, high), Math.max(low, high), Math.floor(axis.size / (isX ? 70 : 36)) + 2);
      const at = value => axis.pixel((value - low) / (high - low)), {x, y} = panel;
      make(g, 'path', {class: 'grid', d: values.map(v => isX ? `M${at(v)} ${y.from}v${y.size}` : `M${x.from} ${at(v)}h${x.size}`).join('')});
      if (!panel.numbers[axis.name]) return;
      const numbers = make(g, 'g', {class: 'tick', 'text-anchor': isX ? 'middle' : 'end'});
      for (const v of values)
        make(numbers, 'text', isX ? {x: at(v), y: y.from + y.size + 14} : {x: x.from - 5, y: at(v) + 4}).textContent = written(v, decimals);
    }
    drawPanel(panel) {
      const {x, y} = panel, g = make(this.svg, 'g', {class: 'closer closer-view'}), id = `closer-${pictures.indexOf(this.svg)}-${this.panels.indexOf(panel)}`;
      make(make(g, 'clipPath', {id}), 'rect', {x: x.from, y: y.from, width: x.size, height: y.size});
      this.drawTicks(g, panel, x);
      this.drawTicks(g, panel, y);
      const inside = make(g, 'g', {'clip-path': `url(#${id})`});
      for (const e of panel.content) this.drawMoved(g, inside, panel, e);
      for (const e of [...panel.axes, ...panel.content]) e.setAttribute('data-away', '');
    }
    drawMoved(g, inside, panel, e) {
      const {x, y} = panel, copy = e.cloneNode(true), X = px => this.shown(x, px), Y = py => this.shown(y, py);
      const isText = e.tagName === 'text';
      const below = isText && number(e, 'y') > y.from + y.size && !this.keys.parts.has(e);
      const stays = this.keys.parts.has(e) || (isText && (number(e, 'x') > x.from + x.size - 8 || (is(e, 'name') && number(e, 'x') < x.from + 8)));
      const named = isText && panel.series.find(s => s.label === e), edge = named && this.crossing(named, this.meant(x, x.from + x.size));
      if (edge && Y(edge.y) >= y.from && Y(edge.y) <= y.from + y.size) { /* a line's name goes along with it */
        copy.setAttribute('x', x.from + x.size + 3);
        copy.setAttribute('y', Y(edge.y) + 4);
      }
      if (stays || edge) { g.append(copy); return; }
      if (below) { /* beside the axis, in place of a number */
        copy.setAttribute('x', X(number(e, 'x')));
        if (X(number(e, 'x')) >= x.from && X(number(e, 'x')) <= x.from + x.size) g.append(copy);
        return;
      }
      inside.append(copy);
      if (isText) {
        copy.setAttribute('x', X(number(e, 'x')));
        copy.setAttribute('y', Y(number(e, 'y')));
      } else if (e.tagName === 'rect') {
        const left = number(e, 'x'), top = number(e, 'y'), right = left + number(e, 'width'), foot = top + number(e, 'height');
        for (const [name, value] of [['x', X(left)], ['y', Y(top)], ['width', X(right) - X(left)], ['height', Y(foot) - Y(top)]]) copy.setAttribute(name, value);
      } else if (isMark(e)) {
        const at = centre(e);
        copy.setAttribute('transform', `translate(${X(at.x) - at.x} ${Y(at.y) - at.y})`);
      } else if (e.tagName === 'path') {
        const d = corners(e).map(([command, px, py]) => command === 'Z' ? 'Z' : `${command}${X(px).toFixed(2)} ${Y(py).toFixed(2)}`).join('');
        copy.setAttribute('d', d);
      }
    }

    /* ---- mouse, fingers, keys ---- */
    down(event) {
      const here = this.locate(event);
      if (!here.panel || event.button) return;
      this.svg.focus({preventScroll: true});
      this.fingers.set(event.pointerId, here.x);
      if (event.pointerType === 'touch') {
        if (this.fingers.size === 1) this.point(here.panel, this.meant(here.panel.x, here.x), this.meant(here.panel.y, here.y));
        return;
      }
      event.preventDefault();
      this.svg.setPointerCapture(event.pointerId);
      this.drag = here;
    }
    move(event) {
      const here = this.locate(event), drag = this.drag;
      if (this.fingers.size === 2 && this.fingers.has(event.pointerId)) return this.pinch(event.pointerId, here.x);
      if (drag && Math.abs(here.x - drag.x) > 4) return this.pick(here);
      if (here.panel) this.point(here.panel, this.meant(here.panel.x, here.x), this.meant(here.panel.y, here.y));
      else if (document.activeElement !== this.svg) this.clear();
    }
    /* The range from where the drag began; the height only where it is dragged over, too. */
    picked(here) {
      const {panel} = this.drag, hold = share => Math.max(0, Math.min(1, share));
      const of = name => [hold(panel[name].share(this.drag[name])), hold(panel[name].share(here[name]))].sort((a, b) => a - b);
      const tall = of('y');
      return {x: of('x'), y: tall[1] - tall[0] > 0.25 ? tall : [0, 1]};
    }
    pick(here) {
      this.clear();
      const {panel} = this.drag, {x, y} = this.picked(here);
      make(make(this.svg, 'g', {class: 'closer closer-cursor'}), 'rect', {class: 'closer-pick', x: panel.x.pixel(x[0]), y: panel.y.pixel(y[1]),
        width: panel.x.size * (x[1] - x[0]), height: panel.y.size * (y[1] - y[0])});
    }
    up(event) {
      const drag = this.drag, here = this.locate(event);
      this.fingers.delete(event.pointerId);
      this.drag = null;
      if (!drag || event.type === 'pointercancel' || Math.abs(here.x - drag.x) <= 4) return;
      this.drag = drag;
      const ranges = this.picked(here);
      this.drag = null;
      this.clear();
      for (const name of ['x', 'y']) {
        const axis = drag.panel[name], [a, b] = this.range(axis), [from, to] = ranges[name];
        this.set(axis, a + from * (b - a), a + to * (b - a));
      }
    }
    pinch(id, x) {
      const ids = [...this.fingers.keys()], other = this.fingers.get(ids[0] === id ? ids[1] : ids[0]), before = Math.abs(this.fingers.get(id) - other);
      this.fingers.set(id, x);
      this.clear();
      if (before > 8 && Math.abs(x - other) > 8) this.scale(this.panel.x, this.panel.x.share((x + other) / 2), before / Math.abs(x - other));
    }
    wheel(event) {
      const here = this.locate(event);
      if (!here.panel || (document.activeElement !== this.svg && !event.ctrlKey)) return; /* else the page scrolls */
      event.preventDefault();
      this.scale(here.panel.x, here.panel.x.share(here.x), Math.pow(2, Math.sign(event.deltaY) / 2));
      this.point(here.panel, this.meant(here.panel.x, here.x), this.meant(here.panel.y, here.y));
    }
    key(event) {
      const far = event.shiftKey ? 10 : 1, axis = this.panel.x, i = this.panels.indexOf(this.panel), all = this.panels.length;
      const middle = () => this.at === null ? 0.5 : Math.max(0, Math.min(1, axis.share(this.shown(axis, this.at))));
      const zoom = factor => { this.scale(axis, middle(), factor); if (this.at !== null) this.show(); };
      const turn = by => { this.panel = this.panels[(i + by + all) % all]; this.at = this.at === null ? null : this.panel.x.pixel(axis.share(this.at)); this.step(0); };
      const does = {ArrowLeft: () => this.step(-far), ArrowRight: () => this.step(far), ArrowUp: () => turn(-1), ArrowDown: () => turn(1),
        Home: () => this.step(-Infinity), End: () => this.step(Infinity), '+': () => zoom(0.5), '=': () => zoom(0.5), '-': () => zoom(2), Escape: () => this.back()}[event.key];
      if (!does || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      does();
    }
  }

  const pictures = [...document.querySelectorAll('svg[role=img]')].filter(svg => svg.querySelector('rect.frame[data-x]') && svg.querySelector('text.label[transform]'));
  const rules = ['.closer-on{touch-action:pan-y;cursor:crosshair}', '[data-away]{display:none}', '.closer-line{stroke:var(--ink);stroke-width:1;fill:none}',
    '.closer-point{fill:none;stroke:var(--ink);stroke-width:1.5}', '.closer-pick{fill:var(--a);opacity:.2}',
    '.closer-box{position:fixed;z-index:1;max-width:420px;background:var(--panel);color:var(--ink);border:1px solid var(--rule);border-radius:6px;padding:6px 10px;' +
      'font-size:13px;line-height:1.35;font-variant-numeric:tabular-nums;pointer-events:none}', '.closer-box[hidden]{display:none}',
    '.closer-box p{margin:0;color:var(--ink);max-width:none}', '.closer-box .closer-note{color:var(--soft);font-size:11px}'];
  const sheet = document.styleSheets[0];
  sheet.insertRule(`@media screen{${rules.join('')}}`, sheet.cssRules.length);
  sheet.insertRule('@media print{.closer,.closer-box{display:none}}', sheet.cssRules.length);
  document.body.append(box);
  for (const svg of pictures) {
    let read = null;
    const picture = () => read ||= new Picture(svg); /* when it is looked at: a page may have hundreds */
    svg.setAttribute('class', 'closer-on');
    svg.setAttribute('tabindex', '0');
    const on = (name, does, options) => svg.addEventListener(name, event => { if (picture().panels.length) does(picture(), event); }, options);
    on('pointerdown', (p, e) => p.down(e));
    on('pointermove', (p, e) => p.move(e));
    on('pointerup', (p, e) => p.up(e));
    on('pointercancel', (p, e) => p.up(e));
    on('pointerleave', (p, e) => { if (e.pointerType === 'mouse' && !p.drag) p.clear(); });
    on('blur', p => p.clear());
    on('dblclick', p => p.back());
    on('keydown', (p, e) => p.key(e));
    on('wheel', (p, e) => p.wheel(e), {passive: false});
  }
  addEventListener('scroll', () => { if (!box.hidden) shownBy.place(); }, {passive: true});
})();
