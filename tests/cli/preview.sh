#!/usr/bin/env bash
# The preview: a summary and a page without a command, also when a cable comes off in the middle of the landing. The links here are
# sockets that bring what a board said, then nothing, and stay open. Two cases run side by side.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT
played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run \
    --for 14 >/dev/null 2>&1

# serve CAN_SECONDS SERIAL_SECONDS NAME: what came within so many seconds of board time, then silence; `matrig log` beside it.
serve() {
    python3 - "$matrig" "$tmp" "$sockets" "$@" >"$tmp/$3.said" 2>&1 <<'EOF'
import os, re, socket, struct, subprocess, sys, threading, time
matrig, tmp, sockets, can_s, serial_s, name = sys.argv[1:]
can_s, serial_s = float(can_s), float(serial_s)
frames, first = b"", None
for line in open(tmp + "/can"):
    at, _, frame = line.split()
    at = float(at.strip("()"))
    first = at if first is None else first
    if at - first > can_s:
        break
    ident, data = frame.split("#")
    data = bytes.fromhex(data)
    frames += struct.pack("<IB3x8s", int(ident, 16), len(data), data)
total = float(line.split()[0].strip("()")) if can_s > 100 else 14.0
raw = open(tmp + "/serial", "rb").read()
raw = raw[: int(len(raw) * min(serial_s / 14.0, 1.0))]
stop = threading.Event()
def run(path, data):
    s = socket.socket(socket.AF_UNIX)
    s.bind(path)
    s.listen(1)
    c, _ = s.accept()
    try:
        c.sendall(data)
        stop.wait(20)  # silent, and open
    except OSError:
        pass
paths = [sockets + "/" + name + kind for kind in (".can", ".serial")]
for path, data in zip(paths, (frames, raw)):
    threading.Thread(target=run, args=(path, data), daemon=True).start()
begun = time.time()
log = subprocess.Popen([matrig, "log", "--listen", "--can", "unix:" + paths[0], "--serial", "unix:" + paths[1], "--db", tmp + "/" + name + ".db",
                        "--page", tmp + "/" + name + ".html"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, bufsize=0)
os.set_blocking(log.stdout.fileno(), False)
said, page = b"", tmp + "/" + name + ".html"
while time.time() - begun < 10:
    said += log.stdout.read() or b""
    if b"  more  " in said and os.path.exists(page) and b"</html>" in open(page, "rb").read():
        break
    time.sleep(0.05)
else:
    print("no preview within 10 s")
print("after %.1f s:" % (time.time() - begun))
print(said.decode())
log.terminate()
log.wait(20)
print('ended after %.1f s' % (time.time() - begun))
stop.set()
EOF
}
serve 20 3.2 half & # the serial line ends in the middle of the landing, CAN goes on to the end
half=$!
serve 3.2 3.2 none & # both
wait $half $!

whole() { # for comparison: both links to their end
    $matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/whole.db" >"$tmp/whole.said"
}
one_cable_off() {
    cat "$tmp/half.said"
    ! grep -Eq 'no preview|no more data' "$tmp/half.said" && grep -q '^RUN 1: landing 5, done' "$tmp/half.said" &&
        [ "$(sqlite3 "$tmp/half.db" "select count(*) from gaps where cause='silence' and link=1")" = 1 ] || return 1
    # the edges come by CAN as well: what the whole record says
    whole && diff <(grep -E '^  touchdown' "$tmp/half.said") <(grep -E '^  touchdown' "$tmp/whole.said")
}
all_silent() {
    cat "$tmp/none.said"
    ! grep -q 'no preview' "$tmp/none.said" && grep -q 'no more data of RUN 1' "$tmp/none.said" &&
        grep -q '^  stop  *not known: the record ends while the gear moves' "$tmp/none.said" && grep -q '^  touchdown  *35\.[45]' "$tmp/none.said"
}
pages() {
    grep -q 'RUN 1: landing 5' "$tmp/half.html" && grep -q 'the record ends while the gear moves' "$tmp/none.html"
}
check "one cable comes off: the landing still ends" one_cable_off
check "all falls silent: what came until then, told once" all_silent
check "the pages are there without a command" pages
finish
