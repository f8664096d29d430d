"""Devices on pseudo-terminals, for slcan: and serial: links.

    adapter.py slcan  PATH CANDUMP RATE FIRST_MS FLAGS   a LAWICEL adapter: answers C, S8, Z1, O and F, and plays the log RATE times
                      as fast as it was recorded, with its own time stamps from FIRST_MS on; FLAGS: answers to F in turn ("00,08"), the
                      last one from then on. PATH.open is there once the channel is open. Prints how many frames it sent and how often it said each flag.
    adapter.py serial PATH BYTES RATE CUT_S AWAY_S       a serial port that gives the bytes at RATE bytes/s, is unplugged CUT_S after
                      it was opened and plugged in again AWAY_S later; what comes meanwhile is lost. Prints the bytes before and after.
"""
import fcntl
import os
import select
import struct
import sys
import termios
import time
import tty


def plug_in(path):
    ours, theirs = os.openpty()
    tty.setraw(ours)
    tty.setraw(theirs)
    os.set_blocking(ours, False)
    if os.path.islink(path):
        os.unlink(path)
    os.symlink(os.ttyname(theirs), path)
    return ours, theirs


def write_all(fd, data, heed=lambda: None):
    until = time.monotonic() + 30
    while data:
        if time.monotonic() > until:
            sys.exit('adapter: nobody reads')
        select.select([], [fd], [], 0.5)
        heed()
        try:
            data = data[os.write(fd, data):]
        except BlockingIOError:
            pass


def read_out(path, heed):
    """Waits until the reader has taken all: what is in a terminal's buffer is lost when its other end is closed."""
    fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
    until, empty = time.monotonic() + 30, 0
    while empty < 10 and time.monotonic() < until:
        unread = struct.unpack('i', fcntl.ioctl(fd, termios.FIONREAD, b'\0' * 4))[0]
        empty = empty + 1 if unread == 0 else 0
        heed()
        time.sleep(0.02)
    os.close(fd)


class Slcan:
    def __init__(self, path, log, rate, first_ms, flags):
        self.rate, self.flags = rate, flags.split(',')
        self.open, self.line, self.told = False, b'', {}
        self.answers = b''
        self.lines = []
        for text in open(log):
            stamp, _, frame = text.split()
            name, data = frame.split('#')
            ms = round(float(stamp[1:-1]) * 1000)
            self.lines.append((ms, b't%s%d%s%04X\r' % (name.encode(), len(data) // 2, data.encode(), (first_ms + ms) % 60000)))
        self.path = path
        self.fd, self.theirs = plug_in(path)

    def command(self, line):
        if line[:1] == b'F':
            flag = self.flags.pop(0) if len(self.flags) > 1 else self.flags[0]
            self.told[flag] = self.told.get(flag, 0) + 1
            return b'F' + flag.encode() + b'\r'
        if line[:1] == b'O':
            self.open = True
        return b'\r' if line[:1] in b'CSZO' else b'\a'

    def listen(self, wait_s=0.0):
        if not select.select([self.fd], [], [], wait_s)[0]:
            return
        try:
            self.line += os.read(self.fd, 4096)
        except (BlockingIOError, OSError):
            return
        while b'\r' in self.line:
            line, self.line = self.line.split(b'\r', 1)
            self.answers += self.command(line)

    def answer(self):
        self.listen()
        write_all(self.fd, self.answers)
        self.answers = b''

    def play(self):
        until = time.monotonic() + 20
        while not self.open:
            self.listen(0.05)
            self.answers = write_all(self.fd, self.answers) or b''
            if time.monotonic() > until:
                sys.exit('adapter: nobody opened the channel')
        open(self.path + '.open', 'w').close()
        begun, at = time.monotonic(), 0
        while at < len(self.lines):
            due = self.lines[0][0] + (time.monotonic() - begun) * 1000 * self.rate
            chunk = []
            while at < len(self.lines) and self.lines[at][0] <= due:
                chunk.append(self.lines[at][1])
                at += 1
            self.listen()
            write_all(self.fd, b''.join(chunk) + self.answers)
            self.answers = b''
            time.sleep(0.001)
        read_out(self.path, self.answer)
        print('sent', len(self.lines), *('%s %d' % item for item in sorted(self.told.items())))


def unplugged_serial(path, source, rate, cut_s, away_s):
    data = open(source, 'rb').read()
    fd, theirs = plug_in(path)
    os.close(theirs)
    theirs = None
    while True:  # somebody opens it
        poll = select.poll()
        poll.register(fd, select.POLLHUP)
        if not poll.poll(0):
            break
        time.sleep(0.01)
    begun, at, before = time.monotonic(), 0, None
    while at < len(data):
        now = time.monotonic() - begun
        if before is None and now >= cut_s:
            read_out(path, lambda: None)
            os.close(fd)
            os.unlink(path)
            before = at
            time.sleep(away_s)
            fd, theirs = plug_in(path)
            os.close(theirs)
            opened = time.monotonic() + 20
            while time.monotonic() < opened:
                poll = select.poll()
                poll.register(fd, select.POLLHUP)
                if not poll.poll(0):
                    break
                time.sleep(0.01)
            at = after = min(len(data), int((time.monotonic() - begun) * rate))
            continue
        due = min(len(data), int(now * rate))
        write_all(fd, data[at:due])
        at = due
        time.sleep(0.002)
    read_out(path, lambda: None)
    print('before', before, 'after', after)


if sys.argv[1] == 'slcan':
    Slcan(sys.argv[2], sys.argv[3], float(sys.argv[4]), int(sys.argv[5]), sys.argv[6]).play()
else:
    unplugged_serial(sys.argv[2], sys.argv[3], float(sys.argv[4]), float(sys.argv[5]), float(sys.argv[6]))
