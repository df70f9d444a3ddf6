#!/usr/bin/env python3
"""Makes the C++ header of the cycle's states, quality bits, faults and capacities from states.toml.

  generate_states.py --cpp FOLDER   writes states.hpp (the build does this)
"""
import argparse
import pathlib
import re
import sys
import tomllib

LARGEST_VALUE = 65535  # a code is published in one register


class StatesError(Exception):
    pass


def check(states):
    """Each name once, each value once: a history and a PLC know a code by either."""
    for kind in ("slots", "codes"):
        if kind not in states:
            raise StatesError(f"{kind} is missing")
    for name, count in states["slots"].items():
        if not isinstance(count, int) or count < 1:
            raise StatesError(f"slots.{name}: {count}, must be a whole number of at least 1")
    kinds = set()
    for codes in states["codes"]:
        if codes["name"] in kinds:
            raise StatesError(f"codes {codes['name']} stand twice")
        kinds.add(codes["name"])
        for key in ("value", "name"):
            seen = set()
            for code in codes["values"]:
                if code[key] in seen:
                    raise StatesError(f"{codes['name']}: {key} {code[key]} stands twice")
                seen.add(code[key])
        for code in codes["values"]:
            if not 0 <= code["value"] <= LARGEST_VALUE:
                raise StatesError(f"{codes['name']}: {code['name']} = {code['value']}, allowed: 0 to {LARGEST_VALUE}")


def load(path):
    """What states.toml declares: {"slots": {name: count}, "codes": [{name, doc, values: [{value, name, doc}]}]}."""
    with open(path, "rb") as file:
        states = tomllib.load(file)
    check(states)
    return states


def text_literal(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def table_name(kind):
    """SensorFault: sensor_fault_codes."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", kind).lower() + "_codes"


def cpp_header(states):
    out = ["// Made by firmware/cycle/generate_states.py from states.toml.", "#pragma once", "", "#include <array>",
           "#include <cstddef>", "#include <cstdint>", "", "namespace spindle_twin::firmware {", "",
           "/// How many values of each kind the daemon, and so the register map, has room for.", "namespace slots {"]
    out += [f"inline constexpr std::size_t {name} = {count};" for name, count in states["slots"].items()]
    out += ["}  // namespace slots", "",
            "/// One value, or bit, of a code as programs print it.", "struct CodeName {", "  std::uint16_t value;",
            "  const char* name;", "  const char* doc;", "};", ""]
    for codes in states["codes"]:
        values = codes["values"]
        out += [f"/// {codes['doc']}", f"enum class {codes['name']} : std::uint16_t {{"]
        out += [f"  {code['name']} = {code['value']},  ///< {code['doc']}" for code in values]
        out += ["};", f"inline constexpr std::array<CodeName, {len(values)}> {table_name(codes['name'])}{{{{"]
        out += [f"    {{{code['value']}, {text_literal(code['name'])}, {text_literal(code['doc'])}}}," for code in values]
        out += ["}};", ""]
    out += ["}  // namespace spindle_twin::firmware", ""]
    return "\n".join(out)


def main():
    here = pathlib.Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--states", type=pathlib.Path, default=here / "states.toml")
    parser.add_argument("--cpp", type=pathlib.Path, required=True)
    options = parser.parse_args()
    try:
        states = load(options.states)
    except (StatesError, tomllib.TOMLDecodeError) as error:
        sys.exit(f"{options.states}: {error}")
    options.cpp.mkdir(parents=True, exist_ok=True)
    (options.cpp / "states.hpp").write_text(cpp_header(states))


if __name__ == "__main__":
    main()
