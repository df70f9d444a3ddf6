"""The table as text, and what its numbers look like there and on the page."""
import math

SCALES = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
HEAD = ("", "ours", "other", "", "ours / other", "goal", "seconds")


def three_digits(value):
    """With the three digits that count: 0.0123, 1.23, 12.3, 1,230."""
    rounded = float(f"{value:.3g}")
    places = max(0, 2 - math.floor(math.log10(rounded)))
    return f"{rounded:,.{places}f}"


def time_text(time_s):
    scale, unit = next(((scale, unit) for scale, unit in SCALES if time_s >= 0.9995 * scale), SCALES[-1])
    return f"{three_digits(time_s / scale)} {unit}"


def ratio_text(ratio):
    """Below 1 as how many times as quick we are."""
    return f"{three_digits(ratio)} x as long" if ratio >= 1 else f"{three_digits(1 / ratio)} x as quick"


def goal_text(goal):
    if goal is None:
        return ""
    return f"≤ {three_digits(goal)} x as long" if goal > 1 else f"≥ {three_digits(1 / goal)} x as quick"


def cells(row):
    if row.not_measured:
        return (row.name, "", "", row.other_name, f"not measured: {row.not_measured}", goal_text(row.goal), "")
    return (row.name, time_text(row.ours), time_text(row.other), row.other_name, ratio_text(row.ratio), goal_text(row.goal),
            row.clock)


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
