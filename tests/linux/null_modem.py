# null_modem.py PATH PATH: a null modem of two sockets on which it listens: what one end writes, the other reads. It always reads, and
# keeps what the other end has not taken yet: QEMU's USB serial port writes to its socket with the whole computer standing still until
# all is written, so that two ports of one QEMU which are connected without anything between them can wait for each other for ever.
import os, selectors, socket, sys

KEPT_BYTES = 64 << 20  # far more than a check sends
doors = []
for path in sys.argv[1:3]:
    door = socket.socket(socket.AF_UNIX)
    door.bind(path)
    door.listen(1)
    doors.append(door)
ends = [door.accept()[0] for door in doors]
for end in ends:
    end.setblocking(False)
other = {ends[0]: ends[1], ends[1]: ends[0]}
kept = {end: bytearray() for end in ends}  # to be written to this end
watch = selectors.DefaultSelector()
for end in ends:
    watch.register(end, selectors.EVENT_READ)
while True:
    for key, events in watch.select():
        end = key.fileobj
        if events & selectors.EVENT_READ:
            data = end.recv(65536)
            if not data:
                sys.exit(0)
            kept[other[end]] += data
            if len(kept[other[end]]) > KEPT_BYTES:
                sys.exit("null_modem: one end does not read")
        if events & selectors.EVENT_WRITE:
            del kept[end][: end.send(kept[end])]
    for end in ends:
        watch.modify(end, selectors.EVENT_READ | (selectors.EVENT_WRITE if kept[end] else 0))
