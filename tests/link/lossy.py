"""What serial lost and CAN has, from the two recorded streams alone: framing and messages are read here, not by matrig.

    lossy.py lose  ALL.serial ALL.can LOSSY.serial LOSSY.can   takes stretches away
    lossy.py check ALL.csv LOSSY.serial LOSSY.can LOSSY.csv    each row of the export against the streams that are left
    lossy.py whole ALL.csv BOX.csv                             each row the same again, and B where the black box filled it
    lossy.py cut   ALL.serial BEFORE AFTER                     frames, and blocks of them, that are whole without the bytes in between
"""
import re
import sys

BLOCK = 0x300  # type of a block record on serial
D, T = 8, 14
# identifier: first channel (of d1..d8 t1..t14), how many, blocks that a value is the mean of, digits per unit
CAN = {0x100: (0, 3, 2, 10000), 0x101: (3, 3, 2, 10000), 0x102: (6, 2, 2, 10000), 0x110: (8, 3, 4, 50), 0x111: (11, 3, 4, 50),
       0x112: (14, 3, 4, 50), 0x113: (17, 3, 4, 50), 0x114: (20, 2, 4, 50)}


def serial_lost(block):
    """A second; single blocks; and the cable comes off for the rest."""
    return 3000 <= block < 4000 or (4000 <= block < 5000 and block % 37 == 5) or block >= 7500


def can_lost(block):
    """Where serial has lost them, and where it has not."""
    return 3400 <= block < 3421 or 5500 <= block < 5520


def content(chunk):
    """COBS (Cheshire and Baker)."""
    out, at = bytearray(), 0
    while at < len(chunk):
        code = chunk[at]
        out += chunk[at + 1:at + code]
        at += code
        if code < 255 and at < len(chunk):
            out.append(0)
    return bytes(out)


def serial_frames(path):
    """(bytes, block or None) of each frame."""
    with open(path, 'rb') as f:
        for chunk in f.read().split(b'\0')[:-1]:
            inside = content(chunk)
            is_block = len(inside) > 12 and int.from_bytes(inside[2:4], 'little') == BLOCK
            yield chunk + b'\0', int.from_bytes(inside[4:8], 'little') if is_block else None


def can_lines(path):
    """(line, identifier, data)"""
    with open(path) as f:
        for line in f:
            name, data = line.split()[2].split('#')
            yield line, int(name, 16), bytes.fromhex(data)


def lose(all_serial, all_can, serial, can):
    lost = 0
    with open(serial, 'wb') as out:
        newest = 0
        for frame, block in serial_frames(all_serial):
            newest = block if block is not None else newest
            if serial_lost(newest) and newest:  # with all that comes between blocks
                lost += block is not None
                continue
            out.write(frame)
    with open(can, 'w') as out:
        for line, name, data in can_lines(all_can):
            if name in CAN and can_lost(int.from_bytes(data[6:8], 'little')):
                continue
            out.write(line)
    print('blocks lost', lost)
    assert lost > 2000


def from_can(path):
    """{(block, channel): value or None}, each over the blocks it is the mean of"""
    values = {}
    for _, name, data in can_lines(path):
        if name not in CAN:
            continue
        first, count, blocks, digits = CAN[name]
        newest = int.from_bytes(data[6:8], 'little')
        for k in range(count):
            raw = int.from_bytes(data[2 * k:2 * k + 2], 'little', signed=True)
            for age in range(blocks):
                values[newest - age, first + k] = None if raw == -32768 else raw / digits
    return values


def rows(path):
    with open(path) as f:
        lines = [line.rstrip('\n') for line in f if not re.match('[#t]', line)]
    return {int(line.split(',')[1]): line.split(',') for line in lines}


def baselines(values, edge):
    """Means of what CAN said in the half second before the first edge."""
    out = []
    for c in range(D):
        got = [values[b, c] for b in range(edge - 495, edge - 5) if values.get((b, c)) is not None]
        out.append(sum(got) / len(got))
    return out


def check(all_csv, serial, can, csv):
    known = {block for _, block in serial_frames(serial) if block is not None}
    values = from_can(can)
    whole, got = rows(all_csv), rows(csv)
    last = max((known | {block for block, _ in values}) & whole.keys())  # the landing's block after it came by nobody
    assert got.keys() == {block for block in whole if block <= last}, (len(got), len(whole), min(got), max(got), last)
    edge = min(b for b, r in whole.items() if float(r[0]) > -0.01)
    base = baselines(values, edge)
    count = {'S': 0, 'C': 0, '-': 0}
    offsets = [[] for _ in range(D)]
    for block, row in got.items():
        for c in range(D + T):
            cell, letter = row[4 + c], row[27][c]
            expected = 'S' if block in known else 'C' if (block, c) in values else '-'
            assert letter == expected, (block, c, letter, expected)
            count[letter] += 1
            if letter == 'S':
                assert cell == whole[block][4 + c], (block, c, cell, whole[block][4 + c])
            elif letter == '-':
                assert cell == '' and row[26][c] == 'L', (block, c, row)
            elif c < D:
                offsets[c].append(values[block, c] - float(cell))
            else:
                assert abs(float(cell) - values[block, c]) < 0.0006, (block, c, cell, values[block, c])
    for c, offset in enumerate(offsets):  # all by the same, which is what the channel read before the first edge
        assert max(offset) - min(offset) < 2.5e-5 and abs(offset[0] - base[c]) < 1e-4, (c, min(offset), max(offset), base[c])
    print(count)
    assert count['C'] > 40000 and count['-'] > 400


def whole_again(all_csv, csv):
    whole, got = rows(all_csv), rows(csv)
    count = {'S': 0, 'B': 0}
    for block, row in whole.items():
        assert got[block][4:27] == row[4:27], (block, got[block], row)
        letter = 'B' if serial_lost(block) else 'S'
        assert got[block][27] == letter * (D + T), (block, got[block][27])
        count[letter] += 1
    print(count)
    assert count['B'] > 2000


def cut(serial, before, after):
    at, kept, blocks, lost = 0, 0, 0, 0
    for frame, block in serial_frames(serial):
        whole = at + len(frame) <= int(before) or at >= int(after)
        at += len(frame)
        kept, blocks, lost = kept + whole, blocks + (whole and block is not None), lost + (not whole)
    print(kept, blocks, lost)


{'cut': cut, 'lose': lose, 'check': check, 'whole': whole_again}[sys.argv[1]](*sys.argv[2:])
