#!/usr/bin/env python3
"""Does the SPDX list in a Debian package say what is in the package?

  tests/packages/check_contents.py PACKAGE.deb

Every file but the list itself with its checksums, every package that it depends on, every other's work that the package's
copyright file names, every name that a relation uses, and licences as SPDX writes them (python3-license-expression).
"""
import hashlib
import json
import pathlib
import re
import subprocess
import sys
import tempfile

from license_expression import get_spdx_licensing

MADE_BY_CMAKE = {"init-system-helpers"}  # what the scripts of the package call; nothing of it is loaded


def said_by(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def check(package):
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["dpkg-deb", "-x", package, folder], check=True)
        root = pathlib.Path(folder)
        lists = list(root.glob("usr/share/doc/*/*.spdx.json"))
        if len(lists) != 1:
            return [f"{len(lists)} lists"], {}
        listed = json.loads(lists[0].read_text())
        sums = {"./" + str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest()
                for path in root.rglob("*") if path.is_file() and path != lists[0]}
        (copyright_file,) = root.glob("usr/share/doc/*/copyright")
        holders = re.findall(r"^Files: (?!\*$).*\nCopyright: (.*)", copyright_file.read_text(), re.MULTILINE)
    told = {entry["fileName"]: entry["checksums"][1]["checksumValue"] for entry in listed["files"]}
    wrong += [f"{name} is not in the list" for name in sums.keys() - told.keys()]
    wrong += [f"{name} is not in the package" for name in told.keys() - sums.keys()]
    wrong += [f"{name} has another checksum" for name in sums.keys() & told.keys() if sums[name] != told[name]]

    identifiers = [entry["SPDXID"] for entry in [listed, *listed["packages"], *listed["files"]]]
    wrong += [f"{name} stands twice" for name in set(identifiers) if identifiers.count(name) > 1]
    relations = listed["relationships"]
    used = {relation[end] for relation in relations for end in ("spdxElementId", "relatedSpdxElement")}
    wrong += [f"a relation to {name}, which is not there" for name in used - set(identifiers)]
    wrong += [f"no relation to {name}" for name in set(identifiers) - used]
    kinds = {relation["relatedSpdxElement"]: relation["relationshipType"] for relation in relations}
    loaded = {entry["name"] for entry in listed["packages"] if kinds.get(entry["SPDXID"]) == "DYNAMIC_LINK"}
    for alternatives in said_by("dpkg-deb", "-f", package, "Depends").strip().split(", "):
        name = alternatives.split()[0]
        is_provided = any(name.startswith(other) for other in loaded)  # libspdlog1.10-fmt9 is a name of libspdlog1.10
        if "|" not in alternatives and name not in MADE_BY_CMAKE and not is_provided:
            wrong.append(f"it depends on {name}, which the list does not have")
    listed_holders = {entry["copyrightText"] for entry in listed["packages"]}
    wrong += [f"work of {name} is inside, which the list does not have" for name in holders if name not in listed_holders]
    for entry in listed["packages"]:
        expression = entry["licenseDeclared"]
        if expression != "NOASSERTION" and get_spdx_licensing().validate(expression).errors:
            wrong.append(f"{entry['name']}: {expression} is no licence of SPDX")
    return wrong, listed


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    wrong, listed = check(sys.argv[1])
    for line in wrong:
        print(f"{sys.argv[1]}: {line}", file=sys.stderr)
    if wrong:
        sys.exit(1)
    kinds = [relation["relationshipType"] for relation in listed["relationships"]]
    print(f"{pathlib.Path(sys.argv[1]).name}: {kinds.count('CONTAINS')} files, {kinds.count('STATIC_LINK')} packages compiled in, "
          f"{kinds.count('DYNAMIC_LINK')} loaded, all as the package holds them")


if __name__ == "__main__":
    main()
