'use strict';
/* The live page. Everything that is shown comes by server-sent events from this address and is put in as text, never as markup.
 * Readings come as buckets with the least and the most of each channel; where several share a pixel, the least of the least and the
 * most of the most are drawn. Memory is bounded: a minute of buckets of 20 ms, an hour of seconds. */
(() => {
  const $ = (id) => document.getElementById(id);
  const CHANNELS = 22, TRANSDUCERS = 8;
  const PER_UNIT = (c) => (c < TRANSDUCERS ? 10000 : 100);
  const ORDER_MS = 5000; /* an order that reaches matrig later is refused */
  const ANSWER_MS = ORDER_MS + 4000;
  const STREAMS = 4; /* a browser has six connections to one address: two are left for orders and pages */
  const LOST_MS = 1700; /* a board that says nothing for so long is told across the page, as in the terminal */
  const ENDED_MS = 10000; /* a campaign without news for so long is not being logged */
  const STALE_MS = 2000, SILENT_MS = 1000, DRAW_MS = 200;
  const token = location.hash.slice(1);
  let board = null, configuration = null, state = null, stateAt = 0, heardFrom = 0, connected = false, span = 10, seen = 0;

  const element = (name, className, text) => {
    const made = document.createElement(name);
    if (className) made.className = className;
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const say = (id, text) => { const e = $(id); if (e.textContent !== text) e.textContent = text; };
  const fixed = (value, digits) => (value === null || value === undefined || !isFinite(value) ? '–' : value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1'));
  const unit = (kind) => (configuration ? configuration.units[kind] : { text: '', factor: 1 });
  const shown = (value, kind, digits) => (value === null || value === undefined ? '–' : fixed(value * unit(kind).factor, digits) + ' ' + unit(kind).text);
  const digitsOf = (kind) => (configuration && configuration.units.displacement.text === 'mm' ? { displacement: 2, tension: 0 } : { displacement: 4, tension: 1 })[kind];
  const clock = (us) => new Date(us / 1000).toLocaleTimeString('en-GB');

  /* ---- readings: two tiers of rings ---- */
  class Tier {
    constructor(capacity, buckets) {
      this.capacity = capacity;
      this.buckets = buckets; /* of the board's in one of these */
      this.bucket = new Float64Array(capacity);
      this.least = Array.from({ length: CHANNELS }, () => new Float32Array(capacity));
      this.most = Array.from({ length: CHANNELS }, () => new Float32Array(capacity));
      this.clear();
    }
    clear() { this.next = 0; this.count = 0; this.newest = -1; }
    put(bucket, row) { /* row: least of all, most of all */
      const number = Math.floor(bucket / this.buckets);
      if (number < this.newest) return;
      const again = number === this.newest;
      const at = again ? (this.next + this.capacity - 1) % this.capacity : this.next;
      for (let c = 0; c < CHANNELS; c++) {
        const least = row[1 + c], most = row[1 + CHANNELS + c];
        const low = least === null ? NaN : least / PER_UNIT(c), high = most === null ? NaN : most / PER_UNIT(c);
        this.least[c][at] = again && !(low < this.least[c][at]) && !isNaN(this.least[c][at]) ? this.least[c][at] : low;
        this.most[c][at] = again && !(high > this.most[c][at]) && !isNaN(this.most[c][at]) ? this.most[c][at] : high;
      }
      if (again) return;
      this.bucket[at] = number;
      this.newest = number;
      this.next = (at + 1) % this.capacity;
      this.count = Math.min(this.count + 1, this.capacity);
    }
    index(i) { return (this.next + this.capacity - this.count + i) % this.capacity; } /* the i-th oldest */
  }
  const fine = new Tier(3000, 1), coarse = new Tier(3600, 50);
  let epoch = null, newestBucket = -1;

  const takeReadings = (message) => {
    if (epoch !== message.epoch) {
      fine.clear(); coarse.clear();
      newestBucket = -1;
      epoch = message.epoch;
    }
    for (const row of message.b) {
      if (row[0] <= newestBucket) continue; /* told again after a reconnection */
      newestBucket = row[0];
      fine.put(row[0], row);
      coarse.put(row[0], row);
    }
  };

  /* What a strip draws: [t, [least, middle, most]], at most one a pixel; a hole where nothing came for a second. */
  const columns = (tier, channel, from, width, factor) => {
    const perS = tier.buckets * configuration.bucket_s;
    let first = 0, high = tier.count;
    while (first < high) { /* the oldest inside the window */
      const middle = (first + high) >> 1;
      if (tier.bucket[tier.index(middle)] * perS < from) first = middle + 1; else high = middle;
    }
    const step = Math.max(1, Math.ceil((tier.count - first) / Math.max(50, width)));
    const rows = [];
    let last = -1;
    for (let i = first; i < tier.count; i += step) {
      let low = NaN, top = NaN;
      const at = tier.bucket[tier.index(i)] * perS;
      for (let k = i; k < Math.min(i + step, tier.count); k++) {
        const j = tier.index(k), a = tier.least[channel][j], b = tier.most[channel][j];
        if (!isNaN(a) && !(low <= a)) low = a;
        if (!isNaN(b) && !(top >= b)) top = b;
      }
      if (last >= 0 && at - last > Math.max(1, 2 * step * perS)) rows.push([last + perS, [NaN, NaN, NaN]]);
      if (!isNaN(low)) { rows.push([at, [low * factor, (low + top) / 2 * factor, top * factor]]); last = at; }
    }
    return rows;
  };

  /* ---- strips ---- */
  let strips = [];
  const ranges = { displacement: [-0.05, 0.05], tension: [0, 100] };
  const NOTHING = [[0, [NaN, NaN, NaN]]];
  const makePlot = (strip) => {
    strip.plot = matrigCharts.plot(strip.box, NOTHING, {
      labels: ['t', 'value'], highlightCircleSize: 0, interactionModel: {}, rightGap: 14, dateWindow: [0, span], valueRange: ranges[strip.kind],
      axes: {
        x: { pixelsPerLabel: 55, axisLabelWidth: 50, axisLabelFormatter: (t) => (t < 0 ? '' : fixed(t, Number.isInteger(t) ? 0 : 1) + ' s') },
        y: { pixelsPerLabel: 15 },
      },
    });
  };
  const makeStrip = (index, channel, parent) => {
    const kind = index < TRANSDUCERS ? 'displacement' : 'tension';
    const box = element('div', 'strip ' + kind), head = element('header'), plot = element('div', 'plot');
    const strip = { index, kind, box: plot, value: element('span', 'value'), range: element('span', 'range') };
    const where = channel.station_ft === null ? '' : '  ' + shown(channel.station_ft, 'station', 1) + (channel.band ? ', band ' + channel.band : '');
    head.append(element('span', 'name', channel.name + where), strip.range, strip.value);
    box.id = 'strip-' + (kind === 'displacement' ? 'd' : 't') + (kind === 'displacement' ? index + 1 : index - TRANSDUCERS + 1);
    strip.range.title = 'minimum and maximum since arming';
    box.append(head, plot);
    parent.append(box);
    return strip;
  };
  const makeStrips = () => {
    for (const strip of strips) if (strip.plot) strip.plot.destroy();
    $('displacements').replaceChildren();
    $('tensions').replaceChildren();
    strips = configuration.channels.map((channel, i) => (channel.fitted ? makeStrip(i, channel, $(i < TRANSDUCERS ? 'displacements' : 'tensions')) : null)).filter((s) => s);
    strips.forEach(makePlot);
    for (const kind of ['displacement', 'tension']) {
      say(kind + '-says', strips.filter((s) => s.kind === kind).length + ' channels, ' + unit(kind).text + ' against board time, s; range: minimum and maximum since arming');
    }
    $('tensions').style.gridTemplateRows = 'repeat(' + Math.max(1, Math.ceil(strips.filter((s) => s.kind === 'tension').length / 2)) + ',auto)';
  };
  const resize = () => {
    strips.forEach((s) => s.plot.resize());
    if (map && WIDTH !== Math.max(280, $('runway').clientWidth)) { drawRunway(); updateRunway(); }
  };

  const endOfTime = () => (newestBucket < 0 ? span : (newestBucket + 1) * (configuration ? configuration.bucket_s : 0.02));
  /* One scale for all of a kind, so that they compare; it grows at once and is a round number. */
  const niceRange = (least, most, floor) => {
    if (!isFinite(least) || !isFinite(most)) return null;
    const room = Math.max(most - least, floor) * 0.08, step = Math.pow(10, Math.floor(Math.log10(Math.max(most - least, floor)))) / 2;
    let low = least - room, high = most + room;
    if (high - low < floor) { const middle = (high + low) / 2; low = middle - floor / 2; high = middle + floor / 2; }
    return [Math.floor(low / step) * step, Math.ceil(high / step) * step];
  };
  let drawnAt = 0;
  const draw = () => {
    requestAnimationFrame(draw);
    const now = performance.now();
    if (now - drawnAt < DRAW_MS || !configuration || document.hidden) return;
    drawnAt = now;
    const tier = span > 60 ? coarse : fine, from = endOfTime() - span;
    const data = strips.map((s) => columns(tier, s.index, from, s.box.clientWidth - 60, unit(s.kind).factor));
    for (const kind of ['displacement', 'tension']) {
      let least = Infinity, most = -Infinity;
      strips.forEach((s, i) => {
        if (s.kind !== kind) return;
        for (const [, [low, , high]] of data[i]) {
          if (low < least) least = low;
          if (high > most) most = high;
        }
      });
      ranges[kind] = niceRange(least, most, (kind === 'displacement' ? 0.05 : 10) * unit(kind).factor) || ranges[kind];
    }
    strips.forEach((s, i) => s.plot.updateOptions({ file: data[i].length ? data[i] : NOTHING, dateWindow: [from, from + span], valueRange: ranges[s.kind] }));
  };

  /* ---- the runway ---- */
  const SVG = 'http://www.w3.org/2000/svg', LEFT = 24, RIGHT = 24;
  let WIDTH = 1150; /* of its place: a point of the map is one of the screen, so that labels can be read on a telephone */
  const svg = (name, attributes, text) => {
    const made = document.createElementNS(SVG, name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  let map = null;
  const runwayEnd = () => Math.max(120, ...configuration.runway.segments.map((s) => s.end_ft || 0), ...configuration.runway.switches.map((s) => s.station_ft || 0));
  const atFt = (ft) => LEFT + (WIDTH - LEFT - RIGHT) * Math.max(0, Math.min(1, ft / runwayEnd()));
  const patterns = () => {
    const defs = svg('defs');
    const hatch = svg('pattern', { id: 'hatch', width: 9, height: 9, patternUnits: 'userSpaceOnUse', patternTransform: 'rotate(45)' });
    hatch.append(svg('rect', { width: 9, height: 9, fill: 'var(--paper)' }), svg('rect', { width: 4, height: 9, fill: 'var(--closed)' }));
    const hazard = svg('pattern', { id: 'hazard', width: 20, height: 20, patternUnits: 'userSpaceOnUse', patternTransform: 'rotate(45)' });
    hazard.append(svg('rect', { width: 20, height: 20, fill: '#ffd400' }), svg('rect', { width: 10, height: 20, fill: '#000' }));
    const unknown = svg('pattern', { id: 'unknown', width: 6, height: 6, patternUnits: 'userSpaceOnUse' });
    unknown.append(svg('circle', { cx: 2, cy: 2, r: 0.9, fill: 'var(--soft)' }));
    defs.append(hatch, hazard, unknown);
    return defs;
  };
  const shade = (segment) => { /* more slack: lighter; not surveyed: dotted */
    if (segment.slack_in === null || !segment.joints) return { fill: 'url(#unknown)' };
    const open = Math.max(0, Math.min(1, segment.slack_in / segment.joints / 0.036));
    return { fill: 'var(--tight)', 'fill-opacity': (0.85 * (1 - open)).toFixed(2) };
  };
  const drawRunway = () => {
    WIDTH = Math.max(280, $('runway').clientWidth);
    const end = runwayEnd(), u = unit('station');
    const root = svg('svg', { class: 'map', viewBox: '0 0 ' + WIDTH + ' 156', role: 'img', 'aria-label': 'runway' });
    root.append(patterns());
    for (const s of configuration.runway.segments) {
      const rect = svg('rect', { x: atFt(s.start_ft), y: 62, width: Math.max(1, atFt(s.end_ft) - atFt(s.start_ft)), height: 44, ...shade(s) });
      rect.append(svg('title', {}, shown(s.start_ft, 'station', 1) + ' to ' + shown(s.end_ft, 'station', 1) + ': slack ' + (s.slack_in === null ? 'not surveyed' : shown(s.slack_in, 'displacement', 3) + ' in ' + s.joints + ' joints')));
      root.append(rect);
    }
    map = { zone: svg('rect', { class: 'zone', y: 56, height: 56, visibility: 'hidden' }), zoneText: svg('text', { y: 50, 'text-anchor': 'middle' }), switches: new Map() };
    root.append(svg('rect', { class: 'outline', x: atFt(0), y: 62, width: atFt(end) - atFt(0), height: 44 }), map.zone);
    configuration.channels.forEach((c, i) => {
      if (i >= TRANSDUCERS || !c.fitted || c.station_ft === null) return;
      const x = atFt(c.station_ft);
      root.append(svg('path', { class: 'sensor', d: 'M' + (x - 7) + ' 20h14l-7 12z' }), svg('text', { class: 'soft', x, y: 15, 'text-anchor': 'middle' }, c.name));
    });
    for (const s of configuration.runway.switches) {
      if (s.station_ft === null) continue;
      const mark = svg('rect', { class: 'switch', x: atFt(s.station_ft) - 4, y: 112, width: 8, height: 12 });
      mark.append(svg('title', {}, 'switch ' + s.position + ' at ' + shown(s.station_ft, 'station', 2)));
      map.switches.set(s.position, mark);
      root.append(mark);
    }
    const step = [5, 10, 20, 50].find((s) => atFt(s / u.factor) - atFt(0) >= 32);
    for (let at = 0; at / u.factor <= end + 0.01; at += step) {
      const x = atFt(at / u.factor);
      root.append(svg('line', { class: 'tick', x1: x, x2: x, y1: 130, y2: 136 }), svg('text', { class: 'soft', x, y: 149, 'text-anchor': 'middle' }, String(at)));
    }
    say('legend', 'Station (' + u.text + ') · ▼ transducer · ▮ switch, filled: passed by the gear · dark shade: small openings, dots: not surveyed · hatched: closed joints');
    if (configuration.runway.touchdown_ft !== null) {
      const x = atFt(configuration.runway.touchdown_ft);
      root.append(svg('line', { class: 'tick', x1: x, x2: x, y1: 36, y2: 106, 'stroke-dasharray': '4 3' }), svg('text', { class: 'soft', x: x + 3, y: 46 }, 'touchdown'));
    }
    map.gear = svg('g', { visibility: 'hidden', id: 'gear' });
    map.gearText = svg('text', { class: 'gear-label', y: 91, x: 18 });
    map.gear.append(svg('line', { class: 'gear-line', x1: 0, x2: 0, y1: 34, y2: 124 }), svg('circle', { class: 'gear', cx: 0, cy: 84, r: 12 }), svg('circle', { class: 'gear', cx: -22, cy: 84, r: 12 }), map.gearText);
    root.append(map.zoneText, map.gear);
    $('runway').replaceChildren(root);
  };
  const updateRunway = () => {
    if (!map || !state) return;
    const zone = state.zone, gear = state.gear.station_ft, on = zone.mats > 0 && zone.start_ft !== null;
    map.zone.setAttribute('visibility', on ? 'visible' : 'hidden');
    map.zone.setAttribute('class', state.warning.on ? 'zone hot' : 'zone');
    if (on) {
      map.zone.setAttribute('x', atFt(zone.start_ft));
      map.zone.setAttribute('width', Math.max(2, atFt(zone.end_ft) - atFt(zone.start_ft)));
      map.zoneText.setAttribute('x', Math.min(WIDTH - 120, Math.max(120, (atFt(zone.start_ft) + atFt(zone.end_ft)) / 2)));
    }
    map.zoneText.textContent = on ? zone.mats + ' mats closed, ' + fixed(zone.start_ft * unit('station').factor, 1) + ' to ' + shown(zone.end_ft, 'station', 1) : '';
    map.gear.setAttribute('visibility', gear === null ? 'hidden' : 'visible');
    if (gear !== null) {
      const x = atFt(gear);
      map.gear.setAttribute('transform', 'translate(' + x + ' 0)');
      map.gearText.textContent = shown(gear, 'station', 1);
      const behind = x > LEFT + 110; /* where nothing is left to be seen; ahead of it only at the very beginning */
      map.gearText.setAttribute('text-anchor', behind ? 'end' : 'start');
      map.gearText.setAttribute('x', behind ? -40 : 18);
    }
    const opened = new Set(state.opened);
    for (const [position, mark] of map.switches) mark.setAttribute('class', opened.has(position) ? 'switch opened' : 'switch');
  };

  /* ---- tiles and warning ---- */
  const tile = (name, className, sign, big, small) => {
    const box = $('tile-' + name);
    if (box.className !== 'tile ' + className) box.className = 'tile ' + className;
    const mark = box.querySelector('.sign');
    if (mark && mark.textContent !== sign) mark.textContent = sign;
    say(name + '-big', big);
    say(name + '-small', small);
  };
  const leadWords = (zone) => (zone.lead_s === null ? 'time to zone not known' : zone.lead_s < 0.05 ? 'wheel at the zone' : 'time to zone ' + fixed(zone.lead_s, 2) + ' s');
  const zoneWords = (zone, lead) => zone.mats + ' mats closed ahead, stations ' + fixed(zone.start_ft === null ? null : zone.start_ft * unit('station').factor, 1) + ' to ' + shown(zone.end_ft, 'station', 1) +
    (lead ? '; ' + leadWords(zone) : '');
  const expectedWords = (zone) => zone.mats + ' closed mats expected with the wheel at ' + shown(zone.wheel_ft, 'station', 1);
  /* An advisory may come and go 20 times a second: the tile shows it for at least a second. */
  const ADVICE_MS = 1000;
  let advice = null, advisedAt = -ADVICE_MS;
  const adviceWords = (v) => v.reason + (v.coming_mats !== null ? ': ' + v.coming_mats + ' mats with the wheel at ' + shown(v.coming_wheel_ft, 'station', 1)
    : v.compression_lb !== null ? ': ' + fixed(v.compression_lb * unit('tension').factor, 0) + ' of ' + shown(v.critical_lb, 'tension', 0) : '');
  const advised = () => {
    const v = state.verdict;
    if (v && v.advisory) { advice = v; advisedAt = performance.now(); }
    return advice !== null && performance.now() - advisedAt < ADVICE_MS;
  };
  const quietWords = () => (state.zone.mats > 0 ? 'longest closed zone: ' + state.zone.mats + ' mats; the board warns from ' + configuration.limits.warning_mats : 'no closed joints ahead') +
    (state.verdict && state.verdict.since_us > 0 ? '; advisory at ' + clock(state.verdict.since_us) + ': ' + state.verdict.since_reason : '');
  /* Of the landing: the probability of a zone, from where on the lamp warns, the time to where failure is expected. */
  const riskWords = () => {
    const r = state.risk;
    if (!r || r.risk === null) return '';
    return '; risk ' + fixed(r.risk, 2) + (r.lamp_limit !== null ? ' (lamp limit ' + fixed(r.lamp_limit, 2) + ')' : '') + (r.of_chart ? ', from chart and plan' : r.of_plan ? ', from the plan' : '') +
      (r.failure_s !== null ? ', failure expected at ' + shown(r.failure_ft, 'station', 1) + ' in ' + fixed(r.failure_s, 2) + ' s' : '');
  };
  const outcomeWords = () => state.outcome.split(': ', 2).join(': '); /* without its evidence, which the events have: tiles keep their height */
  const showWarning = () => {
    const w = state.warning, zone = state.zone.mats > 0 ? state.zone : w.zone, box = $('warning'), past = !w.on && w.since_us > 0;
    box.hidden = !(w.on || (past && seen !== w.since_us));
    box.className = w.on ? '' : 'past';
    document.body.classList.toggle('warned', w.on);
    if (w.on || past) {
      say('warning-title', w.on ? 'WARNING: JOINTS ' + (state.expected ? 'CLOSING' : 'CLOSED') + ' AHEAD' : 'The board warned at ' + clock(w.since_us) + '; the warning is over');
      say('warning-text', w.on ? (state.expected ? expectedWords(state.expected) : zoneWords(zone, true)) : (state.outcome ? outcomeWords() + '; ' : 'first warning in block ' + w.first_decided_block + '; ') + 'zone warned of: ' + zoneWords(w.zone, false));
    }
    $('warning-seen').hidden = w.on;
    const advises = advised() && !w.on; /* looked at each time: it keeps the newest */
    document.title = (lost() ? '✕ BOARD SILENT · ' : w.on ? '▲ WARNING · ' : advises ? 'advisory · ' : '') + state.state + ' · matrig live';
    sound(w.on);
    if (w.on) tile('warning', 'hot', '▲', 'WARNING', (state.expected ? expectedWords(state.expected) : leadWords(zone)) + riskWords());
    else if (advises) tile('warning', 'advised', '!', 'advisory', adviceWords(advice) + '. The lamp is off' + riskWords());
    else tile('warning', past ? '' : 'good', past ? '△' : '○', past ? 'over' : 'none', state.outcome ? outcomeWords() : quietWords() + riskWords());
  };
  const silentMs = () => (state && state.heard_us ? (state.now_us - state.heard_us) / 1000 + (performance.now() - stateAt) : Infinity);
  const lost = () => !!configuration && configuration.source.commands && isFinite(silentMs()) && silentMs() > LOST_MS;
  const showBoard = () => {
    const b = configuration.board, faults = state.health.faults.length, ms = silentMs();
    const who = b.uid ? 'firmware ' + b.firmware + (b.commit ? ', ' + b.commit : '') + ', board ' + b.uid : '';
    if (b.other_layout) tile('board', 'bad', '✕', 'other version', 'the board uses another message layout: install firmware and matrig of one version');
    else if (!isFinite(ms)) tile('board', '', '…', 'waiting', 'no message received yet');
    else if (ended || (!configuration.source.commands && ms > ENDED_MS)) tile('board', '', '■', 'ended', 'last message at ' + clock(state.heard_us) + '; ' + who);
    else if (ms > SILENT_MS) tile('board', 'bad', '✕', 'SILENT', 'no message on any link for ' + fixed(ms / 1000, ms < 10000 ? 1 : 0) + ' s; ' + who);
    else tile('board', faults ? '' : 'good', faults ? '▲' : '●', faults ? 'alive, ' + faults + (faults > 1 ? ' faults' : ' fault') : 'alive', who);
  };
  const SIGNS = { idle: '○', armed: '◆', landing: '▶', settling: '◇', done: '■', unknown: '?' };
  const showLanding = () => {
    const recording = ['armed', 'landing', 'settling'].includes(state.state);
    tile('state', recording ? 'armed' : '', SIGNS[state.state] || '?', state.state.toUpperCase(),
      (state.landing ? 'landing ' + state.landing + ', ' : '') + state.gear.edges + ' switches opened; board time ' + (state.block < 0 ? '–' : fixed(state.block / 1000, 1) + ' s'));
    $('arm').disabled = !canCommand() || recording;
    $('disarm').disabled = !canCommand() || !(recording || state.state === 'done');
  };
  const showGear = () => {
    const g = state.gear, f = g.final;
    const small = f ? 'touchdown ' + shown(f.touchdown_ft_s, 'speed', 3) + (f.touchdown_error_ft_s === null ? '' : ' ± ' + fixed(f.touchdown_error_ft_s * unit('speed').factor, 3)) +
      (f.deceleration_ft_s2 === null ? '' : ', ' + shown(f.deceleration_ft_s2, 'deceleration', 3)) + (f.after_s === null ? '' : ', stopped after ' + fixed(f.after_s, 2) + ' s')
      : g.speed_ft_s === null ? 'no speed yet' : shown(g.speed_ft_s, 'speed', 2) + ' ± ' + fixed(g.speed_error_ft_s === null ? null : g.speed_error_ft_s * unit('speed').factor, 2) + ', deceleration ' + shown(g.deceleration_ft_s2, 'deceleration', 2) + ', at the last switch';
    tile('gear', '', '', g.station_ft === null ? 'not detected' : shown(g.station_ft, 'station', 1), small);
  };

  /* ---- tables ---- */
  const cells = new Map();
  const cell = (parent, key, make) => {
    if (!cells.has(key)) { const made = make(); cells.set(key, made); parent.append(made.row || made); }
    return cells.get(key);
  };
  const showLinks = () => {
    const body = $('links').tBodies[0];
    for (const link of state.links) {
      if (!link.used) continue;
      const row = cell(body, 'link ' + link.name, () => {
        const tr = element('tr');
        return { row: tr, td: Array.from({ length: 7 }, () => tr.appendChild(element('td'))) };
      });
      const ago = link.heard_us ? (state.now_us - link.heard_us) / 1e6 : null;
      [link.name, link.received, link.lost, link.dropped, link.bad, link.foreign, ago !== null && ago < 1e6 ? fixed(ago, 1) : '–'].forEach((v, i) => {
        const text = String(v);
        if (row.td[i].textContent !== text) row.td[i].textContent = text;
        if (i >= 2 && i <= 4) row.td[i].className = v > 0 ? 'lost' : '';
      });
    }
  };
  const fact = (name, text, bad, wide) => {
    const made = cell($('health'), 'fact ' + name, () => {
      const row = element('div', wide ? 'wide' : ''), dd = element('dd');
      row.append(element('dt', '', name), dd);
      return { row, dd };
    });
    if (made.dd.textContent !== text) made.dd.textContent = text;
    made.dd.className = bad ? 'bad' : '';
  };
  const showHealth = () => {
    const h = state.health;
    fact('faults since reset', !h.known ? 'not reported yet' : h.faults.length ? h.faults.map((f) => f.text + (f.count ? ' (' + f.count + ' times)' : '')).join('; ') : 'none', h.faults.length > 0, true);
    fact('restarts seen', String(h.restarts), h.restarts > 0);
    fact('blocks lost, ms', String(h.blocks_lost), h.blocks_lost > 0);
    fact('CAN as the board reports it', h.can || '–', !h.can_good);
    fact('black box', (h.black_box || '–') + (h.black_box ? ', ' + h.black_box_records + ' records' : '') + (h.black_box_wait_s ? ', ready in ' + fixed(h.black_box_wait_s, 0) + ' s' : ''), !h.black_box_good);
    for (const q of configuration.quantities) {
      const value = h[q.key], error = h[q.error_key];
      fact(q.words, value === null ? '–' : fixed(value, q.decimals) + (error === null ? ' ' : ' ± ' + fixed(error, q.decimals) + ' ') + q.unit, false);
    }
    for (const b of state.bands) fact('band ' + b.band + ', minimum / mean / maximum', [b.least_lb, b.mean_lb, b.most_lb].map((v) => fixed(v === null ? null : v * unit('tension').factor, 1)).join(' / ') + ' ' + unit('tension').text, false);
    fact('readings from', state.source + (state.late ? '; ' + state.late + ' arrived too late for the plot' : ''), state.late > 0);
  };
  let notices = 0;
  const showNotices = () => {
    const list = $('notices');
    if (state.notices.length && state.notices[state.notices.length - 1].n < notices) { notices = 0; list.replaceChildren(); } /* another matrig */
    for (const n of state.notices) {
      if (n.n <= notices) continue;
      const item = element('li', n.severity), time = element('time', '', clock(n.us));
      item.append(time, n.text);
      list.prepend(item);
      notices = n.n;
      while (list.childElementCount > 200) list.lastElementChild.remove();
    }
  };
  const showReadings = () => {
    for (const s of strips) {
      const [value, least, most, why] = state.readings[s.index], digits = digitsOf(s.kind);
      const text = value === null ? why || '–' : shown(value, s.kind, digits);
      if (s.value.textContent !== text) { s.value.textContent = text; s.value.className = 'value' + (why ? ' invalid' : ''); }
      const range = least === null ? '' : fixed(least * unit(s.kind).factor, digits) + ' to ' + fixed(most * unit(s.kind).factor, digits);
      if (s.range.textContent !== range) s.range.textContent = range;
    }
  };
  const showState = () => {
    if (!configuration || !state) return;
    showWarning(); /* first: it must not wait for the rest */
    const marks = [configuration.board.emulated && 'EMULATED BOARD, SYNTHETIC DATA', state.uncalibrated && 'UNCALIBRATED'].filter((t) => t).join(' · ');
    say('marks', marks);
    $('marks').hidden = !marks;
    const newest = state.notices[state.notices.length - 1];
    say('newest', newest ? clock(newest.us) + '  ' + newest.text : '');
    showBoard(); showLanding(); showGear(); updateRunway(); showReadings(); showLinks(); showHealth(); showNotices();
  };

  /* ---- sound ---- */
  let audio = null, beeper = 0;
  const beep = () => {
    if (!audio) return;
    [880, 1320].forEach((pitch, i) => {
      const tone = audio.createOscillator(), gain = audio.createGain(), at = audio.currentTime + 0.16 * i;
      tone.type = 'square';
      tone.frequency.value = pitch;
      gain.gain.setValueAtTime(0.25, at);
      gain.gain.exponentialRampToValueAtTime(0.001, at + 0.15);
      tone.connect(gain).connect(audio.destination);
      tone.start(at);
      tone.stop(at + 0.16);
    });
  };
  const sound = (on) => {
    if (on && audio && !beeper) { beep(); beeper = setInterval(beep, 500); }
    if ((!on || !audio) && beeper) { clearInterval(beeper); beeper = 0; }
  };
  const toggleSound = () => {
    if (audio) { audio.close(); audio = null; sound(false); } else { audio = new AudioContext(); beep(); }
    $('sound').setAttribute('aria-pressed', String(!!audio));
    say('sound', 'Sound: ' + (audio ? 'on' : 'off'));
  };

  /* ---- commands ---- */
  const canCommand = () => !!(configuration && configuration.source.commands && token && connected);
  let pending = null;
  const ask = (command) => {
    if (!canCommand() || $(command).disabled) return;
    pending = command;
    const armed = state.state === 'armed';
    say('confirm-title', command === 'arm' ? 'Arm for a landing?' : 'Disarm?');
    say('confirm-text', command === 'arm' ? 'The board records until the gear has stopped and the mat is at rest.'
      : armed ? 'The board returns to idle. This landing has no readings yet.'
      : state.state === 'done' ? 'The landing is stored. The board returns to idle.' : 'A LANDING IS IN PROGRESS. Its record ends now.');
    $('confirm-number').hidden = command !== 'arm';
    say('confirm-yes', command === 'arm' ? 'Arm' : 'Disarm');
    $('confirm').showModal();
    (command === 'arm' ? $('landing') : $('confirm-no')).focus();
  };
  const send = async () => {
    const body = { command: pending, until_us: Math.round(state.now_us + (performance.now() - stateAt + ORDER_MS) * 1000) };
    if (pending === 'arm') {
      const number = Number($('landing').value);
      if (!Number.isInteger(number) || number < 0 || number > 65535) { $('landing').focus(); return; }
      body.landing = number;
    }
    $('confirm').close();
    say('command-said', pending + ': sent …');
    try {
      const answer = await fetch('/command', { method: 'POST', headers: { 'Content-Type': 'application/json', 'X-Matrig-Token': token }, body: JSON.stringify(body), signal: AbortSignal.timeout(ANSWER_MS) });
      const text = await answer.text();
      let told = { error: text.trim() };
      try { told = JSON.parse(text); } catch (e) { /* plain words */ }
      say('command-said', body.command + (told.done ? ': done, ' + new Date().toLocaleTimeString('en-GB') : ': ' + (told.error || 'failed')));
    } catch (e) {
      say('command-said', body.command + ': no answer from matrig, which now refuses this command; repeat it');
    }
  };

  /* ---- the connection ---- */
  const takeConfiguration = (told) => {
    const text = JSON.stringify({ ...told, source: null, board: null, of: null, configured: 0 });
    const changed = !configuration || text !== configuration.text;
    configuration = told;
    for (const u of Object.values(told.units)) u.text = u.text.replace('/s2', '/s²');
    configuration.text = text;
    const s = told.source;
    say('source', s.db + '  ·  ' + [s.can && 'CAN ' + s.can, s.serial && 'serial ' + s.serial].filter((t) => t).join('  ·  '));
    if (!s.commands) say('command-said', 'Watching only: ' + (s.no_commands || ''));
    else if (!token) say('command-said', 'Watching only: open the whole address that matrig printed, including the part after #');
    if (changed) { makeStrips(); drawRunway(); }
    showState();
  };
  let source = null, retryMs = 250, retry = 0, lastId = '', due = false, ended = '', crowded = false, claiming = false, release = null;
  const tabs = new BroadcastChannel('matrig');
  const refresh = () => {
    due = false;
    if (!board || !board.host.links.length) return; /* its first state follows */
    const warned = state && state.warning.on;
    state = board.state();
    if (!configuration || configuration.of !== board || configuration.configured !== board.configured) takeConfiguration(Object.assign(board.configuration(), { of: board, configured: board.configured }));
    else if (warned !== state.warning.on) showWarning();
    showState();
  };
  const takeMessages = (messages) => {
    const warned = board.warning.on;
    for (const message of messages) board.take(message);
    if (board.warning.on !== warned) refresh(); /* it must not wait */
    else if (!due) { due = true; requestAnimationFrame(refresh); }
  };
  /* One of the streams that this browser may have: a tab holds it until it is closed, or is hidden and another one wants it. */
  const claim = async () => {
    if (release || !navigator.locks) return true;
    for (let n = 0; n < STREAMS && !release; n++) {
      await new Promise((told) => navigator.locks.request('stream ' + n, { ifAvailable: true }, (lock) => {
        const held = lock && new Promise((free) => { release = free; });
        told();
        return held;
      }));
    }
    if (!release) tabs.postMessage({ wanted: true });
    return release !== null;
  };
  const connect = async () => {
    clearTimeout(retry);
    retry = 0;
    if (claiming) return;
    claiming = true;
    crowded = !await claim();
    claiming = false;
    if (crowded) { if (!document.hidden) retry = setTimeout(connect, 500); return; }
    if (source) source.close();
    source = new EventSource('/events');
    const on = (name, take) => source.addEventListener(name, (event) => {
      heardFrom = performance.now();
      lastId = event.lastEventId;
      connected = true;
      ended = '';
      retryMs = 250;
      take(JSON.parse(event.data));
    });
    on('configuration', (told) => { board = new Board(told); });
    on('messages', takeMessages);
    on('readings', takeReadings);
    on('state', (told) => { board.takeHost(told); stateAt = performance.now(); refresh(); });
    source.addEventListener('end', (event) => {
      tabs.postMessage({ ended: JSON.parse(event.data).text });
      over(JSON.parse(event.data).text);
    });
    /* The browser comes back by itself; when it has given up, or hangs, we do. */
    source.onerror = () => { if (source.readyState === EventSource.CLOSED) again(); };
  };
  const over = (text) => { /* the next matrig at this address is waited for */
    ended = text;
    heardFrom = -Infinity;
    watch();
  };
  tabs.onmessage = ({ data }) => {
    if (data.ended && (!source || !connected)) over(data.ended);
    if (!data.wanted || !document.hidden || !release) return;
    source.close();
    source = null;
    release();
    release = null;
  };
  const seenOrNot = () => {
    if (document.hidden || (source && source.readyState !== EventSource.CLOSED)) return;
    heardFrom = ended ? heardFrom : performance.now();
    connect();
  };
  const again = () => {
    clearTimeout(retry);
    retry = setTimeout(connect, retryMs);
    retryMs = Math.min(2 * retryMs, 8000);
  };
  const watch = () => {
    const ms = performance.now() - heardFrom, old = ms > STALE_MS;
    if (document.hidden && !ended) return;
    if (old && connected) { connected = false; if (state) showState(); }
    const silent = !old && lost();
    $('offline').hidden = !old && !silent;
    $('offline').className = old && ended ? 'ended' : '';
    document.body.classList.toggle('stale', old || silent);
    if (old) {
      say('offline', ended ? ended + '. This page shows the last state'
        : crowded ? '✕ ' + STREAMS + ' other tabs or windows of this browser show this page, which is the limit: close one of them'
        : '✕ NO CONNECTION to matrig for ' + fixed(ms / 1000, 0) + ' s: this page is out of date');
      document.title = (ended ? 'log ended' : crowded ? 'too many tabs' : 'no connection') + ' · matrig live';
      sound(false);
      if ((ended || ms > 5000) && !retry) again();
    } else if (configuration && state) {
      if (silent) say('offline', '✕ THE BOARD IS SILENT for ' + fixed(silentMs() / 1000, 0) + ' s: nothing is recorded; check its power and cables');
      showBoard();
    }
  };

  /* ---- controls ---- */
  const setSpan = (seconds) => {
    span = seconds;
    for (const b of document.querySelectorAll('[data-span]')) b.setAttribute('aria-pressed', String(Number(b.dataset.span) === span));
  };
  const start = () => {
    const recolour = () => { strips.forEach((s) => s.plot.updateOptions(matrigCharts.colours())); };
    for (const query of ['(prefers-color-scheme:dark)', 'print']) matchMedia(query).addEventListener('change', recolour);
    for (const b of document.querySelectorAll('[data-span]')) b.addEventListener('click', () => setSpan(Number(b.dataset.span)));
    $('sound').addEventListener('click', toggleSound);
    $('arm').addEventListener('click', () => ask('arm'));
    $('disarm').addEventListener('click', () => ask('disarm'));
    $('confirm-no').addEventListener('click', () => $('confirm').close());
    $('confirm-yes').addEventListener('click', send);
    $('warning-seen').addEventListener('click', () => { seen = state.warning.since_us; showWarning(); });
    addEventListener('resize', resize);
    addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === 'INPUT' || $('confirm').open) return;
      const does = { a: () => ask('arm'), d: () => ask('disarm'), s: toggleSound, 1: () => setSpan(10), 2: () => setSpan(60), 3: () => setSpan(3600) }[event.key.toLowerCase()];
      if (does) { event.preventDefault(); does(); }
    });
    heardFrom = performance.now();
    $('arm').disabled = $('disarm').disabled = true;
    setInterval(watch, 250);
    document.addEventListener('visibilitychange', seenOrNot);
    connect();
    requestAnimationFrame(draw);
    window.matrigLive = { fine, coarse, get board() { return board; }, get state() { return state; }, get configuration() { return configuration; }, get lastId() { return lastId; }, reconnect: connect };
  };
  start();
})();
