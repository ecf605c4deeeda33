"""Rows of a benchmark that are kept in a CSV as they come, so that what was measured is not measured again."""

import csv


def read(table):
    """Returns the rows of a file, each by column; none where there is no file."""
    if not table.exists():
        return []
    with table.open(newline="") as file:
        return list(csv.DictReader(file))


def write(table, columns, rows):
    """Writes all rows."""
    with table.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
