"""A parser of the structured text that host_tools/plc uses, in the forms of IEC 61131-3 (CODESYS, TwinCAT) and of Siemens'
SCL. It is ours, and knows no more of the languages than those files need: neither Debian nor npm has a compiler of either.

read_blocks(text, dialect) gives the function blocks and programs of a file, or raises SyntaxProblem with the line.

Expressions and statements are tuples: ("number", text, line), ("text", text, line), ("time", text, line), ("name", name, line), ("index", name, expression, line),
("member", name, member, line), ("call", function, expression, line), ("unary", operator, expression, line),
("binary", operator, left, right, line); ("assign", target, expression, line), ("if", [(condition, statements)], else, line),
("instance", name, [(parameter, direction, expression)], line), ("return", line).
"""
import dataclasses
import re

ST, SCL = "ST", "SCL"
TOKEN = re.compile(r"""(?P<space>\s+|\(\*.*?\*\))|(?P<time>T\#\d+MS)|(?P<local>\#?[A-Za-z_][A-Za-z0-9_]*)|(?P<quoted>"[A-Za-z_][A-Za-z0-9_]*")
    |(?P<place>%IW\d+)|(?P<text>'[^'\n]*')|(?P<number>16\#[0-9A-F]+|\d+\.\d+|\d+(?!\.\d))|(?P<dots>\.\.)|(?P<sign>:=|=>|<>|<=|>=|[-+*/=<>()\[\]{}:;,.])""",
                   re.VERBOSE | re.DOTALL)
WORDS = {"FUNCTION_BLOCK", "END_FUNCTION_BLOCK", "PROGRAM", "END_PROGRAM", "AT", "VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_TEMP", "CONSTANT", "END_VAR", "BEGIN",
         "VERSION", "IF", "THEN", "ELSIF", "ELSE", "END_IF", "RETURN", "AND", "OR", "XOR", "NOT", "MOD", "ARRAY", "OF",
         "TRUE", "FALSE"}
# What comes first binds least.
LEVELS = (("OR",), ("XOR",), ("AND",), ("=", "<>"), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/", "MOD"))
SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR", "VAR_TEMP", "VAR CONSTANT")


class SyntaxProblem(Exception):
    pass


@dataclasses.dataclass
class Variable:
    name: str
    kind: str          # elementary type, type of an instance, or of an array's elements
    section: str
    initial: tuple | None
    last: int | None   # of an array's places, which begin at 0
    line: int


@dataclasses.dataclass
class Block:
    name: str
    variables: dict
    statements: list
    program: bool      # not a function block: what it writes, others may read


def tokens(text):
    """Kind, text and line of each; spaces and comments are left out."""
    found, place, line = [], 0, 1
    while place < len(text):
        match = TOKEN.match(text, place)
        if not match:
            raise SyntaxProblem(f"line {line}: {text[place:place + 10]!r} begins nothing that is known")
        kind, piece = match.lastgroup, match[0]
        if kind != "space":
            found.append(("word" if piece in WORDS else kind, piece, line))
        elif piece.startswith("(*") and "(*" in piece[2:]:
            raise SyntaxProblem(f"line {line}: a comment within a comment, which not every control takes")
        line += piece.count("\n")
        place = match.end()
    return found + [("end", "end of file", line)]


class Parser:
    def __init__(self, text, dialect):
        self.tokens, self.place, self.dialect = tokens(text), 0, dialect

    def problem(self, wanted):
        kind, text, line = self.tokens[self.place]
        raise SyntaxProblem(f"line {line}: {text}, expected {wanted}")

    def line(self):
        return self.tokens[self.place][2]

    def at(self, *texts):
        return self.tokens[self.place][1] in texts and self.tokens[self.place][0] in ("word", "sign", "dots")

    def take(self, *texts):
        if not self.at(*texts):
            self.problem(" or ".join(texts))
        self.place += 1
        return self.tokens[self.place - 1][1]

    def take_kind(self, kind, wanted):
        if self.tokens[self.place][0] != kind:
            self.problem(wanted)
        self.place += 1
        return self.tokens[self.place - 1][1]

    def take_name(self):
        """A plain name, as in declarations."""
        name = self.take_kind("local", "a name")
        if name.startswith("#"):
            raise SyntaxProblem(f"line {self.line()}: {name} is declared with #")
        return name

    def take_local(self):
        """The name of a variable as statements write it: with # in SCL, without in structured text."""
        name = self.take_kind("local", "a variable")
        if name.startswith("#") != (self.dialect == SCL):
            raise SyntaxProblem(f"line {self.line()}: {name}, in {self.dialect} a variable stands "
                                f"{'behind #' if self.dialect == SCL else 'without #'}")
        return name.lstrip("#")

    def blocks(self):
        found = []
        while self.tokens[self.place][0] != "end":
            found.append(self.block())
        return found

    def block(self):
        end = "END_" + self.take("FUNCTION_BLOCK", *(["PROGRAM"] if self.dialect == ST else []))
        if self.dialect == SCL:
            name = self.take_kind("quoted", "a name in quotes").strip('"')
            self.attributes()
        else:
            name = self.take_name()
        variables = {}
        while self.at("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_TEMP"):
            self.section(variables)
        if self.dialect == SCL:
            self.take("BEGIN")
        statements = self.statements(end)
        self.take(end)
        return Block(name, variables, statements, end == "END_PROGRAM")

    def attributes(self):
        """{ S7_Optimized_Access := 'TRUE' } and VERSION : 0.1"""
        self.take("{")
        self.take_name()
        self.take(":=")
        self.take_kind("text", "a text in single quotes")
        self.take("}")
        self.take("VERSION")
        self.take(":")
        self.take_kind("number", "a number")

    def section(self, variables):
        section = self.take("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_TEMP")
        if section == "VAR" and self.at("CONSTANT"):
            section += " " + self.take("CONSTANT")
        while not self.at("END_VAR"):
            line, name = self.line(), self.take_name()
            if name.lower() in (known.lower() for known in variables):
                raise SyntaxProblem(f"line {line}: {name} is declared twice; capitals make no other name")
            if self.dialect == ST and self.at("AT"):
                self.take("AT")
                self.take_kind("place", "a place of the inputs, %IW and a number")
            self.take(":")
            last = self.array()
            quoted = self.tokens[self.place][0] == "quoted"
            kind = self.take_kind("quoted", "") if quoted else self.take_name()
            initial = None
            if self.at(":="):
                self.take(":=")
                initial = self.unary()
            self.take(";")
            variables[name] = Variable(name, kind, section, initial, last, line)
        self.take("END_VAR")

    def array(self):
        if not self.at("ARRAY"):
            return None
        self.take("ARRAY")
        self.take("[")
        if self.take_kind("number", "0") != "0":
            self.problem("0")
        self.take("..")
        last = int(self.take_kind("number", "the last place"))
        self.take("]")
        self.take("OF")
        return last

    def statements(self, *ends):
        found = []
        while not self.at(*ends):
            found.append(self.statement())
        return found

    def statement(self):
        line = self.line()
        if self.at("IF"):
            return self.choice(line)
        if self.at("RETURN"):
            self.take("RETURN")
            self.take(";")
            return ("return", line)
        name = self.take_local()
        if self.at("("):
            call = ("instance", name, self.parameters(), line)
            self.take(";")
            return call
        target = ("name", name, line)
        self.take(":=")
        value = self.expression()
        self.take(";")
        return ("assign", target, value, line)

    def choice(self, line):
        branches, otherwise = [], []
        self.take("IF")
        while True:
            condition = self.expression()
            self.take("THEN")
            branches.append((condition, self.statements("ELSIF", "ELSE", "END_IF")))
            if not self.at("ELSIF"):
                break
            self.take("ELSIF")
        if self.at("ELSE"):
            self.take("ELSE")
            otherwise = self.statements("END_IF")
        self.take("END_IF")
        self.take(";")
        return ("if", branches, otherwise, line)

    def parameters(self):
        found = []
        self.take("(")
        while True:
            name = self.take_name()
            found.append((name, self.take(":=", "=>"), self.expression()))
            if not self.at(","):
                break
            self.take(",")
        self.take(")")
        return found

    def expression(self, level=0):
        if level == len(LEVELS):
            return self.unary()
        left = self.expression(level + 1)
        while self.at(*LEVELS[level]):
            line, operator = self.line(), self.take(*LEVELS[level])
            left = ("binary", operator, left, self.expression(level + 1), line)
        return left

    def unary(self):
        line = self.line()
        if self.at("NOT", "-"):
            return ("unary", self.take("NOT", "-"), self.unary(), line)
        return self.primary()

    def primary(self):
        line = self.line()
        kind, text, _ = self.tokens[self.place]
        if self.at("("):
            self.take("(")
            inner = self.expression()
            self.take(")")
            return inner
        if kind in ("number", "text", "time") or self.at("TRUE", "FALSE"):
            self.place += 1
            return (kind if kind in ("text", "time") else "number", text, line)
        if kind == "local" and self.tokens[self.place + 1][1] == "(":
            function = self.take_name()
            self.take("(")
            argument = self.expression()
            self.take(")")
            return ("call", function, argument, line)
        name = self.take_local()
        if self.at("["):
            self.take("[")
            place = self.expression()
            self.take("]")
            return ("index", name, place, line)
        if self.at("."):
            self.take(".")
            return ("member", name, self.take_name(), line)
        return ("name", name, line)


def read_blocks(text, dialect):
    return Parser(text, dialect).blocks()
