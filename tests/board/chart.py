"""Chart and plan as commands of a run, for a board that is to be told one: chart.py RUN LANDINGS SPEED PROFILE

    chart.py tests/runs/landing5.run 0 35.5 0:7.0,1.5:7.0,1.7:8.5 >charted.run

The run again with the commands before its first `arm`, 2 ms apart; nine rows from 3 ft/s2 on, of odds that rise with the braking.
"""
import struct
import sys
import zlib

ROWS, KNOTS, FROM_S = 9, 12, 0.4
NAN = struct.unpack('<f', struct.pack('<I', 0x7fc00000))[0]


def bits(value):
    return struct.unpack('<i', struct.pack('<f', value))[0]


run, landings, speed, profile = sys.argv[1:]
knots = [tuple(map(float, knot.split(':'))) for knot in profile.split(',')]
items = [float(landings), float(speed)]
items += [3.0 + 1.5 * row for row in range(ROWS)]  # ft/s2
items += [-3.0 + 0.6 * row for row in range(ROWS)]  # log odds of a zone
items += [50.0 + 4.0 * row for row in range(ROWS)]  # where, ft
items += [t for t, _ in knots] + [NAN] * (KNOTS - len(knots))
items += [a for _, a in knots] + [NAN] * (KNOTS - len(knots))
words = [(i, v) for i, v in enumerate(items) if v == v]
crc = zlib.crc32(struct.pack('<%df' % len(items), *items))
lines = ['command %.3f serial chart-word %d %d' % (FROM_S + 0.002 * n, i, bits(v)) for n, (i, v) in enumerate(words)]
lines.append('command %.3f serial chart-take %d' % (FROM_S + 0.002 * len(words), crc - (1 << 32 if crc >= 1 << 31 else 0)))
text = ''
for line in open(run):
    if line.startswith('command ') and ' arm ' in line and lines:
        text += '\n'.join(lines) + '\n'
        lines = []
    if not line.startswith('end '):
        text += line
print(text, end='')
print('end %08x' % zlib.crc32(text.encode()))
