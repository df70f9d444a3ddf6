#!/usr/bin/env python3
"""Numbers of two architectures side by side.

compare.py LIMIT A.csv B.csv: the largest difference, and 1 as exit code where a number of B differs from that of A by
more than LIMIT, absolute for numbers up to 1 (K, um, W and so on, as the columns say), relative for larger ones.
"""
import csv
import math
import sys


def difference(a, b):
    if a == b or (math.isnan(a) and math.isnan(b)):
        return 0.0
    return abs(a - b) / max(1.0, abs(a)) if math.isfinite(a) and math.isfinite(b) else math.inf


def worst_of(one, other):
    """(difference, column, row), of how many numbers."""
    with open(one, newline="") as a, open(other, newline="") as b:
        rows, others = list(csv.reader(a)), list(csv.reader(b))
    if rows[0] != others[0] or len(rows) != len(others) or len(rows) < 2:
        sys.exit(f"compare.py: {one} and {other}: not the same table, or an empty one")
    worst, count = (0.0, "-", 0), 0
    for number, (row, also) in enumerate(zip(rows[1:], others[1:]), 1):
        if not len(row) == len(also) == len(rows[0]):
            sys.exit(f"compare.py: row {number} of {one} and {other}: not one number for each column")
        count += len(row)
        for column, a, b in zip(rows[0], row, also):
            worst = max(worst, (difference(float(a), float(b)), column, number), key=lambda each: each[0])
    return worst, count


if __name__ == "__main__":
    limit = float(sys.argv[1])
    (largest, column, row), count = worst_of(*sys.argv[2:])
    print(f"{count} numbers, largest difference {largest:.2g} ({column}, row {row})")
    sys.exit(1 if largest > limit else 0)
