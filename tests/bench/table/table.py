"""The table as text, and what its numbers look like there and on the page."""
import math

SCALES = {"s": ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns")), "B": ((1e9, "GB"), (1e6, "MB"), (1e3, "kB"))}
WORDS = {"s": ("as long", "as quick"), "B": ("as much", "as little")}  # ours above the other, and below
HEAD = ("", "ours", "other", "", "ours / other", "goal", "measured")


def three_digits(value):
    """With the three digits that count: 0.0123, 1.23, 12.3, 1,230."""
    rounded = float(f"{value:.3g}")
    places = max(0, 2 - math.floor(math.log10(rounded)))
    return f"{rounded:,.{places}f}"


def value_text(value, unit="s"):
    scales = SCALES[unit]
    scale, name = next(((scale, name) for scale, name in scales if value >= 0.9995 * scale), scales[-1])
    return f"{three_digits(value / scale)} {name}"


def ratio_text(ratio, unit="s"):
    """Below 1 as how many times as quick we are, or as little we take."""
    more, less = WORDS[unit]
    return f"{three_digits(ratio)} x {more}" if ratio >= 1 else f"{three_digits(1 / ratio)} x {less}"


def goal_text(goal, unit="s"):
    if goal is None:
        return ""
    more, less = WORDS[unit]
    return f"≤ {three_digits(goal)} x {more}" if goal > 1 else f"≥ {three_digits(1 / goal)} x {less}"


def cells(row):
    if row.not_measured:
        return (row.name, "", "", row.other_name, f"not measured: {row.not_measured}", goal_text(row.goal, row.unit),
                "")
    return (row.name, value_text(row.ours, row.unit), value_text(row.other, row.unit), row.other_name,
            ratio_text(row.ratio, row.unit), goal_text(row.goal, row.unit), row.clock)


def by_group(rows):
    """{group: its rows}, in the order in which they came."""
    groups = {}
    for row in rows:
        groups.setdefault(row.group, []).append(row)
    return groups


def text_table(rows):
    lines = [HEAD, *(cells(row) for row in rows)]
    # A reason may be longer than its column.
    widths = [max(len(line[column]) for line in lines if not line[column].startswith("not measured"))
              for column in range(len(HEAD))]
    to_right = (1, 2)

    def line_of(content):
        return "  " + "  ".join(text.rjust(width) if column in to_right else text.ljust(width)
                                for column, (text, width) in enumerate(zip(content, widths))).rstrip()

    text = [line_of(HEAD)]
    for group, members in by_group(rows).items():
        text += ["", group, *(line_of(cells(row)) for row in members)]
    return "\n".join(text) + "\n"
