"""Strikes and reads the calls that a daemon makes on its files: the test's end of file_seam.c."""
import mmap
import os
import struct
import time
import typing

CHECKPOINT, ORDERS, PARAMETERS, HISTORY = 1, 2, 4, 8
OPENS, WRITES, SYNCS, RENAMES, REMOVES, RESIZES, CHANGES_MODE = 1, 2, 4, 8, 16, 32, 64
ALL = 127
KILLS_BEFORE, KILLS_WITHIN, KILLS_AFTER, FAILS, FILLS = 1, 2, 3, 4, 5
FOR_EVER = 2 ** 63
NUMBERS = ("matched", "from", "until", "files", "calls", "action", "error", "struck")
TOLD = struct.Struct("=6q")


class Call(typing.NamedTuple):
    """One that changed something: a path or a descriptor, `number` being flags, offset or size."""
    kind: int
    file: int
    number: int
    path: str
    other: str
    data: bytes


class Seam:
    """Of one folder; `beside` is where page and record lie."""
    library = None  # set by the command line

    def __init__(self, folder, beside):
        self.folder, self.page_path, self.record_path = folder, beside / "seam.page", beside / "seam.record"
        self.page_path.write_bytes(bytes(8 * len(NUMBERS)))
        with open(self.page_path, "r+b") as file:
            self.page = mmap.mmap(file.fileno(), 8 * len(NUMBERS))
        self.forget()

    def environment(self):
        return {**os.environ, "LD_PRELOAD": str(self.library), "SEAM_FOLDER": str(self.folder),
                "SEAM_PAGE": str(self.page_path), "SEAM_RECORD": str(self.record_path)}

    def set(self, name, value):
        struct.pack_into("=Q", self.page, 8 * NUMBERS.index(name), value)

    def get(self, name):
        return struct.unpack_from("=Q", self.page, 8 * NUMBERS.index(name))[0]

    def strike(self, action, files, first, last=None, calls=ALL, error=0):
        """The calls on `files` from the first-th to the last-th from now on; counting begins anew."""
        self.heal()
        for name, value in (("calls", calls), ("error", error), ("from", first), ("until", last or first), ("matched", 0),
                            ("struck", 0), ("action", action), ("files", files)):
            self.set(name, value)

    def heal(self):
        self.set("files", 0)
        self.set("action", 0)

    def count(self, files):
        """From now on, without doing anything."""
        self.strike(0, files, FOR_EVER)

    def forget(self):
        self.record_path.write_bytes(b"")

    def record(self):
        """All calls that succeeded, in their order; the last one may be cut by a kill."""
        data, at = self.record_path.read_bytes(), 0
        while at + TOLD.size <= len(data):
            kind, file, number, path, other, size = TOLD.unpack_from(data, at)
            at += TOLD.size
            parts = data[at:at + path], data[at + path:at + path + other], data[at + path + other:at + path + other + size]
            at += path + other + size
            if at <= len(data):
                yield Call(kind, file, number, parts[0].decode(), parts[1].decode(), parts[2])

    def wait_until_struck(self, seconds=60.0):
        end = time.monotonic() + seconds
        while self.get("struck") == 0:
            if time.monotonic() > end:
                raise AssertionError(f"no call was struck within {seconds} s")
            time.sleep(0.002)


def written_whole(calls, path):
    """What `path` may hold behind these calls by write_whole_file(): what its last renaming left there, and what is synced
    beside it and may have got its name without our having been told. None where nobody wrote it."""
    names, bytes_of, newest, next_one = {}, {}, None, None
    for call in calls:
        if call.kind == OPENS and call.path.startswith(f"{path}.") and call.number & os.O_EXCL:
            names[call.file], bytes_of[call.path] = call.path, b""
        elif call.kind == OPENS:
            names.pop(call.file, None)
        elif call.kind == WRITES and call.file in names:
            bytes_of[names[call.file]] += call.data
        elif call.kind == SYNCS and call.file in names:
            next_one = bytes_of[names[call.file]]
        elif call.kind == RENAMES and call.other == str(path):
            newest, next_one = bytes_of[call.path], None
    return newest, next_one
