"""Faults as switches: one copy of the sources holds many faults, and a program says when it starts which of them is on.

fault_switch.hpp holds what the calls do that are written here. A fault that cannot be written so (in a size of an array,
a template's argument, a value that the compiler works out) is left out, as its compiler says or its object shows.
"""
import re
import struct
import subprocess

from faults import SWAPS, code_of, other

FAULT = "spindle_twin_fault"
INCLUDE = '#include "tests/mutation/fault_switch.hpp"'
NEVER, OR_NEVER, MUST = 0, 1, 2  # no switch; one that is off where the compiler works out the value; one that may not stand there
CONSTANT = re.compile(r"^(\s*(?:static |inline )*)constexpr (?=[\w:<>, ]+ \w+(?: =|\{))")
OPENS, CLOSES = "([{", ")]}"
LOGICAL = (" && ", " || ")


def switched_line(line, faults, in_class):
    """A line with switches for its faults, (number, column, token, how), of which none is logical. `in_class`: what is
    static belongs to a class."""
    if any(how == MUST for *_, how in faults):
        constant = CONSTANT.match(line)
        if constant:  # its value is known when the program starts, not before
            kept, line = line[:constant.end()], line[constant.end():]
            moved = len(kept)
            kind = constant.group(1) + ("inline const " if "static" in kept and in_class else "const ")
            line = kind + line
            faults = [(number, column - moved + len(kind), token, how) for number, column, token, how in faults]
    for number, column, token, how in sorted(faults, key=lambda fault: -fault[1]):
        which = f"{number}, {'true' if how == OR_NEVER else 'false'}"
        if token.startswith("std::m"):
            text = f"{FAULT}::extreme<{which}, {'true' if 'max' in token else 'false'}>("
        elif token in SWAPS and token.startswith(" "):
            text = f"{token}{FAULT}::Between<{which}>{{}}{token}"
        else:
            text = f"{FAULT}::one_of<{which}>({token}, {other(token)})"
        line = line[:column] + text + line[column + len(token):]
    return line


def first_end(code, places, inwards, outwards, ends):
    """The first of these places, in their order, where an expression ends: at a bracket that leads out of it, or, outside
    of brackets, where `ends` says so; None if there is none."""
    depth = 0
    for place in places:
        if code[place] in inwards:
            depth += 1
        elif code[place] in outwards:
            if depth == 0:
                return place
            depth -= 1
        elif depth == 0 and ends(place):
            return place
    return None


def bounds_of_logical(code, at):
    """Where the logical expression begins and ends that holds the operator at `at`; None if it cannot be told."""
    def before(place):
        colon = code[place] == ":" and ":" not in (code[place - 1], code[place + 1])
        return colon or code[place] in ",;?" or code[place - 2:place + 1] == " = " or code[:place + 1].endswith("return ")

    begin = first_end(code, range(at - 1, 0, -1), CLOSES, OPENS, before)
    end = first_end(code, range(at + 4, len(code)), OPENS, CLOSES, lambda place: code[place] in ",;?" or code[place:place + 3] == " : ")
    return None if begin is None or end is None else (begin + 1, end)


def with_switches(text, faults, is_header):
    """A source's text with switches for faults (number, line, column, token, how), and the numbers of those that it holds."""
    lines = text.split("\n")
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line) + 1)
    code = "\n".join(map(code_of, lines))
    written, taken = set(), []
    for number, line, column, token, how in faults:
        if how == NEVER or token not in LOGICAL:
            continue
        at = starts[line] + column
        bounds = bounds_of_logical(code, at)
        if bounds is None or any(bounds[0] <= starts[l] + c < bounds[1] for n, l, c, _, h in faults if n != number and h != NEVER):
            continue
        taken.append((bounds, at, number, token))
        written.add(number)
    by_line = {}
    for number, line, column, token, how in faults:
        if how != NEVER and token not in LOGICAL:
            by_line.setdefault(line, []).append((number, column, token, how))
            written.add(number)
    # From the end to the beginning, so that places before stay.
    edits = [(bounds[0], bounds[1], at, number, token) for bounds, at, number, token in taken]
    edits += [(starts[line], starts[line] + len(lines[line]), None, line, None) for line in by_line]
    for begin, end, at, key, token in sorted(edits, reverse=True):
        piece = text[begin:end]
        if at is None:
            piece = switched_line(piece, by_line[key], is_header)
        else:
            wrong = text[begin:at] + other(token) + text[at + len(token):end]
            lead = piece[:len(piece) - len(piece.lstrip())]
            piece = f"{lead}({FAULT}::is<{key}, true>() ? bool({wrong.strip()}) : bool({piece.strip()}))"
        text = text[:begin] + piece + text[end:]
    if written:
        first, rest = text.split("\n", 1)
        text = f"{first}\n{INCLUDE}\n{rest}" if first.startswith("#pragma once") else f"{INCLUDE}\n{text}"
    return text, written


def asked_when_running(program):
    """The faults that a program asks for when it runs."""
    section = program.with_suffix(".faults")
    section.unlink(missing_ok=True)
    subprocess.run(["objcopy", "--dump-section", f".fault={section}", program, "/dev/null"], check=False, stderr=subprocess.DEVNULL)
    if not section.exists():
        return set()
    numbers = section.read_bytes()
    return {number for number, in struct.iter_unpack("<i", numbers)}


def lines_to_blame(log, tree):
    """(file, line) pairs of each error of a compiler's log: each error's own place first, then what stands around it."""
    place = re.compile(re.escape(str(tree)) + r"/([\w./-]+):(\d+):(?:\d+:)?(.*)")
    blocks, block = [], []
    for text in log.splitlines():
        if text.startswith("FAILED: ") or re.match(r"\[\d+/\d+\]", text):
            block = []
        found = place.search(text)
        if not found:
            continue
        here = (found.group(1), int(found.group(2)) - 1)
        if " error: " in found.group(3):
            blocks.append([here, *block])
            block = []
        elif blocks and ("note: " in found.group(3)):
            blocks[-1].append(here)
        else:
            block.append(here)
    return blocks
