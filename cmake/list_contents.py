#!/usr/bin/env python3
"""What is inside a package, as SPDX 2.3 in JSON: its files with their checksums, what was compiled into its program, and
the libraries that the program loads.

  cmake/list_contents.py --build FOLDER --program TARGET --package NAME --version VERSION --root FOLDER -o FILE PATH...

PATHs are the installed files as they will be called, --root is where they are now. What was compiled in is no list that
somebody keeps: ninja knows which header and which static library went into the program, dpkg whose they are;
ninja also knows what of KEPT_HERE went in, the work of others that this tree keeps. Of a library that is loaded its headers are
inside too, as far as they hold code. The licence is the one of Debian's copyright file. The same build gives the same bytes;
the time is SOURCE_DATE_EPOCH's where that is set.
"""
import argparse
import collections
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time

OWN_LICENCE = "MIT"
# Names of Debian's copyright files, as SPDX calls them. What is not here is given as NOASSERTION, with Debian's name.
SPDX_NAMES = {"expat": "MIT", "mit": "MIT", "mpl-2": "MPL-2.0", "mpl-2.0": "MPL-2.0", "apache-2.0": "Apache-2.0", "isc": "ISC",
              "bsd-3-clause": "BSD-3-Clause", "zlib": "Zlib", "bsl-1.0": "BSL-1.0", "lgpl-2.1+": "LGPL-2.1-or-later",
              "lgpl-2+": "LGPL-2.0-or-later", "gpl-2+": "GPL-2.0-or-later", "gpl-2.0+": "GPL-2.0-or-later",
              "gpl-2": "GPL-2.0-only", "lgpl-3+": "LGPL-3.0-or-later", "gpl-3+": "GPL-3.0-or-later",
              "epl-2.0 or edl-1.0": "EPL-2.0 OR BSD-3-Clause"}
# Packages whose copyright file a program cannot read, and the kernel's headers, which have an exception of their own.
KNOWN_LICENCES = {"libstdc++": "GPL-3.0-or-later WITH GCC-exception-3.1", "libgcc": "GPL-3.0-or-later WITH GCC-exception-3.1",
                  "libc6": "LGPL-2.1-or-later", "linux-libc": "GPL-2.0-only WITH Linux-syscall-note"}
# Folders of the tree with work of others, and the file that says the version behind a v.
KEPT_HERE = {"pages/uplot": {"name": "uPlot", "licence": "MIT", "copyright": "2022 Leon Sorokin", "version_in": "uPlot.iife.min.js"}}


def said_by(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def owners(paths):
    """Path of a file -> Debian package, by where its links lead; dpkg may know /usr/lib as /lib."""
    real = {path: os.path.realpath(path) for path in paths}
    asked = sorted(set(real.values()))
    both = asked + [path.removeprefix("/usr") for path in asked if path.startswith("/usr/lib")]
    answer = subprocess.run(["dpkg", "-S", *both], capture_output=True, text=True).stdout if asked else ""
    owner = {}
    for line in answer.splitlines():
        packages, _, path = line.rpartition(": ")
        owner[path if path.startswith("/usr") else "/usr" + path] = packages.split(", ")[0]
    missing = sorted(path for path in asked if path not in owner)
    if missing:
        sys.exit(f"list_contents.py: of no Debian package: {', '.join(missing[:5])}")
    return {path: owner[target] for path, target in real.items()}


def compiled_into(build, target):
    """System headers and static libraries that went into a target of the build."""
    inputs = said_by("ninja", "-C", build, "-t", "inputs", target).splitlines()
    objects = [name for name in inputs if name.endswith((".o", ".gch"))]
    read = said_by("ninja", "-C", build, "-t", "deps", *objects).splitlines()
    headers = {line.strip() for line in read if line.startswith("    /usr/")}
    return headers | {name for name in inputs if name.startswith("/usr/") and name.endswith(".a")}


def kept_here(build, target):
    """SPDX packages of what of KEPT_HERE went into a target of the build."""
    tree = pathlib.Path(__file__).resolve().parents[1]
    inputs = said_by("ninja", "-C", build, "-t", "inputs", target).splitlines()
    inputs = [os.path.realpath(os.path.join(build, name)) for name in inputs]
    packages = []
    for folder, about in KEPT_HERE.items():
        if not any(name.startswith(f"{tree / folder}{os.sep}") for name in inputs):
            continue
        version = re.search(r"\bv(\d+\.\d+\.\d+)\b", (tree / folder / about["version_in"]).read_text())[1]
        packages.append({"SPDXID": identifier("Kept-" + about["name"]), "name": about["name"], "versionInfo": version,
                         "supplier": "NOASSERTION", "downloadLocation": "NOASSERTION", "filesAnalyzed": False,
                         "sourceInfo": f"{folder} of the source", "copyrightText": about["copyright"],
                         "licenseConcluded": "NOASSERTION", "licenseDeclared": about["licence"],
                         "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                                           "referenceLocator": f"pkg:npm/{about['name'].lower()}@{version}"}]})
    return packages


def loaded_by(program):
    """Debian packages of the shared libraries that a program asks for, as its own architecture has them."""
    described = said_by("readelf", "-hd", program)
    architecture = "aarch64" if "AArch64" in described else "x86_64"
    names = re.findall(r"\(NEEDED\).*\[(.*)\]", described)
    libraries = []
    for name in names:
        places = [pathlib.Path(f"{folder}/{architecture}-linux-gnu/{name}") for folder in ("/usr/lib", "/lib")]
        found = [str(place) for place in places if place.exists()]
        if not found:
            sys.exit(f"list_contents.py: {program} needs {name}, which is not installed")
        libraries.append(found[0])
    return set(owners(libraries).values())


def licence(package):
    """SPDX expression, and what Debian's copyright file calls it."""
    name = package.split(":")[0]
    for start, known in KNOWN_LICENCES.items():
        if name.startswith(start):
            return known, known
    stanza = ""
    path = pathlib.Path(f"/usr/share/doc/{name}/copyright")
    for part in re.split(r"\n\s*\n", path.read_text(errors="replace") if path.exists() else ""):
        if re.match(r"(?:.*\n)*?Files:\s*\*", part):
            stanza = part
            break
    match = re.search(r"^Licen[sc]e:\s*(.+)$", stanza, re.MULTILINE)
    if not match:
        return "NOASSERTION", f"see {path}"
    return SPDX_NAMES.get(match[1].strip().lower(), "NOASSERTION"), match[1].strip()


def identifier(text):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]+", "-", text.replace("+", "plus"))


def debian_package(package):
    version, source = said_by("dpkg-query", "-W", "-f", "${Version}\t${source:Package}", package).split("\t")
    expression, debian_name = licence(package)
    return {"SPDXID": identifier("Debian-" + package), "name": package.split(":")[0], "versionInfo": version,
            "supplier": "Organization: Debian", "originator": "NOASSERTION", "downloadLocation": "NOASSERTION",
            "filesAnalyzed": False, "sourceInfo": f"Debian source package {source}", "copyrightText": "NOASSERTION",
            "licenseConcluded": "NOASSERTION", "licenseDeclared": expression, "licenseComments": f"Debian: {debian_name}",
            "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                              "referenceLocator": f"pkg:deb/debian/{package.split(':')[0]}@{version}?distro=bookworm"}]}


def file_entry(root, path):
    content = (root / path.lstrip("/")).read_bytes()
    return {"SPDXID": identifier("File-" + path), "fileName": "." + path, "copyrightText": "NOASSERTION",
            "licenseConcluded": "NOASSERTION", "licenseInfoInFiles": ["NOASSERTION"],
            "checksums": [{"algorithm": "SHA1", "checksumValue": hashlib.sha1(content).hexdigest()},
                          {"algorithm": "SHA256", "checksumValue": hashlib.sha256(content).hexdigest()}]}


def document(wanted):
    root = pathlib.Path(wanted.root)
    program = next(path for path in wanted.paths if path.endswith(("/bin/" + wanted.program, "/libexec/" + wanted.program)))
    files = [file_entry(root, path) for path in sorted(wanted.paths)]
    sums = sorted(entry["checksums"][0]["checksumValue"] for entry in files)
    own = {"SPDXID": "SPDXRef-Package", "name": wanted.package, "versionInfo": wanted.version,
           "supplier": "Organization: the spindle thermal twin authors", "downloadLocation": "NOASSERTION",
           "filesAnalyzed": True, "licenseConcluded": "NOASSERTION", "licenseDeclared": OWN_LICENCE,
           "licenseInfoFromFiles": ["NOASSERTION"], "copyrightText": "2026 the spindle thermal twin authors",
           "packageVerificationCode": {"packageVerificationCodeValue": hashlib.sha1("".join(sums).encode()).hexdigest()}}
    inside = collections.Counter(owners(compiled_into(wanted.build, wanted.program)).values())
    loaded = loaded_by(str(root / program.lstrip("/")))
    relations = [("SPDXRef-DOCUMENT", "DESCRIBES", "SPDXRef-Package", "")]
    relations += [("SPDXRef-Package", "CONTAINS", entry["SPDXID"], "") for entry in files]
    relations += [("SPDXRef-Package", "STATIC_LINK", identifier("Debian-" + name),
                   f"{count} of its headers or static libraries were compiled in") for name, count in sorted(inside.items())]
    relations += [("SPDXRef-Package", "DYNAMIC_LINK", identifier("Debian-" + name), "") for name in sorted(loaded)]
    kept = kept_here(wanted.build, wanted.program)
    relations += [("SPDXRef-Package", "STATIC_LINK", entry["SPDXID"], "written into its pages") for entry in kept]
    packages = [debian_package(name) for name in sorted(set(inside) | loaded)] + kept
    created = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())), datetime.timezone.utc)
    content = hashlib.sha256(json.dumps([own, files, packages], sort_keys=True).encode()).hexdigest()
    return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
            "name": f"{wanted.package}-{wanted.version}",
            "documentNamespace": f"https://spindle-twin.example/spdx/{wanted.package}-{wanted.version}-{content}",
            "creationInfo": {"created": created.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: cmake/list_contents.py"]},
            "packages": [own, *packages], "files": files,
            "relationships": [{"spdxElementId": one, "relationshipType": kind, "relatedSpdxElement": other,
                               **({"comment": comment} if comment else {})} for one, kind, other, comment in relations]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("--build", "--program", "--package", "--version", "--root"):
        parser.add_argument(name, required=True)
    parser.add_argument("-o", dest="out", required=True)
    parser.add_argument("paths", nargs="+")
    wanted = parser.parse_args()
    pathlib.Path(wanted.out).write_text(json.dumps(document(wanted), indent=1) + "\n")


if __name__ == "__main__":
    main()
