#!/usr/bin/env python3
"""A wire for serial:TTY that waits for nobody: a pseudo-terminal whose other end is written to as fast as it takes.

    wire.py LINK    LINK becomes a symbolic link to the terminal. Orders come on standard input, a line each:
                        send FILE TIMES    the file so many times; "sent" is printed when all of it was taken
                        end                LINK goes, and the wire is cut
"""
import os, pty, sys, tty

master, slave = pty.openpty()
tty.setraw(slave)
os.symlink(os.ttyname(slave), sys.argv[1])
for line in sys.stdin:
    words = line.split()
    if words[0] == 'end':
        break
    with open(words[1], 'rb') as f:
        content = f.read()
    for _ in range(int(words[2])):
        rest = memoryview(content)
        while rest:
            rest = rest[os.write(master, rest[:65536]):]
    print('sent', flush=True)
os.unlink(sys.argv[1])  # first: another program's terminal may get the same number at once
os.close(slave)
os.close(master)
