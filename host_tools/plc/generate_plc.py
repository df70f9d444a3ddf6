#!/usr/bin/env python3
"""Makes the files for PLCs from plc.toml, logic.st, the register map and its codes.

  generate_plc.py --write    writes beside this script spindle_twin.st and spindle_twin.scl; what reads the registers around
                             them, from the files reader_*; twin_interface.h and interface.md
  generate_plc.py --check    fails if one of them is not what --write would write
"""
import argparse
import pathlib
import re
import sys
import tomllib

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "firmware" / "serve"))
import generate_registers  # noqa: E402: beside another folder's sources

MADE = "Made by host_tools/plc/generate_plc.py; do not edit."
C_TYPES = {"BOOL": "bool", "UINT": "uint16_t", "WORD": "uint16_t", "UDINT": "uint32_t", "DINT": "int32_t", "REAL": "float"}
LEAST = {"UINT": 0, "WORD": 0, "UDINT": 0}
MOST = {"UINT": 65535, "WORD": 65535}
VALUE, UNIT_PER_NM = "compensation_int16", 1000.0  # what logic.st decodes: 16 bits with sign, in um
# Used in logic.st and nowhere else, so that they stand here: what is left of a long wait, and the steps of the way.
OWN_CONSTANTS = [("MOST_STEP_US", "UDINT", 1000000), ("US_PER_MS", "UDINT", 1000), ("TICK_US", "UDINT", 10000),
                 ("TICKS_PER_S", "DINT", 100), ("UM_PER_NM", "REAL", 0.001), ("NO_BITS", "WORD", 0)]


class PlcError(Exception):
    pass


def snake(name):
    """SlewNmPerS: slew_nm_per_s."""
    return re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower()


def literal(kind, value):
    """A value of plc.toml as IEC 61131-3 writes it."""
    return f"16#{value:04X}" if kind == "WORD" else f"{value:.7g}" if kind == "REAL" and value % 1 else str(value)


class Plan:
    """All that the files say, from the four sources."""

    def __init__(self):
        self.map = generate_registers.load(ROOT / "firmware" / "serve" / "registers.toml")
        self.registers = {register["name"]: register for block in self.map["block"] for register in block["register"]}
        self.codes = {codes["name"]: {code["name"]: code["value"] for code in codes["values"]} for codes in self.map["codes"]}
        table = tomllib.loads((HERE / "plc.toml").read_text(encoding="utf-8"))
        self.reads, self.inputs, self.settings = table["read"], table["input"], table["setting"]
        self.outputs, self.memory, self.reasons = table["output"], table["memory"], table["reason"]
        for read in self.reads:
            read["address"] = self.register(read["first"])["address"]
            last = self.register(read["last"])
            if not any(block["address"] <= read["address"] <= last["address"] < block["address"] + block["length"]
                       for block in self.map["block"]):
                raise PlcError(f"plc.toml: {read['name']} reads {read['first']} to {read['last']}, allowed: from one block")
            read["count"] = last["address"] + last["words"] - read["address"]
        self.constants = self.make_constants()

    def register(self, name):
        if name not in self.registers:
            raise PlcError(f"plc.toml: register {name}, allowed: the names of firmware/serve/registers.toml")
        return self.registers[name]

    def make_constants(self):
        """Name, type, value of what logic.st names in capitals."""
        value = self.register(VALUE)
        if (value["type"], value["unit"]) != ("int16", "um"):
            raise PlcError(f"logic.st takes {VALUE} for an int16 in um; it is {value['type']} in {value['unit']}")
        states, rungs = self.codes["State"], self.codes["Rung"]
        found = [("KNOWN_ANSWER", "UINT", 0x1234), ("MAP_VERSION", "UINT", self.map["map_version"]),
                 ("STATE_RUNNING", "UINT", states["running"]), ("STATE_DEGRADED", "UINT", states["degraded"]),
                 ("RUNG_NONE", "UINT", rungs["none"]), ("RUNG_LAST", "UINT", max(rungs.values())),
                 ("VALUE_NOT_PRESENT", "UINT", int(generate_registers.NOT_PRESENT["int16"]) & 0xFFFF),
                 ("NM_PER_COUNT", "DINT", round(value["resolution"] * UNIT_PER_NM)), *OWN_CONSTANTS]
        for read in self.reads:
            for word, register in read["words"].items():
                place = self.register(register)["address"] - read["address"]
                if not 0 <= place < read["count"]:
                    raise PlcError(f"plc.toml: {word} is register {register}, allowed: {read['first']} to {read['last']}")
                found.append((word, "INT", place))
        return found + [(f"REASON_{reason['name'].upper()}", "UINT", n) for n, reason in enumerate(self.reasons)]

    def settings_good(self):
        """In structured text: each setting that has a range narrower than its type is within it."""
        parts = []
        for setting in self.settings:
            name, kind = setting["name"], setting["type"]
            if setting["min"] != LEAST.get(kind):
                parts.append(f"({name} >= {literal(kind, setting['min'])})")
            if setting["max"] != MOST.get(kind):
                parts.append(f"({name} <= {literal(kind, setting['max'])})")
        return " AND\n  ".join(parts)

    def logic(self):
        return (HERE / "logic.st").read_text(encoding="utf-8").replace("@settings_good@", self.settings_good())

    def temporaries(self):
        """Name and type of what logic.st computes anew in each call."""
        return [("StepUs", "UDINT"), ("Heartbeat", "UINT"), ("State", "UINT"), ("Rung", "UINT"), ("Age", "UINT"),
                ("TargetNm", "DINT"), ("RateNmPerS", "DINT"), ("MostNm", "DINT")]

    def explain(self, entry):
        unit = entry.get("unit")
        return f"{unit}: {entry['doc']}" if unit else entry["doc"]

    def sections(self):
        """Keyword, then name, type, initial value or nothing, and comment of each variable."""
        arrays = [(read["name"], f"ARRAY[0..{read['count'] - 1}] OF WORD", None, read["doc"]) for read in self.reads]
        inputs = [(entry["name"], entry["type"], entry.get("default"), self.explain(entry)) for entry in self.inputs]
        settings = [(entry["name"], entry["type"], literal(entry["type"], entry["default"]), self.explain(entry))
                    for entry in self.settings]
        outputs = [(entry["name"], entry["type"], None, self.explain(entry)) for entry in self.outputs]
        memory = [(entry["name"], entry["type"], None, entry["doc"]) for entry in self.memory]
        constants = [(name, kind, literal(kind, value), None) for name, kind, value in self.constants]
        return [("VAR_INPUT", arrays + inputs + settings), ("VAR_OUTPUT", outputs), ("VAR", memory),
                ("VAR_TEMP", [(name, kind, None, None) for name, kind in self.temporaries()]), ("VAR CONSTANT", constants)]

    def names(self):
        return {name for _, entries in self.sections() for name, *_ in entries}


def declarations(plan):
    lines = []
    for keyword, entries in plan.sections():
        lines.append(keyword)
        for name, kind, initial, doc in entries:
            comment = f" (* {doc} *)" if doc else ""
            lines.append(f"  {name} : {kind}{f' := {initial}' if initial is not None else ''};{comment}")
        lines.append("END_VAR")
    return "\n".join(lines)


def what_is_read(plan):
    return "\n".join(f"   {read['name']}: {read['count']} input registers (FC4) from {read['address']} on" for read in plan.reads)


def structured_text(plan):
    return f"""(* {MADE}
   The compensation of spindle-twind for CODESYS and TwinCAT. What it takes, what it gives and what happens when: README.md.
{what_is_read(plan)} *)
FUNCTION_BLOCK FB_SpindleTwin
{declarations(plan)}

{plan.logic().rstrip()}
END_FUNCTION_BLOCK
"""


def marked(plan, text):
    """Local names as SCL wants them, with a number sign; comments stay."""
    names = re.compile(rf"\b({'|'.join(sorted(plan.names(), key=len, reverse=True))})\b")
    parts = re.split(r"(\(\*.*?\*\))", text, flags=re.DOTALL)
    return "".join(part if part.startswith("(*") else names.sub(r"#\1", part) for part in parts)


def structured_control_language(plan):
    return f"""(* {MADE}
   The compensation of spindle-twind for SIMATIC S7-1200 and S7-1500: an external source of TIA Portal. What it takes, what
   it gives and what happens when: README.md.
{what_is_read(plan)} *)
FUNCTION_BLOCK "SpindleTwin"
{{ S7_Optimized_Access := 'FALSE' }}
VERSION : 0.1
{declarations(plan)}

BEGIN
{marked(plan, plan.logic()).rstrip()}
END_FUNCTION_BLOCK
"""


def reader(template):
    """What reads the registers and calls the function block, from a file with places for addresses and lengths."""
    def fill(plan):
        text = (HERE / template).read_text(encoding="utf-8").replace("@made@", MADE)
        for read in plan.reads:
            places = {"number": 30001 + read["address"], "offset": read["address"], "count": read["count"],
                      "last": read["count"] - 1, "bytes": 2 * read["count"]}
            for place, number in places.items():
                text = text.replace(f"@{read['name']}.{place}@", str(number))
        if "@" in text:
            raise PlcError(f"{template}: {text[text.index('@'):][:20]!r} is no place that is filled in")
        return text
    return fill


def c_literal(kind, value):
    return f"{float(value)!r}f" if kind == "REAL" else f"{value}u" if kind in ("UDINT", "UINT", "WORD") else str(value)


def c_struct(name, doc, fields):
    lines = [f"/* {doc} */", f"struct {name} {{"]
    lines += [f"  {kind} {field}; /* {comment} */" for kind, field, comment in fields]
    return "\n".join(lines + ["};", ""])


def c_fields(plan, entries):
    return [(C_TYPES[entry["type"]], snake(entry["name"]), plan.explain(entry)) for entry in entries]


def c_settings_good(plan):
    parts = []
    for setting in plan.settings:
        field, kind = f"settings->{snake(setting['name'])}", setting["type"]
        if setting["min"] != LEAST.get(kind):
            parts.append(f"{field} >= {c_literal(kind, setting['min'])}")
        if setting["max"] != MOST.get(kind):
            parts.append(f"{field} <= {c_literal(kind, setting['max'])}")
    return "/* Whether each setting is within its range; not a number is not. */\n" \
        "static inline bool twin_settings_good(const struct twin_settings* settings) {\n  return " \
        + " &&\n         ".join(parts) + ";\n}\n"


def c_header(plan):
    arrays = [("uint16_t", f"{snake(read['name'])}[{read['count']}]", read["doc"]) for read in plan.reads]
    out = [f"/* {MADE} */", "#ifndef SPINDLE_TWIN_INTERFACE_H", "#define SPINDLE_TWIN_INTERFACE_H", "", "#include <stdbool.h>",
           "#include <stdint.h>", ""]
    for read in plan.reads:
        name = snake(read["name"]).upper()
        out += [f"#define TWIN_{name}_ADDRESS {read['address']} /* first input register (FC4) of {snake(read['name'])} */",
                f"#define TWIN_{name}_COUNT {read['count']}"]
    reasons = {name for name, _, _ in plan.constants if name.startswith("REASON_")}
    out += [f"#define TWIN_{name} {c_literal(kind, value)}" for name, kind, value in plan.constants if name not in reasons]
    out += ["", "/* The first that applies is told. */", "enum twin_reason {"]
    out += [f"  TWIN_REASON_{reason['name'].upper()} = {n}, /* {reason['doc']} */" for n, reason in enumerate(plan.reasons)]
    names = ", ".join(f'"{reason["name"]}"' for reason in plan.reasons)
    out += ["};", f"#define TWIN_REASON_NAMES {{{names}}}", ""]
    out.append(c_struct("twin_settings", "What is set once, at commissioning.", c_fields(plan, plan.settings)))
    defaults = ", ".join(c_literal(entry["type"], entry["default"]) for entry in plan.settings)
    out += [f"#define TWIN_SETTINGS_DEFAULT {{{defaults}}}", ""]
    out.append(c_struct("twin_input", "What each call takes.", arrays + c_fields(plan, plan.inputs)))
    out.append(c_struct("twin_output", "What each call gives.", c_fields(plan, plan.outputs)))
    out.append(c_struct("twin_memory", "What is remembered between two calls; zero before the first.", c_fields(plan, plan.memory)))
    return "\n".join(out + [c_settings_good(plan), "#endif", ""])


def markdown(plan):
    def table(heads, rows):
        return "\n".join(["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)] + ["| " + " | ".join(row) + " |" for row in rows])
    inputs = [(f"`{read['name']}`", f"{read['count']} words", read["doc"]) for read in plan.reads]
    inputs += [(f"`{entry['name']}`", entry["type"], plan.explain(entry)) for entry in plan.inputs]
    settings = [(f"`{entry['name']}`", entry["type"], literal(entry["type"], entry["default"]),
                 f"{literal(entry['type'], entry['min'])} to {literal(entry['type'], entry['max'])}", plan.explain(entry))
                for entry in plan.settings]
    outputs = [(f"`{entry['name']}`", entry["type"], plan.explain(entry)) for entry in plan.outputs]
    reasons = [(str(n), f"`{reason['name']}`", reason["doc"]) for n, reason in enumerate(plan.reasons)]
    reads = [(f"`{read['name']}`", "FC4", str(read["address"]), f"3{read['address'] + 1:04}", str(read["count"])) for read in plan.reads]
    return f"""# What the function blocks and the C client take and give

{MADE}

## What is read

{table(("into", "function", "offset", "number", "registers"), reads)}

## Inputs of each call

{table(("name", "type", "meaning"), inputs)}

## Settings

{table(("name", "type", "default", "allowed", "meaning"), settings)}

## Outputs

{table(("name", "type", "meaning"), outputs)}

## Reasons

The first that applies is told.

{table(("value", "name", "meaning"), reasons)}

In C the same names stand in small letters: `SlewNmPerS` is `slew_nm_per_s`.
"""


MAKERS = {"spindle_twin.st": structured_text, "spindle_twin.scl": structured_control_language,
          "spindle_twin_read.scl": reader("reader_tia.scl"), "spindle_twin_codesys.st": reader("reader_codesys.st"),
          "spindle_twin_twincat.st": reader("reader_twincat.st"), "twin_interface.h": c_header, "interface.md": markdown}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    task = parser.add_mutually_exclusive_group(required=True)
    task.add_argument("--write", action="store_true")
    task.add_argument("--check", action="store_true")
    options = parser.parse_args()
    try:
        made = {HERE / name: maker(Plan()) for name, maker in MAKERS.items()}
    except (PlcError, generate_registers.MapError, tomllib.TOMLDecodeError) as error:
        sys.exit(f"generate_plc.py: {error}")
    if options.write:
        for path, text in made.items():
            path.write_text(text, encoding="utf-8")
        return
    stale = [str(path) for path, text in made.items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    if stale:
        sys.exit(f"stale: {', '.join(stale)}; run python3 {pathlib.Path(__file__)} --write")


if __name__ == "__main__":
    main()
