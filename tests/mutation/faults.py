"""Faults of one token: where they are, in which order they are drawn, and those that change nothing."""
import pathlib
import random
import re

CHANGES_NOTHING = pathlib.Path(__file__).resolve().parent / "changes_nothing"

# One token for another. Operators of two operands stand between blanks, as clang-format leaves them; brackets of
# templates and signs do not.
SWAPS = {" < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " == ": " != ", " != ": " == ", " + ": " - ", " - ": " + ",
         " * ": " / ", " / ": " * ", " && ": " || ", " || ": " && ", " += ": " -= ", " -= ": " += ", "true": "false",
         "false": "true", "std::min(": "std::max(", "std::max(": "std::min("}
NUMBER = r"(?<![\w.'])\d+(?:\.\d*)?(?:e[+-]?\d+)?(?![\w.'])"  # no piece of 1'000
TOKEN = re.compile("|".join(r"\b" + swap + r"\b" if swap.isalpha() else re.escape(swap) for swap in SWAPS) + "|" + NUMBER)
OPAQUE = re.compile(r"""//.*|"(?:\\.|[^"\\])*"|(?<!\d)'(?:\\.|[^'\\])*'""")  # comments, texts, characters
NO_CODE = re.compile(r"\s*(#|///?|static_assert\b|using\b|template\b|inline constexpr struct\b)")


def other(token):
    if token in SWAPS:
        return SWAPS[token]
    if re.fullmatch(r"\d+", token):
        return str(int(token) + 1)
    return "1.0" if float(token) == 0.0 else repr(2.0 * float(token))


def code_of(line):
    """A line with its comments, texts and characters hidden, each letter by one."""
    return OPAQUE.sub(lambda hidden: "\0" * len(hidden.group()), line)


def sites(path):
    """(line, first column, token) of every token that a fault may change."""
    for number, line in enumerate(path.read_text().splitlines()):
        if NO_CODE.match(line):
            continue
        for found in TOKEN.finditer(code_of(line)):
            yield number, found.start(), found.group()


def draw(tree, room, seed):
    """All faults of a room, each once, as (file, line, column, token), in an order that only tree and seed decide."""
    files = [path for path in (tree / room).rglob("*.[ch]pp") if path.is_file()]
    faults = [(path.relative_to(tree).as_posix(), *site) for path in sorted(files) for site in sites(path)]
    random.Random(f"{room} {seed}").shuffle(faults)
    return faults


def put(tree, fault):
    """Makes the fault in a copy of the sources."""
    name, line, column, token = fault
    lines = (tree / name).read_bytes().decode().splitlines(keepends=True)
    lines[line] = lines[line][:column] + other(token) + lines[line][column + len(token):]
    (tree / name).write_text("".join(lines))


def words(tree, fault):
    name, line, _, token = fault
    text = (tree / name).read_text().splitlines()[line].strip()
    return f"{name}:{line + 1}: {token.strip()} becomes {other(token).strip()} in: {text}"


def without_line_number(fault_in_words):
    return re.sub(r":\d+: ", ": ", fault_in_words, count=1)


def that_change_nothing():
    """Reasons by fault, without its line's number: a line with the fault, then one that is indented with the reason."""
    reasons = {}
    for line in CHANGES_NOTHING.read_text().splitlines():
        if line.startswith("#") or not line.strip():
            continue
        if line.startswith(" "):
            reasons[fault] = (reasons[fault] + " " + line.strip()).strip()
        else:
            fault = line.strip()
            reasons[fault] = ""
    unexplained = [fault for fault, reason in reasons.items() if not reason]
    if unexplained:
        raise SystemExit(f"{CHANGES_NOTHING}: no reason below: {unexplained[0]}")
    return reasons
