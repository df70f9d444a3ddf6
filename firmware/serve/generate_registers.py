#!/usr/bin/env python3
"""Makes the C++ table, the documentation and the PLC import list of the register map from registers.toml,
and of the states and capacities that it takes from firmware/cycle/states.toml.

  generate_registers.py --cpp FOLDER   writes register_table.hpp and register_text.cpp (the build does this)
  generate_registers.py --write        writes registers.md and registers.csv beside registers.toml
  generate_registers.py --check        fails if registers.md or registers.csv is not what --write would write
"""
import argparse
import csv
import io
import pathlib
import sys
import tomllib

sys.dont_write_bytecode = True  # the build leaves nothing beside the sources
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cycle"))
import generate_states  # noqa: E402: beside another folder's sources

WORDS = {"uint16": 1, "int16": 1, "offset16": 1, "uint32": 2, "int32": 2, "float32": 2, "float32_cdab": 2}
NOT_PRESENT = {"uint16": "65535", "int16": "-32768", "offset16": "0", "uint32": "4294967295",
               "int32": "-2147483648", "float32": "NaN", "float32_cdab": "NaN"}
MOST_REGISTERS_PER_READ = 125
METRICS = ("gauge", "counter", "none")


class MapError(Exception):
    pass


def check_meaning(register, table):
    """What the number says besides its unit: a code, bits, and what becomes of it in /metrics."""
    known = [codes["name"] for codes in table["codes"]]
    for key in ("codes", "bits"):
        if key in register and register[key] not in known:
            raise MapError(f"register {register['name']}: {key} {register[key]}, allowed: {', '.join(known)}")
    if "codes" in register and "bits" in register:
        raise MapError(f"register {register['name']}: codes and bits, allowed: one of them")
    if register.get("metric", METRICS[0]) not in METRICS:
        raise MapError(f"register {register['name']}: metric {register['metric']}, allowed: {', '.join(METRICS)}")


def load(path):
    with open(path, "rb") as file:
        table = tomllib.load(file)
    table |= generate_states.load(path.parent / table["states"])
    owner = {}
    names = set()
    for block in table["block"]:
        first, length = block["address"], block["length"]
        if length > MOST_REGISTERS_PER_READ:
            raise MapError(f"block {block['name']}: {length} registers, one read takes at most {MOST_REGISTERS_PER_READ}")
        for register in block["register"]:
            name = register["name"]
            if name in names:
                raise MapError(f"register {name} stands twice")
            names.add(name)
            if register["type"] not in WORDS:
                raise MapError(f"register {name}: type {register['type']}, allowed: {', '.join(WORDS)}")
            slots = register.get("slots", 1)
            if isinstance(slots, str) and slots not in table["slots"]:
                raise MapError(f"register {name}: slots {slots}, allowed: a number or {', '.join(table['slots'])}")
            register["slot_names"] = slots if isinstance(slots, str) else ""
            check_meaning(register, table)
            register["slots"] = table["slots"][slots] if isinstance(slots, str) else slots
            register["words"] = WORDS[register["type"]] * register["slots"]
            for address in range(register["address"], register["address"] + register["words"]):
                if address in owner:
                    raise MapError(f"registers {owner[address]} and {name} overlap at {address}")
                if not first <= address < first + length:
                    raise MapError(f"register {name}: {address} is outside block {block['name']}, {first} to {first + length - 1}")
                owner[address] = name
    return table


def raw_literal(text):
    return "\n".join(f"    {generate_states.text_literal(line)[:-1]}\\n\"" for line in text.splitlines())


def cpp_entry(block, register):
    """One row of register_entries."""
    literal = generate_states.text_literal
    codes = register.get("codes", register.get("bits"))
    return (f"    {{{literal(register['name'])}, {register['address']}, RegisterType::{register['type']}, {register['slots']}, "
            f"{float(register.get('resolution', 1.0))!r}, {literal(register.get('unit', ''))}, "
            f"{'true' if block['command'] else 'false'}, {literal(register['doc'])}, {literal(register['slot_names'])}, "
            f"{generate_states.table_name(codes) if codes else '{}'}, {'true' if 'bits' in register else 'false'}, "
            f"Metric::{register.get('metric', METRICS[0])}}},")


def cpp_table(table):
    out = ["// Made by firmware/serve/generate_registers.py from registers.toml.", "#pragma once", "", "#include <array>",
           "#include <cstddef>", "#include <cstdint>", "#include <span>", "",
           '#include "firmware/cycle/states.hpp"', '#include "firmware/words/register_type.hpp"', "",
           "namespace spindle_twin::firmware {", "",
           f"inline constexpr std::uint16_t register_map_version = {table['map_version']};", ""]
    out += ["/// What becomes of a register in the metrics; none: another one shows the same.",
            f"enum class Metric {{ {', '.join(METRICS)} }};", "", "struct RegisterEntry {", "  const char* name;", "  std::uint16_t address;  ///< 0-based offset",
            "  RegisterType type;", "  std::uint16_t slots;", "  double resolution;  ///< worth of one count, in unit",
            "  const char* unit;", "  bool command;  ///< written by the PLC", "  const char* doc;",
            "  const char* slot_names;  ///< what the slots are of, as under [slots]; empty: they have no names",
            "  std::span<const CodeName> codes;  ///< what the number, or its bits, mean; empty: it is a quantity",
            "  bool codes_are_bits;", "  Metric metric;", "};", "",
            "struct RegisterBlock {", "  const char* name;", "  std::uint16_t address;", "  std::uint16_t length;",
            "  bool command;", "};", ""]
    registers = [(block, register) for block in table["block"] for register in block["register"]]
    out += ["/// Index into register_entries.", "enum class Register : std::size_t {"]
    out += [f"  {register['name']}," for _, register in registers]
    out += ["};", "", f"inline constexpr std::array<RegisterEntry, {len(registers)}> register_entries{{{{"]
    out += [cpp_entry(block, register) for block, register in registers]
    out += ["}};", "", f"inline constexpr std::array<RegisterBlock, {len(table['block'])}> register_blocks{{{{"]
    out += [f"    {{{generate_states.text_literal(block['name'])}, {block['address']}, {block['length']}, {'true' if block['command'] else 'false'}}},"
            for block in table["block"]]
    out += ["}};", "", "}  // namespace spindle_twin::firmware", ""]
    return "\n".join(out)


def cpp_text(table):
    return "\n".join([
        "// Made by firmware/serve/generate_registers.py from registers.toml.", '#include "firmware/serve/register_map.hpp"', "",
        "namespace spindle_twin::firmware {", "",
        "const char* register_map_markdown() {", "  return", raw_literal(markdown(table)) + ";", "}", "",
        "const char* register_map_csv() {", "  return", raw_literal(plc_list(table)) + ";", "}", "",
        "}  // namespace spindle_twin::firmware", ""])


def span(first, words):
    return str(first) if words == 1 else f"{first}-{first + words - 1}"


def markdown(table):
    out = ["# Register map", "",
           f"Made by `generate_registers.py` from `registers.toml`; map version {table['map_version']}.", "",
           "Offsets are 0-based, as they stand in the Modbus frame. Input registers (FC4) and holding registers (FC3) hold the "
           "same values at the same offset; the command block is holding only. The 3xxxx/4xxxx numbers are offset + 1 "
           "behind the leading digit. Units 0, 1 and 255 are answered.", "",
           "Values of 32 bits are big-endian with the high word first (ABCD) unless the type says cdab. A slot that is unused or "
           "has no value holds the type's not-present value; real values saturate one count before it:", "",
           "| type | words | not present |", "|---|---|---|"]
    out += [f"| {kind} | {words} | {NOT_PRESENT[kind]} |" for kind, words in WORDS.items()]
    out += ["", "One request is answered from one cycle. Who reads several blocks compares the sequence at the start of each.", ""]
    for block in table["block"]:
        first = block["address"]
        out += [f"## {block['name']}, {span(first, block['length'])}", "", block["doc"], "",
                "| offset | numbers | name | type | slots | unit | resolution | meaning |", "|---|---|---|---|---|---|---|---|"]
        for register in block["register"]:
            at, words = register["address"], register["words"]
            numbers = f"4{at + 1:04d}" if block["command"] else f"3{at + 1:04d}, 4{at + 1:04d}"
            resolution = f"{register['resolution']:g}" if "resolution" in register else ""
            out.append(f"| {span(at, words)} | {numbers} | {register['name']} | {register['type']} | {register['slots']} | "
                       f"{register.get('unit', '')} | {resolution} | {register['doc']} |")
        out.append("")
    for codes in table["codes"]:
        out += [f"## {codes['name']}", "", codes["doc"], "", "| value | name | meaning |", "|---|---|---|"]
        out += [f"| {code['value']} | {code['name']} | {code['doc']} |" for code in codes["values"]]
        out.append("")
    return "\n".join(out[:-1]) + "\n"


def plc_list(table):
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(["name", "offset", "input_register", "holding_register", "type", "unit", "resolution", "access", "meaning"])
    for block in table["block"]:
        for register in block["register"]:
            for slot in range(register["slots"]):
                at = register["address"] + slot * WORDS[register["type"]]
                name = register["name"] if register["slots"] == 1 else f"{register['name']}_{slot + 1}"
                rows.writerow([name, at, "" if block["command"] else f"3{at + 1:04d}", f"4{at + 1:04d}", register["type"],
                               register.get("unit", ""), f"{register.get('resolution', 1):g}",
                               "read-write" if block["command"] else "read", register["doc"]])
    return out.getvalue()


def main():
    here = pathlib.Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--map", type=pathlib.Path, default=here / "registers.toml")
    task = parser.add_mutually_exclusive_group(required=True)
    task.add_argument("--cpp", type=pathlib.Path)
    task.add_argument("--write", action="store_true")
    task.add_argument("--check", action="store_true")
    options = parser.parse_args()
    try:
        table = load(options.map)
    except (MapError, generate_states.StatesError, tomllib.TOMLDecodeError) as error:
        sys.exit(f"{options.map}: {error}")
    if options.cpp:
        options.cpp.mkdir(parents=True, exist_ok=True)
        (options.cpp / "register_table.hpp").write_text(cpp_table(table))
        (options.cpp / "register_text.cpp").write_text(cpp_text(table))
        return
    stale = []
    for name, text in (("registers.md", markdown(table)), ("registers.csv", plc_list(table))):
        path = options.map.parent / name
        if options.write:
            path.write_text(text)
        elif not path.exists() or path.read_text() != text:
            stale.append(str(path))
    if stale:
        sys.exit(f"stale: {', '.join(stale)}; run python3 {pathlib.Path(__file__)} --write")


if __name__ == "__main__":
    main()
