"""Rows of the table: our time beside another one, both measured in the run whose name the row carries."""
import dataclasses
import json
import math

KINDS = {"peer": "another way to the same result", "bound": "the bare operation that it stands on"}
UNITS = {"s": ("processor", "wall"), "B": ("resident",)}  # which seconds, which bytes
TEXTS = ("run", "group", "name", "kind", "other_name")


class RowError(Exception):
    pass


@dataclasses.dataclass(frozen=True)
class Row:
    run: str
    group: str
    name: str
    kind: str
    other_name: str
    ours: float | None = None    # in the unit
    other: float | None = None
    unit: str = "s"
    clock: str = "processor"
    means: str = ""
    detail: bool = False         # part of another row or between two: in the table, without a bar
    goal: float | None = None    # of the ratio, at the most
    not_measured: str = ""       # why there are no times

    @property
    def ratio(self):
        """Ours / other: below 1 we are quicker. None where nothing was measured."""
        return None if self.not_measured else self.ours / self.other


def _check(fields, place):
    """Raises RowError naming place, field and what is allowed."""
    def allow(name, is_allowed, allowed):
        if not is_allowed(fields.get(name)):
            raise RowError(f"{place}: '{name}' is {json.dumps(fields.get(name))}, must be {allowed}")

    known = {field.name for field in dataclasses.fields(Row)}
    unknown = sorted(set(fields) - known)
    if unknown:
        raise RowError(f"{place}: unknown field '{unknown[0]}'; known are {', '.join(sorted(known))}")
    needed = TEXTS if fields.get("not_measured") else (*TEXTS, "ours", "other", "unit", "clock")
    missing = [name for name in needed if name not in fields]
    if missing:
        raise RowError(f"{place}: {', '.join(missing)} missing")
    for name in TEXTS:
        allow(name, lambda value: isinstance(value, str) and value, "a text that is not empty")
    for name in ("means", "not_measured"):
        allow(name, lambda value: value is None or isinstance(value, str), "a text")
    allow("kind", KINDS.__contains__, " or ".join(KINDS))
    allow("detail", lambda value: value in (None, True, False), "true or false")
    if not fields.get("not_measured"):
        allow("unit", UNITS.__contains__, " or ".join(UNITS))
        clocks = UNITS[fields["unit"]]
        allow("clock", clocks.__contains__, " or ".join(clocks))
    for name in ("ours", "other", "goal"):
        if name in needed or fields.get(name) is not None:
            allow(name, _is_positive, "a finite number above 0")


def _is_positive(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value) and value > 0


def read_row(fields, run, place):
    """The row of these fields. Raises RowError where they are no row, or one of another run than `run`."""
    if not isinstance(fields, dict):
        raise RowError(f"{place}: must be a JSON object")
    _check(fields, place)
    if fields["run"] != run:
        raise RowError(f"{place}: 'run' is '{fields['run']}', must be '{run}': a row of another run is no measurement of this")
    return Row(**fields)


def read_rows(text, run, source):
    """The rows of a producer's output, a JSON object each line; `source` names it in errors."""
    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        place = f"{source}, line {number}"
        try:
            fields = json.loads(line)
        except json.JSONDecodeError as error:
            raise RowError(f"{place}: no JSON: {error.msg}") from None
        rows.append(read_row(fields, run, place))
    if not rows:
        raise RowError(f"{source}: gave no rows")
    return rows
