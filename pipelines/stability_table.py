#!/usr/bin/python3
"""The table of extremes: the program's rows as they are, and in Markdown kernel by kernel."""

import collections
import shutil

import records

COLUMNS = ["case", "method", "precision", "error", "bound", "theory", "outcome"]
TEXT = """\
# Numerical stability at the extremes

Each row is one extreme of one kernel, held against long double or a closed form: the error that was met (relative where
the bound is), the bound that theory gives and where that is from, and whether it is kept. A row stands for the worst of
many cases, judged by error over bound. What cannot be right is refused, with the line that a user sees. Made by
`tests/stability`; the tests `stability.KERNEL` are red when a row is not kept.

{kept} rows are kept, {refused} refused, {broken} not kept.
"""


def main():
    arguments = records.table_arguments(__doc__, "rows", folder=True)
    rows = records.read_csv(arguments.rows)
    arguments.output.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(arguments.rows, arguments.output / "table.csv")
    count = collections.Counter(row["outcome"].split(":")[0] for row in rows)
    text = TEXT.format(kept=count["kept"], refused=count["refused"], broken=count["NOT KEPT"])
    for kernel in dict.fromkeys(row["kernel"] for row in rows):
        text += f"\n## {kernel}\n\n| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}\n"
        for row in rows:
            if row["kernel"] == kernel:
                text += "| " + " | ".join(row[column].replace("|", "\\|") for column in COLUMNS) + " |\n"
    (arguments.output / "table.md").write_text(text)


if __name__ == "__main__":
    main()
