# relay.py SERIAL RELAY LOG PATTERN: holds a board's serial socket until the log of its CAN has the pattern, then gives it to whoever
# connects to RELAY.
import os, select, socket, sys, time
for _ in range(100):
    try:
        board = socket.socket(socket.AF_UNIX)
        board.connect(sys.argv[1])
        break
    except OSError:
        time.sleep(0.05)
while not (os.path.exists(sys.argv[3]) and sys.argv[4].encode() in open(sys.argv[3], "rb").read()):
    if select.select([board], [], [], 0.05)[0]:
        board.recv(1 << 20)
door = socket.socket(socket.AF_UNIX)
door.bind(sys.argv[2])
door.listen(1)
host = door.accept()[0]
while True:
    for s in select.select([board, host], [], [])[0]:
        data = s.recv(65536)
        if not data:
            sys.exit(0)
        (host if s is board else board).sendall(data)
