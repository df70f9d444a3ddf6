"""Types of a function block that structured_text.py has read, and the block as a Python function.

checked(block, instances) gives a Checked or raises TypeProblem with the line. It is as strict as the strictest control: no
type becomes another by itself, a temporary variable is written before it is read, and nothing is declared in vain.
A Checked steps: its numbers are those of the controls, and a result that does not fit its type raises OverflowError.
"""
import struct

RANGES = {"INT": (-32768, 32767), "UINT": (0, 65535), "DINT": (-2**31, 2**31 - 1), "UDINT": (0, 2**32 - 1), "WORD": (0, 65535),
          "USINT": (0, 255), "BYTE": (0, 255)}
WHOLE = ("INT", "UINT", "DINT", "UDINT", "USINT")
SIGNED = ("INT", "DINT", "REAL")
CONVERSIONS = {"WORD_TO_UINT": ("WORD", "UINT"), "WORD_TO_INT": ("WORD", "INT"), "INT_TO_DINT": ("INT", "DINT"),
               "UDINT_TO_DINT": ("UDINT", "DINT"), "DINT_TO_REAL": ("DINT", "REAL"), "REAL_TO_DINT": ("REAL", "DINT")}
ELEMENTARY = (*RANGES, "BOOL", "REAL")
WRITABLE = ("VAR_OUTPUT", "VAR", "VAR_TEMP")


class TypeProblem(Exception):
    pass


def single(value):
    """The nearest REAL."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def fitting(kind, value):
    if kind == "REAL":
        return single(value)
    least, most = RANGES[kind]
    if not least <= value <= most:
        raise OverflowError(f"{value} does not fit {kind}")
    return value


def quotient(left, right):
    return abs(left) // abs(right) * (1 if (left < 0) == (right < 0) else -1)


def converted(function, value):
    if function == "WORD_TO_INT":
        return value - 65536 if value > 32767 else value
    if function == "REAL_TO_DINT":
        return fitting("DINT", round(value))
    return fitting(CONVERSIONS[function][1], value)


def number(text):
    return int(text[3:], 16) if text.startswith("16#") else float(text) if "." in text else int(text)


class Checked:
    def __init__(self, block, instances):
        self.block, self.instances = block, instances
        self.variables = block.variables
        self.read_names, self.made = set(), []
        for variable in self.variables.values():
            self.declared(variable)
        self.written = set()
        self.walk(block.statements, self.written, 1)
        unused = [name for name, variable in self.variables.items() if name not in self.read_names
                  and variable.section != "VAR_OUTPUT" and not block.program and variable.kind.strip('"') not in self.instances]
        if unused:
            raise TypeProblem(f"{block.name}: nobody reads {', '.join(unused)}")
        source = "def step(v):\n" + "\n".join(self.made or ["  pass"])
        space = {"fitting": fitting, "quotient": quotient, "converted": converted}
        exec(compile(source, block.name, "exec"), space)
        self.function = space["step"]

    def problem(self, line, text):
        raise TypeProblem(f"{self.block.name}, line {line}: {text}")

    def declared(self, variable):
        if variable.kind not in ELEMENTARY and variable.kind.strip('"') not in self.instances:
            self.problem(variable.line, f"type {variable.kind} of {variable.name} is not known")
        if variable.section == "VAR CONSTANT" and variable.initial is None:
            self.problem(variable.line, f"constant {variable.name} has no value")
        if variable.initial is not None:
            self.value_of(variable.initial, variable.kind)

    def variable(self, name, line):
        if name not in self.variables:
            self.problem(line, f"{name} is not declared so")
        return self.variables[name]

    def value_of(self, node, wanted):
        """Python for an expression that must be of this type; a number without type takes it."""
        kind, text = self.expression(node)
        if kind == "literal":
            return self.literal(node, wanted, text)
        if kind != wanted:
            self.problem(node[-1], f"{kind} where {wanted} is needed")
        return text

    def literal(self, node, wanted, text):
        value = eval(text)
        if wanted == "REAL" and isinstance(value, float):
            return repr(single(value))
        if wanted not in RANGES or isinstance(value, float):
            self.problem(node[-1], f"number {value} where {wanted} is needed")
        try:
            return repr(fitting(wanted, value))
        except OverflowError as error:
            self.problem(node[-1], str(error))

    def expression(self, node):
        """Type and Python; a plain number's type is literal."""
        return getattr(self, "of_" + node[0])(*node[1:])

    def of_number(self, text, line):
        if text in ("TRUE", "FALSE"):
            return "BOOL", text.capitalize()
        return "literal", repr(number(text))

    def of_text(self, text, line):
        return "STRING", text

    def of_time(self, text, line):
        return "TIME", text[2:-2]

    def of_name(self, name, line):
        variable = self.variable(name, line)
        self.read_names.add(name)
        if variable.last is not None:
            return f"ARRAY[0..{variable.last}] OF {variable.kind}", f"v[{name!r}]"
        if variable.section == "VAR_TEMP" and name not in self.now_written:
            self.problem(line, f"{name} is read, but not always written before")
        return variable.kind, f"v[{name!r}]"

    def of_index(self, name, place, line):
        variable = self.variable(name, line)
        self.read_names.add(name)
        kind, text = self.expression(place)
        if variable.last is None or kind not in (*WHOLE, "literal"):
            self.problem(line, f"{name}[{kind}]: an array and a whole number are needed")
        if place[0] == "name":
            constant = self.variable(place[1], line)
            where = number(constant.initial[1]) if constant.section == "VAR CONSTANT" else None
        else:
            where = eval(text) if kind == "literal" else None
        if where is None or not 0 <= where <= variable.last:
            self.problem(line, f"{name}[{where}]: a constant from 0 to {variable.last} is needed")
        return variable.kind, f"v[{name!r}][{where}]"

    def of_member(self, name, member, line):
        kind = self.variable(name, line).kind.strip('"')
        outputs = self.instances.get(kind, ({}, {}))[1]
        if member not in outputs:
            self.problem(line, f"{name}.{member}: {kind} has no such output")
        return outputs[member], f"v[{name!r}].outputs[{member!r}]"

    def of_call(self, function, argument, line):
        if function == "ADR":
            return "POINTER", self.expression(argument)[1]
        if function not in CONVERSIONS:
            self.problem(line, f"function {function} is not known")
        taken, given = CONVERSIONS[function]
        return given, f"converted({function!r}, {self.value_of(argument, taken)})"

    def of_unary(self, operator, argument, line):
        kind, text = self.expression(argument)
        if operator == "-":
            if kind == "literal":
                return "literal", f"-{text}"
            if kind not in SIGNED:
                self.problem(line, f"- before {kind}")
            return kind, f"fitting({kind!r}, -{text})"
        if kind not in ("BOOL", "WORD"):
            self.problem(line, f"NOT before {kind}")
        return kind, f"(not {text})" if kind == "BOOL" else f"({text} ^ 65535)"

    def of_binary(self, operator, left, right, line):
        kinds = [self.expression(node)[0] for node in (left, right)]
        kind = kinds[1] if kinds[0] == "literal" else kinds[0]
        first, second = self.value_of(left, kind), self.value_of(right, kind)
        if operator in ("AND", "OR", "XOR"):
            if kind not in ("BOOL", "WORD"):
                self.problem(line, f"{operator} between {kind}")
            return kind, f"({first} {dict(AND='&', OR='|', XOR='^')[operator]} {second})"
        if operator in ("=", "<>"):
            return "BOOL", f"({first} {'==' if operator == '=' else '!='} {second})"
        if kind not in (*WHOLE, "REAL") or (operator == "MOD" and kind == "REAL"):
            self.problem(line, f"{operator} between {kind}")
        if operator in ("<", "<=", ">", ">="):
            return "BOOL", f"({first} {operator} {second})"
        if operator == "MOD":
            return kind, f"({first} - quotient({first}, {second}) * {second})"
        if operator == "/" and kind != "REAL":
            return kind, f"fitting({kind!r}, quotient({first}, {second}))"
        return kind, f"fitting({kind!r}, {first} {operator} {second})"

    def walk(self, statements, written, depth):
        """Checks and translates; `written` are the variables that are written by then. True: it ends in a RETURN."""
        space = "  " * depth
        for statement in statements:
            self.now_written = written
            if statement[0] == "return":
                self.made.append(space + "return")
                return True
            if statement[0] == "assign":
                self.assign(*statement[1:], space)
                written.add(statement[1][1])
            elif statement[0] == "instance":
                self.instance(*statement[1:], space)
            else:
                self.choice(statement, written, depth)
        return False

    def assign(self, target, value, line, space):
        variable = self.variable(target[1], line)
        if variable.section not in WRITABLE or variable.last is not None:
            self.problem(line, f"{variable.name} is of {variable.section} and cannot be assigned")
        self.made.append(f"{space}v[{variable.name!r}] = {self.value_of(value, variable.kind)}")

    def choice(self, statement, written, depth):
        _, branches, otherwise, _ = statement
        space, ends = "  " * depth, []
        for n, (condition, statements) in enumerate(branches):
            self.now_written = written
            self.made.append(f"{space}{'if' if n == 0 else 'elif'} {self.value_of(condition, 'BOOL')}:")
            self.branch(statements, written, depth, ends)
        self.made.append(f"{space}else:")
        self.branch(otherwise, written, depth, ends)
        if ends:
            written |= set.intersection(*ends)

    def branch(self, statements, written, depth, ends):
        mine = set(written)
        if not statements:
            self.made.append("  " * depth + "  pass")
        if not self.walk(statements, mine, depth + 1):
            ends.append(mine)

    def instance(self, name, parameters, line, space):
        kind = self.variable(name, line).kind.strip('"')
        if kind not in self.instances:
            self.problem(line, f"{name} is {kind} and cannot be called")
        inputs, given = self.instances[kind][0], []
        for parameter, direction, value in parameters:
            if direction != ":=" or parameter not in inputs:
                self.problem(line, f"{kind} has no input {parameter}, it has {', '.join(inputs)}")
            text = self.expression(value)[1] if inputs[parameter] == "VARIANT" else self.value_of(value, inputs[parameter])
            given.append(f"{parameter!r}: {text}")
        self.made.append(f"{space}v[{name!r}].call({{{', '.join(given)}}})")

    def initial_values(self):
        """Of all variables, as a control sets them before the first call; None: a temporary one, which has none. Instances
        of other blocks are the caller's: objects with call(inputs) and outputs."""
        found = {}
        for variable in self.variables.values():
            plain = None if variable.section == "VAR_TEMP" else False if variable.kind == "BOOL" else \
                0.0 if variable.kind == "REAL" else 0
            value = eval(self.value_of(variable.initial, variable.kind)) if variable.initial is not None else plain
            found[variable.name] = value if variable.last is None else [value] * (variable.last + 1)
        return found

    def step(self, values):
        """One call of the block on its variables."""
        for variable in self.variables.values():
            if variable.section == "VAR_TEMP":
                values[variable.name] = None
        self.function(values)


def checked(block, instances=None):
    return Checked(block, instances or {})


def signature(block):
    """Inputs and outputs of a block, for those that call it."""
    def kinds(section):
        return {v.name: v.kind if v.last is None else f"ARRAY[0..{v.last}] OF {v.kind}" for v in block.variables.values()
                if v.section == section}
    return kinds("VAR_INPUT"), kinds("VAR_OUTPUT")
