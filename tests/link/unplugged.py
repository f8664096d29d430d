"""A serial port on a pseudo-terminal that is unplugged and plugged in again.

    unplugged.py PATH BYTES RATE CUT_S AWAY_S    gives the bytes at RATE bytes/s, goes away CUT_S after it was opened and returns AWAY_S
                                                 later; bytes of the meantime are lost. Prints the bytes before and after.
    unplugged.py ... USB RETURNS OTHER           it is a port of ports.c, with this USB adapter; it returns by the name RETURNS, when the adapter
                                                 OTHER has taken its own
"""
import fcntl
import os
import select
import struct
import sys
import termios
import time
import tty


def plug_in(path, usb=None):
    ours, theirs = os.openpty()
    tty.setraw(ours)
    tty.setraw(theirs)
    os.set_blocking(ours, False)
    if os.path.islink(path):
        os.unlink(path)
    if usb:
        with open(path + '.new', 'w') as port:
            port.write(f'{os.ttyname(theirs)} {usb}')
        os.rename(path + '.new', path)
    else:
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


def unplugged_serial(path, source, rate, cut_s, away_s, usb=None, returns=None, other=None):
    data = open(source, 'rb').read()
    fd, theirs = plug_in(path, usb)
    name = os.ttyname(theirs)
    os.close(theirs)
    theirs = None
    while True:  # somebody opens it
        poll = select.poll()
        poll.register(fd, select.POLLHUP)
        if not poll.poll(0):
            break
        time.sleep(0.01)
    begun, at, before, after = time.monotonic(), 0, None, None
    while at < len(data):
        now = time.monotonic() - begun
        if before is None and now >= cut_s:
            read_out(name)
            os.close(fd)
            os.unlink(path)
            before = at
            if other:
                others = plug_in(path, other)
            time.sleep(away_s)
            fd, theirs = plug_in(returns or path, usb)
            name = os.ttyname(theirs)
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
    read_out(name)
    print('before', before, 'after', after)


unplugged_serial(sys.argv[1], sys.argv[2], float(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5]), *sys.argv[6:])
