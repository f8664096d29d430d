#!/usr/bin/env python3
"""A serial port whose sender has a rate of its own: what a UART at the rate that the other side of the terminal has set makes of it.

    wrongrate.py BYTES LINK BAUD

The bytes go over a line bit by bit at BAUD (8N1, a pause now and then); the receiver looks for the edge of a start bit and samples each bit
in its middle, as a UART does, a low stop bit included, which is a framing error. At the sender's own rate the bytes come as they are. LINK
is a symbolic link to the terminal, there until the other side closes it. LINK.sent has how many bytes
were sent at the rate that the other side has set."""

import array
import fcntl
import os
import select
import struct
import sys
import termios
import time
import tty

TCGETS2 = 0x802C542A
ISPEED_AT = 36  # struct termios2: four flags, c_line, 19 characters, c_ispeed, c_ospeed
SLICE_S = 0.02


def rate_of(terminal):
    state = array.array("B", bytes(64))
    fcntl.ioctl(terminal, TCGETS2, state)
    return struct.unpack_from("=I", state, ISPEED_AT + 4)[0]


class Line:
    """The level over time: for each bit of the sender, from `begin` on."""

    def __init__(self, data):
        bits = []
        for i, byte in enumerate(data):
            bits += [0] + [byte >> k & 1 for k in range(8)] + [1]
            if i % 40 == 39:  # the sender has nothing to say for three characters
                bits += [1] * 30
        self.bits = bits

    def received(self, sender, receiver):
        """Bytes of a UART at `receiver` baud; times are in bits of the sender."""
        step, bits, out, at = sender / receiver, self.bits, bytearray(), 0.0
        while True:
            i = int(at)
            while i < len(bits) and bits[i]:  # idle, until an edge
                i += 1
                at = float(i)
            if at + 10 * step >= len(bits):
                return bytes(out)
            sample = [bits[int(at + (k + 0.5) * step)] for k in range(10)]
            at += 9.5 * step  # it looks for the next start bit from the middle of the stop bit on
            if sample[0]:
                continue  # a glitch
            out.append(sum(bit << k for k, bit in enumerate(sample[1:9])))
            if not sample[9]:  # low where it should be high: it waits until the line is high
                while int(at) < len(bits) and not bits[int(at)]:
                    at = float(int(at) + 1)


def main():
    path, link, baud = sys.argv[1], sys.argv[2], int(sys.argv[3])
    data = open(path, "rb").read()
    line, cache = Line(data[:6000]), {}
    master, slave = os.openpty()
    tty.setraw(slave)
    os.symlink(os.ttyname(slave), link)
    os.set_blocking(master, False)
    seen, begun, sent, rate = False, time.monotonic(), 0, 0
    until = begun + 120
    os.close(slave)
    while time.monotonic() < until:
        events = select.poll()
        events.register(master, 0)
        there = not any(event & select.POLLHUP for _, event in events.poll(0))
        if seen and not there:
            break
        if there:
            seen = True
            if rate_of(master) != rate:
                rate, begun, sent = rate_of(master), time.monotonic(), 0
                if rate not in cache:
                    cache[rate] = data if rate == baud else line.received(baud, rate)
            per_s = min(len(data), 6000) and 5000 * (1 if rate == baud else max(1, len(cache[rate]) / 6000))
            due = int((time.monotonic() - begun) * per_s)
            stream = cache[rate]
            while sent < due and stream:
                at = sent % len(stream)
                try:
                    count = os.write(master, stream[at:min(len(stream), at + due - sent)])
                except BlockingIOError:
                    sent = due
                    break
                sent += count
            with open(link + ".sent.new", "w") as counted:
                counted.write("%d\n" % sent)
            os.replace(link + ".sent.new", link + ".sent")
        time.sleep(SLICE_S)


main()
