"""A serial port on a pseudo-terminal that is unplugged and plugged in again.

    unplugged.py PATH BYTES RATE CUT_S AWAY_S    gives the bytes at RATE bytes/s, goes away CUT_S after it was opened and returns AWAY_S
                                                 later; bytes of the meantime are lost. Prints the bytes before and after.
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


def write_all(fd, data):
    until = time.monotonic() + 30
    while data:
        if time.monotonic() > until:
            sys.exit('unplugged.py: nobody reads')
        select.select([], [fd], [], 0.5)
        try:
            data = data[os.write(fd, data):]
        except BlockingIOError:
            pass


def read_out(path):
    """Waits until the reader has taken all: what is in a terminal's buffer is lost when its other end is closed."""
    fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
    until, empty = time.monotonic() + 30, 0
    while empty < 10 and time.monotonic() < until:
        unread = struct.unpack('i', fcntl.ioctl(fd, termios.FIONREAD, b'\0' * 4))[0]
        empty = empty + 1 if unread == 0 else 0
        time.sleep(0.02)
    os.close(fd)


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
            read_out(path)
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
    read_out(path)
    print('before', before, 'after', after)


unplugged_serial(sys.argv[1], sys.argv[2], float(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5]))
