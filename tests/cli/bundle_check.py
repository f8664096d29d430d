"""What host/bundle/bundle.h says of digests, done again without matrig: every part and the seal of a bundle.
usage: bundle_check.py BUNDLE; prints what differs, exit 1 then.
       bundle_check.py BUNDLE FOLDER KIND...: for each kind a copy FOLDER/KIND with one thing wrong"""
import hashlib, re, sqlite3, struct, sys, zlib

SEAL = b"SHA-256 of this file with these 64 digits as zeros: "


def value(v):
    if v is None:
        return b"N"
    if isinstance(v, int):
        return b"I" + struct.pack("<q", v)
    if isinstance(v, float):
        return b"R" + struct.pack("<d", v)
    letter, data = (b"T", v.encode()) if isinstance(v, str) else (b"B", v)
    return letter + struct.pack("<Q", len(data)) + data


def digest(db, name, kind):
    if kind == "file":
        size, data = db.execute("SELECT sz, data FROM sqlar WHERE name=?", (name,)).fetchone()
        whole = data if len(data) == size else zlib.decompress(data)
        assert len(whole) == size
        return hashlib.sha256(whole).hexdigest(), size
    if kind == "schema":
        rows = db.execute("SELECT name, sql FROM sqlite_schema WHERE sql IS NOT NULL ORDER BY type, name").fetchall()
        text = bytearray()
    else:
        columns = db.execute(f"PRAGMA table_info('{name}')").fetchall()
        text = bytearray(b"".join(value(c[1]) for c in columns))
        key = [c[1] for c in sorted(columns, key=lambda c: c[5]) if c[5]]
        rows = db.execute(f"SELECT * FROM \"{name}\" ORDER BY {','.join(key)}")
    for row in rows:
        text += b"".join(value(v) for v in row)
    return hashlib.sha256(text).hexdigest(), len(text)


def check(path):
    wrong = []
    db = sqlite3.connect(f"file:{path}?mode=ro&immutable=1", uri=True)
    for name, kind, size, sha in db.execute("SELECT name, kind, bytes, sha256 FROM bundle_manifest").fetchall():
        if digest(db, name, kind) != (sha, size):
            wrong.append(name)
    data = open(path, "rb").read()
    sealed, zeros = re.compile(re.escape(SEAL) + b"([0-9a-f]{64})"), SEAL + b"0" * 64
    if [hashlib.sha256(sealed.sub(zeros, data)).hexdigest().encode()] != sealed.findall(data):
        wrong.append("seal")
    print("differ:", wrong)
    return bool(wrong)


def put(db, name, data, mode=0o100644, size=None, sha=None):
    """A file in archive and manifest, as a bundle's maker would put it, whatever it is called."""
    packed = zlib.compress(data)
    db.execute("INSERT OR REPLACE INTO sqlar VALUES(?,?,0,?,?)", (name, mode, len(data) if size is None else size, packed))
    db.execute("INSERT OR REPLACE INTO bundle_manifest VALUES(?,'file',?,'', ?)", (name, len(data), sha or hashlib.sha256(data).hexdigest()))


def damage(path, to, kind):
    data = bytearray(open(path, "rb").read())
    if kind.startswith("flip:"):  # a bit of the byte there
        data[int(kind[5:]) % len(data)] ^= 0x10
    elif kind.startswith("within:"):  # a byte of a blob: table, column
        table, column = kind.split(":")[1:]
        db = sqlite3.connect(f"file:{path}?mode=ro&immutable=1", uri=True)
        blob = max((r[0] for r in db.execute(f"SELECT {column} FROM {table}") if r[0]), key=len)
        place = data.find(blob[:60])  # the first bytes lie together
        assert place > 0
        data[place + 20] ^= 1
    open(to, "wb").write(data)
    if ":" in kind:
        return
    db = sqlite3.connect(to)
    db.execute("PRAGMA synchronous=OFF")
    {
        "parent": lambda: put(db, "../escaped", b"out"),
        "absolute": lambda: put(db, "/tmp/matrig-escaped", b"out"),
        "nul": lambda: put(db, "report.html\0x", b"out"),
        "long": lambda: put(db, "x" * 5000, b"out"),
        "symlink": lambda: put(db, "report.html", b"/etc/passwd", mode=0o120777),
        "claims": lambda: put(db, "report.html", b"x", size=1 << 40),
        "less": lambda: put(db, "report.html", b"x", size=-1),
        "bomb": lambda: put(db, "report.html", bytes(30 << 20), size=30 << 10),
        "huge": lambda: db.execute("UPDATE sqlar SET data=zeroblob(40000000) WHERE name='report.html'"),
        "hash": lambda: db.execute("UPDATE bundle_manifest SET sha256=replace(sha256, '0', '1') WHERE name='can.log'"),
        "extra": lambda: db.execute("INSERT INTO sqlar VALUES('../extra', 33188, 0, 1, x'00')"),
        "row": lambda: db.execute("UPDATE edges SET tick=tick+1 WHERE count=1"),
        "table": lambda: db.execute("CREATE TABLE more(x)"),
        "trigger": lambda: db.execute("DROP TRIGGER observations_stay"),
        "gone": lambda: db.execute("DELETE FROM sqlar WHERE name='firmware.elf'"),
        "many": lambda: [put(db, f"file{i}", b"x") for i in range(1000)],
        "empty": lambda: db.execute("DELETE FROM bundle_manifest"),
        "view": lambda: (db.execute("DROP TABLE edges"), db.execute(
            "CREATE VIEW edges AS WITH RECURSIVE r(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM r) SELECT x FROM r")),
        "computed": lambda: (db.execute("DROP TABLE edges"), db.execute(
            "CREATE TABLE edges(count INTEGER PRIMARY KEY, x TEXT AS (hex(zeroblob(30000000))))"),
            db.executemany("INSERT INTO edges(count) VALUES(?)", [(1,)])),
    }[kind]()
    db.commit()
    db.close()


if len(sys.argv) > 3:
    for kind in sys.argv[3:]:
        damage(sys.argv[1], f"{sys.argv[2]}/{kind}", kind)
else:
    sys.exit(check(sys.argv[1]))
