#!/usr/bin/env python3
"""Reads an MDF 4.10 file by the published layout and checks it block by block. Knows nothing of matrig's writer.

    mdf4_read.py FILE.mf4 blocks         every byte in a block, every link at a block of the right kind, attachments by their MD5
    mdf4_read.py FILE.mf4 readings CSV   each cell is the CSV export's, empty where a value is marked invalid here
    mdf4_read.py FILE.mf4 units SI.mf4   units of both
    mdf4_read.py FILE.mf4 frames LOG     its CAN data frames are the candump export's; the DBC belongs to them
    mdf4_read.py FILE.mf4 foreign LOG    so are extended, remote and error frames, each in the table of its kind
    mdf4_read.py FILE.mf4 dbc DBC        the attached file
    mdf4_read.py FILE.mf4 start LOG      second 0 is a time of day: that of the candump export's first stamp
    mdf4_read.py FILE.mf4 undated        second 0 has none, and the comment says why
"""
import csv
import hashlib
import struct
import sys
import xml.dom.minidom

# Kind: number of links (least), what each may lead to, bytes of fixed data (None: any).
KINDS = {
    "HD": ([["DG"], ["FH"], ["CH"], ["AT"], ["EV"], ["TX", "MD"]], 32),
    "FH": ([["FH"], ["MD"]], 16),
    "DG": ([["DG"], ["CG"], ["DT", "DL", "DZ", "HL"], ["TX", "MD"]], 8),
    "CG": ([["CG"], ["CN"], ["TX"], ["SI"], ["SR"], ["TX", "MD"]], 32),
    "CN": ([["CN"], ["CN", "CA"], ["TX"], ["SI"], ["CC"], ["SD", "DL"], ["TX", "MD"], ["TX", "MD"]], 72),
    "SI": ([["TX"], ["TX"], ["TX", "MD"]], 8),
    "AT": ([["AT"], ["TX"], ["TX"], ["TX", "MD"]], None),
    "TX": ([], None),
    "MD": ([], None),
    "DT": ([], None),
}


def refuse(what):
    sys.exit(f"mdf4_read: {what}")


class Block:
    def __init__(self, file, at):
        mark, kind, length, count = struct.unpack_from("<2s2s4xQQ", file, at)
        self.kind = kind.decode("ascii", "replace")
        if mark != b"##" or self.kind not in KINDS:
            refuse(f"no block at {at}: {file[at:at + 4]!r}")
        if at % 8 or length < 24 + 8 * count or at + length > len(file):
            refuse(f"block {self.kind} at {at}: address, length {length} or {count} links")
        kinds, fixed = KINDS[self.kind]
        if count < len(kinds) or fixed is not None and length != 24 + 8 * count + fixed:
            refuse(f"block {self.kind} at {at}: {count} links, length {length}")
        self.at, self.length = at, length
        self.links = struct.unpack_from(f"<{count}Q", file, at + 24)
        self.data = file[at + 24 + 8 * count:at + length]


class Mdf:
    def __init__(self, path):
        with open(path, "rb") as opened:
            self.file = opened.read()
        name, version, _, number, unfinished, custom = struct.unpack_from("<8s8s8s4xH30xHH", self.file, 0)
        if name != b"MDF     " or version[:4] != b"4.10" or number != 410 or unfinished or custom:
            refuse("no finished MDF 4.10 file")
        self.blocks = {}
        at = 64
        while at < len(self.file):
            block = self.blocks[at] = Block(self.file, at)
            end = at + block.length
            at = (end + 7) // 8 * 8
            if any(self.file[end:at]):
                refuse(f"bytes between blocks at {end}")
        if at != len(self.file) or self.blocks[64].kind != "HD":
            refuse("it does not end with a block, or does not begin with HD")
        self.check_links()

    def check_links(self):
        reached, waiting = set(), [64]
        while waiting:
            block = self.blocks[waiting.pop()]
            if block.at in reached:
                continue
            reached.add(block.at)
            kinds = KINDS[block.kind][0]
            for i, to in enumerate(block.links):
                if not to:
                    continue
                allowed = kinds[i] if i < len(kinds) else ["AT"]  # a channel's references
                if to not in self.blocks or self.blocks[to].kind not in allowed:
                    refuse(f"link {i} of {block.kind} at {block.at} leads to {to}")
                waiting.append(to)
        if reached != set(self.blocks):
            refuse(f"blocks that nothing leads to: {sorted(set(self.blocks) - reached)}")

    def text(self, at):
        if not at:
            return ""
        block = self.blocks[at]
        text = block.data.split(b"\0")[0].decode("utf-8")
        if block.kind == "TX":
            return text
        root = xml.dom.minidom.parseString(text).documentElement
        return "".join(n.data for n in root.getElementsByTagName("TX")[0].childNodes)

    def chain(self, at, link=0):
        while at:
            yield self.blocks[at]
            at = self.blocks[at].links[link]

    def groups(self):
        for group in self.chain(self.blocks[64].links[0]):
            if group.data[0]:
                refuse("record ids: this reader has none")
            for channels in self.chain(group.links[1]):
                yield Group(self, group, channels)

    def group(self, name):
        for group in self.groups():
            if group.name == name:
                return group
        refuse(f"no table {name}")

    def attachments(self):
        for block in self.chain(self.blocks[64].links[3]):
            flags, _, md5, size, embedded = struct.unpack_from("<HH4x16sQQ", block.data)
            content = block.data[40:40 + embedded]
            if flags != 5 or size != embedded or len(content) != size or hashlib.md5(content).digest() != md5:
                refuse(f"attachment {self.text(block.links[1])}: flags {flags}, size or MD5")
            yield self.text(block.links[1]), content


class Group:
    FORMATS = {(0, 8): "B", (0, 16): "H", (0, 32): "I", (0, 64): "Q", (2, 8): "b", (2, 16): "h", (2, 32): "i", (2, 64): "q",
               (4, 32): "f", (4, 64): "d"}

    def __init__(self, mdf, group, block):
        self.mdf = mdf
        self.name = mdf.text(block.links[2])
        record, self.cycles, self.flags, _, self.row, self.invalid = struct.unpack("<QQHH4xII", block.data)
        rows = mdf.blocks[group.links[2]].data if group.links[2] else b""
        if record or len(rows) != self.cycles * (self.row + self.invalid):
            refuse(f"table {self.name}: {self.cycles} rows in {len(rows)} bytes")
        self.rows = rows
        self.channels = []
        self.read_channels(block.links[1])
        self.source = mdf.blocks[block.links[3]] if block.links[3] else None

    def read_channels(self, first):
        for block in self.mdf.chain(first):
            kind, sync, data_type, bit, offset, bits, flags, invalid = struct.unpack_from("<BBBBIIII", block.data)
            if bit or offset + bits // 8 > self.row or bits % 8:
                refuse(f"channel {self.mdf.text(block.links[2])} lies outside its row")
            self.channels.append({"name": self.mdf.text(block.links[2]), "unit": self.mdf.text(block.links[6]), "offset": offset,
                                  "bits": bits, "type": data_type, "master": kind == 2 and sync == 1,
                                  "invalid": invalid if flags & 2 else None, "flags": flags, "references": block.links[8:]})
            if block.links[1]:
                self.read_channels(block.links[1])

    def value(self, n, channel):
        at = n * (self.row + self.invalid)
        bit = channel["invalid"]
        if bit is not None and self.rows[at + self.row + bit // 8] >> bit % 8 & 1:
            return None
        at += channel["offset"]
        if channel["type"] == 10:
            return self.rows[at:at + channel["bits"] // 8]
        return struct.unpack_from("<" + self.FORMATS[channel["type"], channel["bits"]], self.rows, at)[0]

    def find(self, name):
        return next(c for c in self.channels if c["name"] == name)


def check_blocks(mdf):
    assert len(list(mdf.groups())) == 2 and [name for name, _ in mdf.attachments()] == ["matrig.dbc"]


def check_readings(mdf, path):
    """Displacements to the CSV's 5 digits, tensions to 3; times grow by a millisecond."""
    group = mdf.group("readings")
    names = {"t_s": "since_touchdown", "gear_ft": "gear_station", "speed_ft_s": "gear_speed"}
    names |= {f"d{i}_in": f"displacement_{i}" for i in range(1, 9)} | {f"t{i}_lb": f"tension_{i}" for i in range(1, 15)}
    with open(path) as table:
        ours = list(csv.DictReader(line for line in table if not line.startswith("#")))
    assert len(ours) == group.cycles > 7000, (len(ours), group.cycles)
    filled = empty = 0
    for name, column in names.items():
        channel = group.find(column)
        for n, row in enumerate(ours):
            value, cell = group.value(n, channel), row[name]
            assert (cell == "") == (value is None), (name, n, cell, value)
            filled, empty = filled + (cell != ""), empty + (cell == "")
            assert cell == "" or abs(float(cell) - value) <= 0.5001 * 10 ** -len(cell.split(".")[1]) + 1e-6 * abs(float(cell)), (name, cell, value)
    time = [c for c in group.channels if c["master"]]
    assert len(time) == 1 and {round(group.value(n, time[0]) - group.value(n - 1, time[0]), 9) for n in range(1, group.cycles)} == {0.001}
    print(filled, "cells equal,", empty, "empty in both")
    assert filled > 100000 and empty > 0


def check_units(mdf, path):
    ours, theirs = ({c["name"]: c["unit"] for c in m.group("readings").channels} for m in (mdf, Mdf(path)))
    print(ours, theirs)
    assert ours.items() >= {"time": "s", "displacement_8": "in", "tension_14": "lb", "gear_speed": "ft/s"}.items()
    assert theirs.items() >= {"time": "s", "displacement_8": "mm", "tension_14": "N"}.items()


# As SocketCAN has them in error frames (linux/can/error.h), and the ErrorType that asammdf's table has: 1 bit, 2 form, 3 stuffing, 4 CRC,
# 5 acknowledgement.
ERROR_TYPES = {"20000040#": 0, "20000080#0000000000000000": 0, "20000020#": 5, "20000088#0000020000000000": 2, "20000008#0000040A00000000": 3,
               "20000008#0000000800000000": 4, "20000008#0000100000000000": 1}


def frames(mdf, kind="CAN_DataFrame"):
    """(second, text as candump has it) of each; of an error its type."""
    group = mdf.group(kind)
    frame = group.find(kind)
    names = [mdf.text(mdf.blocks[a].links[1]) for a in frame["references"]]
    attached = ["matrig.dbc"] if kind == "CAN_DataFrame" else []
    if group.flags != 6 or group.source.data[:2] != b"\x02\x02" or not frame["flags"] & 0x400 or names != attached:
        refuse(f"not logging of a CAN bus with its DBC: {group.flags} {group.source.data[:2]} {frame['flags']} {names}")
    part = {c["name"][len(kind) + 1:]: c for c in group.channels if c["name"].startswith(kind + ".")}
    expected = {"CAN_DataFrame": {"BusChannel", "ID", "IDE", "DLC", "DataLength", "DataBytes"}, "CAN_RemoteFrame": {"BusChannel", "ID", "IDE", "DLC"},
                "CAN_ErrorFrame": {"BusChannel", "ErrorType"}}
    assert set(part) == expected[kind], part
    time = group.find("Timestamp")
    for n in range(group.cycles):
        got = {name: group.value(n, channel) for name, channel in part.items()}
        if got["BusChannel"] != 1 or got.get("DLC") != got.get("DataLength", got.get("DLC")):
            refuse(f"frame {n}: {got}")
        if kind == "CAN_ErrorFrame":
            yield group.value(n, time), got["ErrorType"]
            continue
        identifier = f"{got['ID']:08X}" if got["IDE"] else f"{got['ID']:03X}"
        content = got["DataBytes"][:got["DataLength"]].hex().upper() if "DataBytes" in got else f"R{got['DLC']}"
        yield group.value(n, time), f"{identifier}#{content}"


def logged(path):
    for line in open(path):
        time, _, frame = line.split()
        yield float(time[1:-1]), frame


def check_frames(mdf, path):
    """Frame by frame; times as candump has them but for where they begin."""
    ours, theirs = list(logged(path)), list(frames(mdf))
    assert len(ours) > 20000 and [f for _, f in ours] == [f for _, f in theirs]
    off = [a - b for (a, _), (b, _) in zip(ours, theirs)]
    print(f"worst time difference {max(off) - min(off):.6f} s")
    assert max(off) - min(off) < 2.1e-6


def check_foreign(mdf, path):
    theirs = [frame for _, frame in logged(path)]
    errors = [f for f in theirs if len(f.split("#")[0]) == 8 and int(f.split("#")[0], 16) & 0x20000000]
    remote = [f for f in theirs if "#R" in f]
    data = [f for f in theirs if f not in errors and f not in remote]
    print(sorted(set(f for f in data if len(f.split("#")[0]) == 8)), remote, errors)
    assert len(remote) == 2 and len(set(errors)) == len(ERROR_TYPES) and "00000123#EE" in data and "18FF50E5#A1A2A3A4A5A6A7A8" in data
    assert data == [f for _, f in frames(mdf)] and remote == [f for _, f in frames(mdf, "CAN_RemoteFrame")]
    assert [ERROR_TYPES[f] for f in errors] == [t for _, t in frames(mdf, "CAN_ErrorFrame")]


def check_dbc(mdf, path):
    assert dict(mdf.attachments())["matrig.dbc"] == open(path, "rb").read()


def begins(mdf):
    return struct.unpack_from("<Q", mdf.blocks[64].data)[0]


def check_start(mdf, path):
    at, first = next(frames(mdf))
    stamp = next(t for t, frame in logged(path) if frame == first)
    print(begins(mdf), at, stamp)
    assert begins(mdf) > 1e18 and abs(begins(mdf) / 1e9 + at - stamp) < 1e-5


def check_undated(mdf):
    assert begins(mdf) == 0 and "time of day unknown: " in mdf.text(mdf.blocks[64].links[5])


globals()["check_" + sys.argv[2]](Mdf(sys.argv[1]), *sys.argv[3:])
