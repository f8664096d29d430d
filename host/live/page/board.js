'use strict';
/* What the board says, kept from its messages: the newest of everything, and what follows from it. Messages are those of the catalogue, one
 * object each (host/live/json.h). A displacement, a speed, ... is in the report's units; a value that is missing is null. */
class Board {
  constructor(fixed) {
    this.fixed = fixed; /* the configuration event: what is the same for every board */
    this.links = [{ newest: -1, heard: 0 }, { newest: -1, heard: 0 }]; /* CAN, serial */
    this.channels = Array.from({ length: 22 }, () => ({ known: false, kind: 1, number: 0, station_ft: null, band: 0 }));
    this.switches = new Map();
    this.segments = new Map();
    this.bands = new Map();
    this.faults = new Map();
    this.quantities = {};
    this.limits = { warning_mats: 0 };
    this.touchdown_ft = null;
    this.uid = [0, 0, 0];
    this.hello = this.health = this.alarm = this.box = this.upkeep = this.ack = this.commit = null;
    this.landing = null;
    this.lampLimit = null;
    this.restarts = 0;
    this.notices = [];
    this.noticed = 0;
    this.configured = 0; /* counts changes of what configuration() has */
    this.host = { now_us: 0, block: -1, source: 'CAN', late: 0, links: [], readings: [] }; /* the newest state event */
    this.forgetLanding();
  }
  forgetLanding() {
    this.zone = { block: -1, mats: 0, start_ft: null, end_ft: null, lead_s: null, wheel_ft: null, warning: false, inferred_percent: 0 };
    this.warning = { on: false, since_us: 0, received_us: 0, off_us: 0, first_decided_block: null, zone: this.zone };
    this.verdict = null;
    this.advised = { since_us: 0, reason: '', told: new Set() };
    this.risk = null;
    this.outcome = '';
    this.motion = null;
    this.reached_ft = null;
    this.touchdown = this.stop = null;
    this.opened = new Set();
    this.edges = 0;
  }
  notice(severity, us, text) {
    this.notices.push({ n: ++this.noticed, us, severity: severity.toLowerCase(), text });
    if (this.notices.length > 40) this.notices.shift();
  }

  /* ---- messages ---- */
  take(m) {
    const link = this.links[m.l], block = m.b === null ? -1 : m.b;
    if (m.m !== 'notice') link.heard = Math.max(link.heard, m.t); /* a notice comes from the log, not from the link */
    if (block >= 0 && link.newest - block >= 1000) this.restart(m.t);
    link.newest = Math.max(link.newest, block);
    if (m.quantity) this.quantities[m.quantity] = { value: m.value, error: m.error };
    /* what is told once, as a line; of two links the one that says it first */
    if (m.notice && !(m.l === 0 && this.links[1].heard + 1e6 > m.t)) this.notice(m.severity, m.t, m.notice);
    const takes = this['take_' + m.m];
    if (takes) takes.call(this, m, link, block);
    if (m.outcome) this.outcome = m.notice; /* of the log, once the landing is stored */
  }
  restart(us) {
    this.forgetLanding();
    this.restarts++;
    this.landing = null;
    this.faults.clear();
    for (const link of this.links) link.newest = -1;
    this.notice('alarm', us, 'the board restarted');
  }
  configure(object, key, value) {
    if (JSON.stringify(object[key]) !== JSON.stringify(value)) this.configured++;
    object[key] = value;
  }
  take_hello(m) { this.configure(this, 'hello', { layout: m.layout, firmware: m.major + '.' + m.minor + '.' + m.patch }); }
  take_board_uid(m) { this.configure(this, 'uid', [m.uid0, m.uid1, this.uid[2]]); }
  take_board_image(m) { this.configure(this, 'uid', [this.uid[0], this.uid[1], m.uid2]); }
  take_image_commit(m) {
    const hex = (value, digits) => value.toString(16).padStart(digits, '0');
    this.configure(this, 'commit', m.commit || m.commit_more ? hex(m.commit, 8) + hex(m.commit_more, 4) + (m.changed ? '-dirty' : '') : 'unknown');
  }
  take_board_config(m) { this.configure(this.limits, 'warning_mats', m.warning_mats); }
  take_site(m) { this.configure(this, 'touchdown_ft', m.touchdown_ft); }
  take_channel(m) {
    const known = this.channels[m.index];
    if (known) this.configure(this.channels, m.index, { ...known, known: true, kind: m.kind, station_ft: m.station_ft });
  }
  take_channel_zero(m) {
    const known = this.channels[m.index];
    if (known) this.configure(this.channels, m.index, { ...known, number: m.number, band: m.band });
  }
  keep(map, key, value) {
    if (JSON.stringify(map.get(key)) !== JSON.stringify(value)) this.configured++;
    map.set(key, value);
  }
  take_switch_place(m) { if (m.position) this.keep(this.switches, m.position, { position: m.position, station_ft: m.station_ft }); }
  take_slack(m) { this.keep(this.segments, m.segment, { start_ft: m.start_ft, end_ft: m.end_ft, joints: m.joints, slack_in: m.slack_in }); }

  take_landing(m) {
    const known = this.landing;
    if (known && (m.block < known.block || (m.state === known.state && m.landing === known.landing))) return;
    const armed = m.state_text === 'armed';
    if (armed) this.forgetLanding();
    this.landing = { state: m.state, text: m.state_text, landing: m.landing, block: m.block };
    this.notice(armed ? 'note' : 'say', m.t, m.state_text + ', landing ' + m.landing);
  }
  take_edge(m) {
    if (m.position >= 1) this.opened.add(m.position);
    this.edges = Math.max(this.edges, m.count);
  }
  take_motion(m, link, block) {
    link.motion = m;
    if (!this.motion || block >= this.motion.block) this.motion = { block, ...m, speed_error_ft_s: null, deceleration_error_ft_s2: null };
  }
  take_motion_error(m, link, block) {
    if (!link.motion || m.block16 !== link.motion.block16 || (this.motion && block < this.motion.block)) return;
    this.motion = { block, ...link.motion, speed_error_ft_s: m.speed_ft_s, deceleration_error_ft_s2: m.deceleration_ft_s2 };
  }
  take_touchdown(m) { this.touchdown = m; }
  take_stop(m) { this.stop = m; }
  take_band_state(m) { if (m.band >= 1) this.bands.set(m.band, m); }
  take_ack(m) {
    const again = this.ack && this.ack.tag === m.tag && this.ack.code === m.code && this.ack.block === m.block;
    this.ack = m;
    if (!again && m.status !== 0 && (m.code === this.fixed.arm || m.code === this.fixed.disarm)) this.notice('alarm', m.t, (m.code === this.fixed.arm ? 'arm' : 'disarm') + ' refused: ' + (this.fixed.statuses[-m.status] || m.status));
  }

  /* Zone and its second half have the same block; the newer of the two links' statements counts. */
  take_zone(m, link) { link.zone = m; }
  take_zone_lead(m, link, block) {
    const first = link.zone;
    if (!first || m.block16 !== first.block16 || block < this.zone.block) return;
    this.zone = { block, mats: first.mats, start_ft: first.start_ft, end_ft: first.end_ft, lead_s: m.lead_s, wheel_ft: m.wheel_ft, warning: m.warning !== 0, inferred_percent: m.inferred_percent };
    const w = this.warning, on = this.zone.warning, begins = on && !w.on;
    if (on) {
      w.received_us = m.t;
      w.off_us = 0;
      if (begins || this.zone.mats >= w.zone.mats) w.zone = this.zone;
    } else if (w.on && !w.off_us) w.off_us = m.t;
    if (begins) {
      w.on = true;
      w.since_us = m.t;
      if (w.first_decided_block === null) w.first_decided_block = block;
      this.notice('alarm', m.t, 'WARNING: the lamp is on');
    }
    this.endWarning(m.t);
  }
  /* It may come and go with each statement: it begins at once, and is over when a second had none. */
  endWarning(us) {
    const w = this.warning;
    if (!w.on || !w.off_us || us - w.off_us < 1e6) return;
    w.on = false;
    this.notice('note', us, 'the warning is over');
  }
  take_zone_coming(m, link) { link.coming = m; }
  take_zone_press(m, link) { link.press = m; }
  /* What a verdict goes with has its block, and is sent before it. An advisory is less than a warning: the lamp stays dark. */
  take_verdict(m, link, block) {
    if (this.verdict && block < this.verdict.block) return;
    const before = this.isAdvised(), of = (part) => (part && part.block16 === m.block16 ? part : null);
    this.verdict = { block, verdict: m.verdict_text, reason: m.reason_text, level: m.level_text, compression: m.reason === 3, coming: of(link.coming), press: of(link.press) };
    if (!this.isAdvised()) return;
    if (!before) { this.advised.since_us = m.t; this.advised.reason = m.reason_text; }
    if (this.advised.told.has(m.reason)) return;
    this.advised.told.add(m.reason); /* once in a landing: it may come and go 20 times a second */
    this.notice('note', m.t, 'advisory: ' + m.reason_text);
  }
  isRecording() { return !this.landing || ['armed', 'landing', 'settling'].includes(this.landing.text); }
  isAdvised() { return this.verdict !== null && this.verdict.verdict === 'advisory' && this.isRecording(); }
  /* The zone that the model expects, if the wheel reaches it before the closed one; otherwise null. */
  expected() {
    const v = this.verdict, z = this.zone, coming = v && !v.compression ? v.coming : null;
    return coming && coming.mats > 0 && coming.wheel_ft !== null && (z.mats === 0 || coming.wheel_ft < z.start_ft - 2) ? { mats: coming.mats, wheel_ft: coming.wheel_ft } : null;
  }
  take_risk(m, link) { link.risk = m; }
  take_risk_item(m) { if (m.index === this.fixed.lamp_limit_item) this.lampLimit = m.value; }
  take_risk_lead(m, link, block) {
    if (link.risk && m.block16 === link.risk.block16 && (!this.risk || block >= this.risk.block)) this.risk = { block, said: link.risk, lead: m };
  }

  take_health(m) { this.health = m; }
  take_fault(m) {
    const text = this.fixed.faults[m.code];
    if (!text || m.count <= (this.faults.get(m.code) || 0)) return;
    this.faults.set(m.code, m.count);
    this.notice('alarm', m.t, 'fault: ' + text + ' (' + m.detail + ', ' + m.count + ' times)');
  }
  take_channel_event(m) {
    const transducers = this.fixed.transducers, number = this.channels[m.index] && this.channels[m.index].number;
    const name = m.index < transducers ? 'transducer ' + (number || m.index + 1) : m.index < this.channels.length ? 'gage ' + (number || m.index - transducers + 1) : 'channel ' + m.index;
    const text = name + ': ' + (m.validity ? m.validity_text : 'valid again'), last = this.notices[this.notices.length - 1];
    if (!last || last.text !== text) this.notice(m.validity ? 'alarm' : 'say', m.t, text); /* the other link says it too */
  }
  take_can_alarm(m) {
    if (this.alarm && m.outages < this.alarm.outages) return; /* had waited in the controller */
    const before = this.alarm ? this.alarm.state : 0;
    this.alarm = m;
    if (m.state !== before) this.notice(m.state ? 'alarm' : 'say', m.t, 'CAN state reported by the board: ' + this.fixed.can_states[m.state]);
  }
  take_box_state(m) { this.box = m; }
  take_upkeep(m) { this.upkeep = m; }

  /* ---- state of the host ---- */
  takeHost(host) {
    host.links.forEach((link, i) => {
      const before = this.host.links[i];
      if (before && link.lost > before.lost) this.notice('alarm', host.now_us, link.name + ': ' + (link.lost - before.lost) + ' frames lost in transit');
      if (before && link.dropped > before.dropped) this.notice('alarm', host.now_us, link.name + ': the board could not send ' + (link.dropped - before.dropped) + ' frames');
    });
    this.host = host;
  }

  /* ---- what is shown ---- */
  configuration() {
    const transducers = this.fixed.transducers, hello = this.hello;
    return {
      ...this.fixed, limits: this.limits,
      board: {
        uid: this.uid.some((word) => word) ? this.uid.map((word) => word.toString(16).toUpperCase().padStart(8, '0')).join('') : '',
        emulated: this.uid[1] >>> 8 === this.fixed.emulated_lot, firmware: hello ? hello.firmware : '', commit: this.commit || '', other_layout: hello !== null && hello.layout !== this.fixed.layout,
      },
      channels: this.channels.map((c, i) => ({
        name: (i < transducers ? 'D' : 'T') + (c.number || (i < transducers ? i + 1 : i - transducers + 1)),
        fitted: !c.known || c.kind !== 0, station_ft: c.known ? c.station_ft : null, band: c.band,
      })),
      runway: {
        switches: [...this.switches.values()].sort((a, b) => a.position - b.position),
        segments: [...this.segments.entries()].sort((a, b) => a[0] - b[0]).map((entry) => entry[1]), touchdown_ft: this.touchdown_ft,
      },
    };
  }
  gear() {
    const m = this.motion, t = this.touchdown, s = this.stop, z = this.zone;
    const at_ft = z.wheel_ft !== null && z.block >= (m ? m.block : -1) ? z.wheel_ft : m ? m.position_ft : null;
    if (at_ft !== null && !(at_ft < this.reached_ft)) this.reached_ft = at_ft; /* the gear does not roll back: the newer of two estimates may */
    return {
      station_ft: s ? s.station_ft : this.reached_ft,
      speed_ft_s: m ? m.speed_ft_s : null, speed_error_ft_s: m ? m.speed_error_ft_s : null,
      deceleration_ft_s2: m ? m.deceleration_ft_s2 : null, deceleration_error_ft_s2: m ? m.deceleration_error_ft_s2 : null, edges: this.edges,
      final: t || s ? {
        touchdown_ft_s: t ? t.speed_ft_s : null, touchdown_error_ft_s: t ? t.speed_error_ft_s : null, deceleration_ft_s2: t ? t.deceleration_ft_s2 : null,
        stop_ft: s ? s.station_ft : null, after_s: s ? s.after_touchdown_s : null,
      } : null,
    };
  }
  shownVerdict() {
    const v = this.verdict;
    if (!v) return null;
    const coming = v.compression ? null : v.coming, press = v.compression ? v.press : null;
    return {
      says: v.verdict, reason: v.reason, advisory: this.isAdvised(), since_us: this.advised.since_us, since_reason: this.advised.reason, model: v.level,
      coming_mats: coming ? coming.mats : null, coming_wheel_ft: coming ? coming.wheel_ft : null,
      compression_lb: press ? press.compression_lb : null, critical_lb: press ? press.critical_lb : null,
    };
  }
  shownRisk() {
    const r = this.risk;
    return r && {
      risk: r.said.risk, lamp_limit: this.lampLimit, reason: r.said.reason_text, of_plan: (r.said.basis & this.fixed.risk_of_plan) !== 0,
      of_chart: (r.said.basis & this.fixed.risk_of_chart) !== 0, start_s: r.lead.start_s, failure_s: r.lead.failure_s, failure_ft: r.lead.failure_ft,
    };
  }
  shownHealth() {
    const h = this.health, box = this.box, faults = [];
    this.fixed.faults.forEach((text, code) => { if (h && h.faults / 2 ** code % 2 >= 1) faults.push({ code, text, count: this.faults.get(code) || 0 }); });
    const health = {
      faults, known: h !== null, blocks_lost: h ? h.blocks_lost : 0, restarts: this.restarts,
      can: this.alarm ? this.fixed.can_states[this.alarm.state] : '', can_good: !this.alarm || this.alarm.state === 0,
      black_box: box ? box.state_text : '', black_box_good: !box || this.fixed.box_good.includes(box.state), black_box_wait_s: box ? box.wait_s : null,
      black_box_records: box ? box.records : 0, stack_used: this.upkeep ? this.upkeep.stack_used : 0, stack_size: this.upkeep ? this.upkeep.stack_size : 0,
    };
    for (const q of this.fixed.quantities) {
      const known = this.quantities[q.key] || { value: null, error: null };
      health[q.key] = known.value;
      health[q.error_key] = known.error;
    }
    return health;
  }
  state() {
    const host = this.host;
    this.endWarning(host.now_us);
    return {
      now_us: host.now_us, heard_us: Math.max(0, ...host.links.map((link) => link.heard_us), this.links[0].heard, this.links[1].heard), block: host.block,
      state: this.landing ? this.landing.text : 'unknown', landing: this.landing ? this.landing.landing : 0, source: host.source, late: host.late,
      warning: this.warning, outcome: this.outcome, verdict: this.shownVerdict(), risk: this.shownRisk(), zone: this.zone, expected: this.expected(), gear: this.gear(), opened: [...this.opened],
      readings: host.readings, bands: [...this.bands.values()], links: host.links, health: this.shownHealth(), notices: this.notices, uncalibrated: host.uncalibrated,
    };
  }
}
