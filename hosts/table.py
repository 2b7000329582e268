#!/usr/bin/env python3
"""What the hosts gave: `Results` collects it in one host's run, running this file prints the table of all hosts.

Each host writes build/hosts/HOST/row.json, an object of `rows`, `checks` and `skipped` (or a bare list of rows).
The exit code is 1 when a check is broken or a host is missing, 0 otherwise.
"""

import argparse
import json
import sys
from pathlib import Path

OUTPUT = Path(__file__).resolve().parents[1] / "build/hosts"
HOSTS = ("kratos", "opengeosys", "scikit_fem", "calculix")
OPTIONAL = ("calculix",)  # needs a program that has to be built


class Results:
    """Rows, checks and skips of one host."""

    def __init__(self, host):
        self.host = host
        self.rows, self.checks, self.skipped = [], [], []

    def row(self, element, *, steps, iterations, plateau, loop_area, seconds, difference=None, reference=""):
        """One run. `difference`: the largest one to the reference, over mu N; `reference`: what that is."""
        self.rows.append({
            "host": self.host, "element": element, "steps": steps, "iterations": iterations,
            "plateau_over_muN": plateau, "loop_area": loop_area, "difference": difference, "reference": reference,
            "seconds": seconds,
        })

    def check(self, what, value, bound):
        """Says whether `value` is at most `bound`, at once and in the table."""
        held = value <= bound  # false for NaN
        self.checks.append({"what": what, "value": value, "bound": bound, "held": bool(held)})
        print(f"  {'ok    ' if held else 'BROKEN'} {what}: {value:.3g} (at most {bound:g})", flush=True)

    def skip(self, what, why):
        self.skipped.append({"what": what, "why": why})
        print(f"  skipped {what}: {why}", flush=True)

    def write(self, directory):
        """Writes row.json; whether everything held."""
        text = json.dumps({"rows": self.rows, "checks": self.checks, "skipped": self.skipped}, indent=1)
        (directory / "row.json").write_text(text + "\n")
        return all(check["held"] for check in self.checks)


def number(value, form):
    return "-" if value is None else format(value, form)


def lines(rows):
    """The table as text."""
    table = [("host", "element", "steps", "iterations", "plateau/(mu N)", "loop area", "difference", "to", "seconds")]
    for row in rows:
        table.append((
            row["host"], row["element"], str(row["steps"]), str(row["iterations"]),
            number(row["plateau_over_muN"], ".6f"), number(row["loop_area"], ".5g"), number(row["difference"], ".1e"),
            row.get("reference", ""), number(row["seconds"], ".1f"),
        ))
    widths = [max(map(len, column)) for column in zip(*table)]
    left = (0, 1, 7)
    for line in table:
        cells = (c.ljust(w) if i in left else c.rjust(w) for i, (c, w) in enumerate(zip(line, widths)))
        yield "  ".join(cells).rstrip()


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--output", type=Path, default=OUTPUT, help="directory of the hosts' results")
    directory = options.parse_args().output
    rows, broken, skipped, checks = [], [], [], 0
    for host in HOSTS:
        file = directory / host / "row.json"
        if not file.exists():
            (skipped if host in OPTIONAL else broken).append(f"{host}: not run")
            continue
        content = json.loads(file.read_text())
        if isinstance(content, list):
            content = {"rows": content}
        rows += content["rows"]
        for check in content.get("checks", []):
            checks += 1
            if not check["held"]:
                broken.append(f"{host}: {check['what']}: {check['value']:.3g}, at most {check['bound']:g}")
        skipped += [f"{host}: {skip['what']}: {skip['why']}" for skip in content.get("skipped", [])]
    print("\n".join(lines(rows)))
    print(f"\n{checks} checks, {len(broken)} broken, {len(skipped)} skipped")
    for title, items in (("broken", broken), ("skipped", skipped)):
        for item in items:
            print(f"  {title}: {item}")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
