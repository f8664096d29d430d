#!/usr/bin/env python3
"""Reads an MDF 4.10 file by the published layout and checks it block by block. Knows nothing of matrig's writer.

    mdf4_read.py FILE.mf4 blocks            every byte in a block, every link at a block of the right kind; a count of each kind
    mdf4_read.py FILE.mf4 table NAME        the table as CSV, an empty cell where a value is marked invalid
    mdf4_read.py FILE.mf4 units NAME        name,unit of each channel
    mdf4_read.py FILE.mf4 candump EPOCH     its CAN frames as candump -L writes them
    mdf4_read.py FILE.mf4 attachment NAME   an attached file, its MD5 checked
    mdf4_read.py FILE.mf4 start             Unix time of second 0, ns
"""
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


def show_table(group):
    if sum(c["master"] for c in group.channels) != 1:
        refuse("not one master channel")
    print(",".join(c["name"] for c in group.channels))
    last = None
    for n in range(group.cycles):
        row = [group.value(n, c) for c in group.channels]
        master = row[[c["master"] for c in group.channels].index(True)]
        if last is not None and not master > last:
            refuse(f"time does not grow in row {n}")
        last = master
        print(",".join("" if v is None else repr(v) for v in row))


def show_candump(mdf, epoch):
    group = mdf.group("CAN_DataFrame")
    source_type, bus_type = group.source.data[:2]
    frame = group.find("CAN_DataFrame")
    names = [mdf.text(mdf.blocks[a].links[1]) for a in frame["references"]]
    if group.flags != 6 or source_type != 2 or bus_type != 2 or not frame["flags"] & 0x400 or names != ["matrig.dbc"]:
        refuse(f"not logging of a CAN bus with its DBC: {group.flags} {source_type} {bus_type} {frame['flags']} {names}")
    part = {name: group.find("CAN_DataFrame." + name) for name in ("BusChannel", "ID", "IDE", "DLC", "DataLength", "DataBytes")}
    time = group.find("Timestamp")
    for n in range(group.cycles):
        got = {name: group.value(n, channel) for name, channel in part.items()}
        if got["IDE"] or got["BusChannel"] != 1 or got["DLC"] != got["DataLength"]:
            refuse(f"frame {n}: {got}")
        print(f"({epoch + group.value(n, time):.6f}) can0 {got['ID']:03X}#{got['DataBytes'][:got['DataLength']].hex().upper()}")


def main():
    mdf = Mdf(sys.argv[1])
    what = sys.argv[2]
    if what == "blocks":
        for kind in KINDS:
            print(kind, sum(b.kind == kind for b in mdf.blocks.values()))
        for _ in mdf.attachments():
            pass
        for _ in mdf.groups():
            pass
    elif what == "table":
        show_table(mdf.group(sys.argv[3]))
    elif what == "units":
        for channel in mdf.group(sys.argv[3]).channels:
            print(f"{channel['name']},{channel['unit']}")
    elif what == "candump":
        show_candump(mdf, float(sys.argv[3]))
    elif what == "attachment":
        sys.stdout.buffer.write(dict(mdf.attachments())[sys.argv[3]])
    elif what == "start":
        print(struct.unpack_from("<Q", mdf.blocks[64].data)[0])
    else:
        sys.exit(__doc__)


main()
