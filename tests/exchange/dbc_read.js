// Decodes a candump log by a DBC file with a parser that is not ours (candied, npm) and holds it against a table of matrig export.
// usage: dbc_read.js NODE_MODULES DBC LOG CSV [BASE]: prints what was compared; exit 1 when anything differs. BASE: of the board on its bus.
'use strict';
const fs = require('fs');
const path = require('path');
const [modules, dbcPath, logPath, csvPath, base] = process.argv.slice(2);
const {Dbc, Can} = require(path.resolve(modules, 'candied'));

const dbc = new Dbc();
const data = dbc.load(fs.readFileSync(dbcPath, 'latin1'), true); // a line that it does not understand ends this
const can = new Can();
can.database = data;

const lines = fs.readFileSync(csvPath, 'latin1').split('\n').filter((line) => line && !line.startsWith('#'));
const names = lines[0].split(',');
const rows = new Map(lines.slice(1).map((line) => line.split(',')).map((cells) => [Number(cells[1]), cells]));
const blocks = [...rows.keys()];
const first = Math.min(...blocks), last = Math.max(...blocks);

// The block whose low 16 bits are given, near the one before.
let newest = first;
function unwrap(block16) {
    let step = (block16 - newest) & 0xffff;
    if (step >= 0x8000) step -= 0x10000;
    newest += step;
    return newest;
}

let compared = 0, wrong = 0, missing = 0, frames = 0;
const offset = new Map(); // displacement in the table counts from the baseline: the same for all of a channel
function compare(column, cell, value, empty) {
    if (empty || cell === '') {
        missing++;
        wrong += empty !== (cell === '');
        return;
    }
    const moves = column.startsWith('d');
    if (moves && !offset.has(column)) offset.set(column, value - Number(cell));
    const apart = Math.abs(value - (moves ? offset.get(column) : 0) - Number(cell));
    compared++;
    if (apart > (moves ? 1.01e-5 : 0.501e-3)) wrong++;
}

for (const line of fs.readFileSync(logPath, 'latin1').split('\n')) {
    const found = /^\(\d+\.\d+\) \S+ ([0-9A-F]{3})#((?:[0-9A-F]{2})*)$/.exec(line);
    const message = found && (parseInt(found[1], 16) - Number(base || 0)).toString(16);
    if (!found || !/^(10[0-2]|11[0-4])$/.test(message)) continue;
    const frame = can.createFrame(parseInt(found[1], 16), found[2].match(/../g).map((byte) => parseInt(byte, 16)));
    const signals = can.decode(frame).boundSignals;
    const block = unwrap(signals.get('block16').value);
    const age = message.startsWith('10') ? 2 : 4;
    frames++;
    for (const [name, signal] of signals) {
        if (!/^[dt]\d+_(in|lb)$/.test(name)) continue;
        for (let b = block - age + 1; b <= block; b++) {
            const cells = rows.get(b);
            if (cells) compare(name, cells[names.indexOf(name)], signal.value, signal.rawValue === -32768);
        }
    }
}
const cyclic = [...data.messages.values()].filter((m) => m.attributes.get('GenMsgCycleTime'));
console.log(`${data.messages.size} messages, ${frames} frames, ${compared} values compared, ${missing} missing, ${wrong} wrong, ` +
    `${cyclic.length} cycle times`);
for (const m of cyclic) console.log(`cycle ${m.id.toString(16).toUpperCase().padStart(3, '0')} ${m.attributes.get('GenMsgCycleTime').value}`);
console.log(`state ${[...data.messages.get('landing').signals.get('state').valueTable.values()].join(' ')}`);
process.exit(wrong || compared === 0 || last <= first ? 1 : 0);
