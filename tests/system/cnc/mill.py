"""The simulated mill under LinuxCNC, started in its root, and what it recorded."""
import json
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
SHIPPED = HERE.parents[2] / "host_tools" / "linuxcnc"
sys.path.insert(0, str(HERE.parent))
from ports import wait_until  # noqa: E402: beside another folder's sources

DISPLAY_PORT = 15100
WINDOW = 50  # servo periods of 1 ms over which a speed is taken


def settings():
    """The section that is shipped, as numbers where they are."""
    pairs = re.findall(r"^(\w+) = (\S+)$", (SHIPPED / "spindle_twin.inc").read_text(encoding="utf-8"), re.MULTILINE)
    return {key: value if value.isalpha() else float(value) for key, value in pairs}


class Mill:
    """One run of LinuxCNC. `changed`: settings that differ from the shipped ones."""

    def __init__(self, root, work, **changed):
        self.folder = work / "mill"
        for old in self.folder.iterdir():
            old.unlink()
        for source in (*SHIPPED.glob("spindle_twin*"), *HERE.glob("mill.[ih]*"), HERE / "record.hal", HERE / "display"):
            shutil.copy(source, self.folder)
        (self.folder / "tool.tbl").touch()
        self.change(changed)
        subprocess.run(["chroot", root, "chown", "-R", "machinist", "/mill"], check=True)
        self.log = open(work / "linuxcnc.log", "a", encoding="utf-8")
        self.process = subprocess.Popen(
            ["chroot", "--userspec=machinist", root, "/usr/bin/env", "-i", "HOME=/home/machinist", "USER=machinist",
             "PATH=/usr/bin:/bin", "LANG=C.UTF-8", "/bin/sh", "-c", "cd /mill && exec linuxcnc -r mill.ini"],
            stdin=subprocess.DEVNULL, stdout=self.log, stderr=self.log)
        self.connection = wait_until(self.connect, "LinuxCNC's display (see linuxcnc.log)")
        self.lines = self.connection.makefile("rw")
        self.position = 0
        self.number = 0

    def change(self, changed):
        path = self.folder / "spindle_twin.inc"
        text = path.read_text(encoding="utf-8")
        for key, value in changed.items():
            text, count = re.subn(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.MULTILINE)
            assert count == 1, key
        path.write_text(text, encoding="utf-8")

    def connect(self):
        if self.process.poll() is not None:
            raise AssertionError("LinuxCNC does not start, see linuxcnc.log")
        try:
            return socket.create_connection(("127.0.0.1", DISPLAY_PORT))
        except OSError:
            return None

    def order(self, *order):
        self.lines.write(json.dumps(order) + "\n")
        self.lines.flush()
        answer = json.loads(self.lines.readline())
        if isinstance(answer, dict):
            raise AssertionError(answer["error"])
        return answer

    def get(self, *names):
        values = self.order("get", *names)
        return values[0] if len(names) == 1 else values

    def halcmd(self, line):
        return self.order("halcmd", *line.split())

    def z_um(self):
        return 1000.0 * self.get("joint.2.motor-pos-cmd")

    def begin_step(self):
        """From here on the record is of one step, until end_step()."""
        self.number += 1
        self.halcmd(f"sets step {self.number}")

    def end_step(self):
        """The record since begin_step(): per servo period z in um, offset in um, valid."""
        number = self.number
        self.halcmd("sets step 0")
        rows = []

        def is_whole():
            with open(self.folder / "record.txt", encoding="ascii") as record:
                record.seek(self.position)
                while (line := record.readline()).endswith("\n"):
                    self.position = record.tell()
                    fields = line.split()
                    if len(fields) != 4:  # "overrun": the recorder was not asked in time
                        continue
                    if int(fields[0]) == number:
                        rows.append((1000.0 * float(fields[1]), float(fields[2]), fields[3] != "0"))
                    elif rows:
                        return True
            return False

        wait_until(is_whole, "the record of the step")
        return rows

    def close(self):
        try:
            self.lines.write('["end"]\n')
            self.lines.flush()
            self.process.wait(30)
        finally:
            self.process.kill()
            self.process.wait()
            self.connection.close()
            self.log.close()


def fastest_um_per_s(rows):
    """Of the axis, over windows of WINDOW servo periods."""
    z = [row[0] for row in rows]
    return max((abs(after - before) for before, after in zip(z, z[WINDOW:])), default=0.0) / (1e-3 * WINDOW)
