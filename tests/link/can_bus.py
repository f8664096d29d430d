"""can_bus.py BOARD DOOR...: a CAN bus of sockets. It connects to BOARD and listens at each DOOR: whatever the board sends, everybody hears;
whatever another one sends, the board does. It ends with the board."""
import select
import socket
import sys
import time


def connect(path):
    """To a socket that may not be there yet."""
    for _ in range(3000):
        try:
            s = socket.socket(socket.AF_UNIX)
            s.connect(path)
            return s
        except OSError:
            time.sleep(0.02)
    sys.exit("nobody listens: " + path)


def listen(path):
    door = socket.socket(socket.AF_UNIX)
    door.bind(path)
    door.listen(8)
    return door


def main():
    doors = [listen(path) for path in sys.argv[2:]]
    board = connect(sys.argv[1])
    hosts, rest = [], {}
    while True:
        for s in select.select(doors + [board] + hosts, [], [])[0]:
            if s in doors:
                hosts.append(s.accept()[0])
                continue
            try:
                data = rest.pop(s, b"") + s.recv(65536)
            except OSError:
                data = b""
            whole = len(data) // 16 * 16
            if s is board and not data:
                sys.exit(0)
            if not data:
                hosts.remove(s)
                continue
            rest[s] = data[whole:]
            for other in hosts if s is board else [board]:
                try:
                    other.sendall(data[:whole])
                except OSError:
                    pass


if __name__ == "__main__":
    main()
