#!/usr/bin/env python3
"""Whether every #include runs down the order of rooms.toml.

  check_rooms.py [--root FOLDER] [--generated FOLDER]   fails, and names each include that runs back

A source belongs to the room that names it, or else the folder it stands in. It may include its own room and rooms that
stand before it in rooms.toml, but none that its room lists under `never`. Generated headers (--generated: the folder that
they are made in, by default build/generated) belong to the room of their path, and their own includes count too.
Includes in angle brackets are libraries and do not count.
"""
import re
import tomllib

import checker

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"')


class Rooms:
    def __init__(self, path):
        with open(path, "rb") as file:
            rooms = tomllib.load(file)["room"]
        self.order = {}
        self.never = {}
        for place, room in enumerate(rooms):
            for key in ("path", "why"):
                if not room.get(key):
                    raise checker.CannotCheck(f"{path}: room {place + 1} has no {key}")
            if room["path"] in self.order:
                raise checker.CannotCheck(f"{path}: {room['path']} stands twice")
            self.order[room["path"]] = place
            self.never[room["path"]] = room.get("never", [])
        self.folders = checker.room_folders(path.parent)

    def of(self, source):
        """The room of a source's path; None: it has none."""
        folder = source.rpartition("/")[0]
        return next((room for room in (source, folder) if room in self.order), None)

    def complaint(self, source, included):
        """What is wrong with the include, or None."""
        at, to = self.of(source), self.of(included)
        if to is None:
            return f"{included} belongs to no room of rooms.toml"
        barred = next((name for name in self.never[at] if to == name or to.startswith(name + "/")), None)
        if barred:
            return f"{at} may never include {barred}, and {included} is of it"
        if self.order[to] > self.order[at]:
            return f"runs back: {to} stands after {at} in rooms.toml"
        return None


def complaints(root, generated):
    """Lines "file:line: what is wrong" and how many includes were read."""
    rooms = Rooms(root / "rooms.toml")
    found, count = [], 0
    for base in (root, generated):
        for path in checker.sources_of(base, rooms.folders) if base.is_dir() else ():
            source = path.relative_to(base).as_posix()
            if rooms.of(source) is None:
                found.append(f"{source}: its folder is no room; declare it in rooms.toml, with the reason")
                continue
            for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
                include = INCLUDE.match(line)
                if not include:
                    continue
                count += 1
                name = include.group(1)
                if "/" not in name and (path.parent / name).is_file():  # beside it: sources that are copied to other machines
                    name = (path.parent / name).relative_to(base).as_posix()
                complaint = rooms.complaint(source, name)
                if complaint:
                    found.append(f"{source}:{number}: {complaint}")
    return found, count


if __name__ == "__main__":
    checker.main("check_rooms", __doc__, complaints, "{count} includes, none runs back")
