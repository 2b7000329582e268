#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Fills the tables of docs/paper.md from the studies' results, and renders the page.

report.py           tables between `<!-- table: NAME -->` and `<!-- end -->` anew; build/studies/paper.html, with its
                    pictures inside
report.py --check   changes nothing; exit code 1 if a table differs from the results or a file linked to is missing
                    (pictures are not compared)"""

import argparse
import base64
import csv
import json
import math
import mimetypes
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
JOINT, SLIDER = ROOT / "studies/lap_joint", ROOT / "studies/flat_slider"
PAGE, HTML = ROOT / "docs/paper.md", ROOT / "build/studies/paper.html"
import paper
import verdict

RESULTS = JOINT / "results"
MICRO = 1e3  # mm to um


# --- how things are written ---------------------------------------------------------------------------------------------


def table(head, lines):
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(str(cell) for cell in row) + " |" for row in rows)


def number(value, digits=4):
    """With so many significant digits, never in powers of ten."""
    if value == 0:
        return "0"
    size = math.floor(math.log10(abs(value))) + 1
    text = f"{value:.{max(0, digits - size)}f}"
    return text[:-3] if text.endswith(".00") else text


def signed(value, unit=" %"):
    """A difference, with the digits that mean something."""
    if abs(value) < 0.005:
        return f"0{unit}"
    return f"{value:+.{2 if abs(value) < 0.995 else 1}f}{unit}"


def compared(theirs, ours, digits=4):
    """Paper / mepc / difference."""
    return f"{number(theirs, digits)} / {number(ours, digits)} / {signed(100 * (ours / theirs - 1))}"


def compared_kappa(theirs, ours):
    return f"{theirs:.2f} / {ours:.2f} / {ours - theirs:+.2f}"


UNITS = {
    "k_alpha_N_per_mm": "k_alpha (N/mm)",
    "F_s_N": "F_s (N)",
    "X_s_mm": "X_s (mm)",
    "kappa": "kappa",
    "dissipation_Nmm": "dissipation (N mm)",
    "first_slope_N_per_mm": "stick stiffness (N/mm)",
    "F_max_N": "largest force (N)",
}


# --- the tables -----------------------------------------------------------------------------------------------------------


def bounds():
    lines = []
    for check, count in verdict.worst_of(verdict.all_checks()):
        record = verdict.record(check)
        difference = f"{check.difference:+.2f} %" if record["difference_percent"] else ""
        bound = f"{check.limit:g} %" if check.limit else ""
        lines.append(
            [check.bound, count, check.state, record["paper"], record["mepc"], difference, bound, check.verdict]
        )
    return table(["bound", "comparisons", "worst", "paper", "mepc", "difference", "bound", "verdict"], lines)


def calibrated():
    source = (JOINT / "geometry.py").read_text() + (JOINT / "joint.py").read_text()

    def value(name):
        return re.search(rf"^    {name}: float = ([\d.e+-]+)", source, re.M)[1]

    row, (k_alpha, _, X_s, _) = verdict.by_case("identified")[verdict.REFERENCE], paper.PRELOAD[900]
    return table(
        ["what is set", "value", "decides", "at the reference state: paper / mepc / difference"],
        [
            [
                "free length of the plates",
                f"{float(value('free')):g} mm",
                "series stiffness K_e; seen in X_s (µm)",
                compared(MICRO * X_s, MICRO * row["X_s_mm"]),
            ],
            [
                "height of the force washer (grip)",
                f"{float(value('washer_height')):g} mm",
                "residual stiffness k_alpha (N/mm)",
                compared(k_alpha, row["k_alpha_N_per_mm"]),
            ],
            [
                "elastic slip gcr (taken, not fitted)",
                f"{MICRO * float(value('gcr')):g} µm",
                "intercept of X_s over mu P",
                "see below",
            ],
        ],
    )


def papers_table(sweep, label):
    theirs, ours = verdict.sweeps(verdict.by_case("identified"))[sweep]
    lines = []
    for state, row in ours.items():
        k_alpha, F_s, X_s, kappa = theirs[state]
        lines.append(
            [
                f"{MICRO * state if sweep == 'A' else state:g}",
                compared(k_alpha, row["k_alpha_N_per_mm"]),
                compared(F_s, row["F_s_N"]),
                compared(MICRO * X_s, MICRO * row["X_s_mm"], 3),
                compared_kappa(kappa, row["kappa"]),
                compared(verdict.papers_loss(sweep, state), row["dissipation_Nmm"]),
                row["flag"],
            ]
        )
    return table([label, "k_alpha (N/mm)", "F_s (N)", "X_s (µm)", "kappa", "dissipation (N mm)", "note"], lines)


def contradiction():
    _, ours = verdict.sweeps(verdict.by_case("identified"))["mu"]
    lines = []
    for mu, row in ours.items():
        limit, theirs = mu * 900, paper.FRICTION[mu][1]
        again = next((f"{paper.PRELOAD[P][1]:g}" for P in paper.PRELOAD if mu == 0.3 and P == 900), "")
        lines.append(
            [
                mu,
                f"{limit:g}",
                f"{theirs:g}",
                again,
                f"{theirs / limit:.3f}",
                f"{row['F_s_N']:.2f}",
                f"{row['F_s_N'] / limit:.3f}",
            ]
        )
    return table(
        ["mu", "mu P (N)", "F_s, Table 3 (N)", "F_s, Table 2, same state", "Table 3 / mu P", "mepc (N)", "mepc / mu P"],
        lines,
    )


def preload_ratio():
    cases = verdict.by_case("identified")
    (_, ours), (_, K_e) = verdict.sweeps(cases)["P"], verdict.regression(cases)
    return table(
        ["P (N)", *(f"{P:g}" for P in ours)],
        [
            ["F_s / mu P, Table 2", *(f"{paper.PRELOAD[P][1] / (0.3 * P):.3f}" for P in ours)],
            ["F_s / mu P, mepc", *(f"{row['F_s_N'] / (0.3 * P):.3f}" for P, row in ours.items())],
            ["1 - k_alpha/K_e, mepc", *(f"{1 - row['k_alpha_N_per_mm'] / K_e:.3f}" for row in ours.values())],
        ],
    )


def regression():
    theirs, ours = paper.regression(), verdict.regression(verdict.by_case("identified"))

    def line(name, pair):
        return [name, f"{MICRO * pair[0]:.2f}", f"{pair[1] / 1e3:.1f}"]

    return table(
        ["X_s = gcr + mu P / K_e", "gcr (µm)", "K_e (kN/mm)"],
        [
            line("paper, Tables 2 and 3", theirs),
            line("mepc, the same states without P = 300", ours),
            ["difference", *(signed(100 * (our / their - 1)) for their, our in zip(theirs, ours))],
        ],
    )


def trends():
    sweeps = verdict.sweeps(verdict.by_case("identified"))
    lines = []
    for name, start, end, text in (
        ("P", 1100, 500, "P from 1100 to 500 N"),
        ("P", 1100, 300, "P from 1100 to 300 N"),
        ("mu", 0.5, 0.1, "mu from .5 to .1"),
        ("A", 0.025, 0.01, "A from 25 to 10 µm"),
    ):
        theirs, ours = sweeps[name]
        cells = []
        for place, quantity in enumerate(verdict.QUANTITIES):
            their = 100 * (theirs[end][place] / theirs[start][place] - 1)
            our = 100 * (ours[end][quantity] / ours[start][quantity] - 1)
            cells.append(f"{signed(their)} / {signed(our)}")
        lines.append([text, *cells])
    return table(["change (paper / mepc)", "k_alpha", "F_s", "X_s", "kappa (of its size)"], lines)


def exponents():
    """Also of a patch of the law behind a spring, by its first slope and X_s: docs/verification.md has both forms."""
    sweeps, chi = verdict.sweeps(verdict.by_case("identified")), 2.5
    gcr, K_e = paper.regression()
    lines = []
    for name, per in (("P", 0.3), ("mu", 900)):
        theirs, ours = sweeps[name]
        for state, row in ours.items():
            way = per * state / K_e
            lines.append(
                [
                    f"{name} = {state:g}",
                    f"{per * state:g}",
                    f"{theirs[state][3]:.2f}",
                    f"{row['kappa']:.2f}",
                    f"{(gcr + way) / (gcr / chi + way) - 2.5:.2f}",
                ]
            )
    return table(["state", "mu P (N)", "kappa, paper", "kappa, mepc", "patch behind a spring"], lines)


def procedures():
    squares, theirs = verdict.by_case("identified"), verdict.by_case("identified_paper_procedure")
    lines = []
    for case, row in squares.items():
        other = theirs[case]
        lines.append(
            [
                case,
                f"{row['k_alpha_N_per_mm']:.0f} / {other['k_alpha_N_per_mm']:.0f}",
                f"{row['F_s_N']:.1f} / {other['F_s_N']:.1f}",
                f"{MICRO * row['X_s_mm']:.2f} / {MICRO * other['X_s_mm']:.2f}",
                f"{row['kappa']:.2f} / {other['kappa']:.2f}",
            ]
        )
    return table(["least squares / paper's procedure", "k_alpha (N/mm)", "F_s (N)", "X_s (µm)", "kappa"], lines)


def stick():
    more = verdict.by_case("cases_more")
    return table(
        [
            "case",
            "stick stiffness, first increment (kN/mm)",
            "(5/2 + kappa) F_s / X_s + k_alpha (kN/mm)",
            "bolt force in the loop (N)",
            "area of the loop / energy the law reports (N mm)",
        ],
        [
            [
                case,
                f"{row['first_slope_N_per_mm'] / 1e3:.1f}",
                f"{row['k_t_N_per_mm'] / 1e3:.1f}",
                f"{row['bolt_min_N']:.1f} .. {row['bolt_max_N']:.1f}",
                f"{row['dissipation_Nmm']:.3f} / {row['library_dissipation_Nmm']:.3f}",
            ]
            for case, row in more.items()
        ],
    )


def methods():
    runs = verdict.rows("methods")
    lines = []
    for row in runs:
        middle = next(other for other in runs if other["method"] == "memory" and other["preload_N"] == row["preload_N"])
        limit = row["mu"] * row["preload_N"]
        lines.append(
            [
                f"{row['preload_N']:g}",
                row["mu"],
                row["method"],
                f"{row['F_s_N']:.2f}",
                f"{row['F_s_N'] / limit:.3f}",
                f"{row['first_slope_N_per_mm'] / 1e3:.1f}",
                signed(100 * (row["first_slope_N_per_mm"] / middle["first_slope_N_per_mm"] - 1)),
                f"{row['dissipation_Nmm']:.2f}",
                signed(100 * (row["dissipation_Nmm"] / middle["dissipation_Nmm"] - 1)),
            ]
        )
    return table(
        [
            "P (N)",
            "mu",
            "method",
            "F_s (N)",
            "F_s / mu P",
            "stick stiffness (kN/mm)",
            "from memory",
            "dissipation (N mm)",
            "from memory",
        ],
        lines,
    )


def blind():
    lines = []
    for row in verdict.rows("blind"):
        kappa = row["quantity"] == "kappa"
        difference = f"{row['run'] - row['predicted']:+.2f}" if kappa else signed(row["difference_percent"])
        lines.append([UNITS[row["quantity"]], number(row["predicted"]), number(row["run"]), difference])
    return table(["quantity", "predicted from the paper's tables", "run", "difference"], lines)


def differences(rows, base, labels):
    """The base in its units, the others in per cent of it; kappa as a difference."""
    lines = []
    for label, row in zip(labels, rows):
        if row is base:
            lines.append([*label, *(number(row[key]) for key in UNITS)])
        else:
            lines.append(
                [
                    *label,
                    *(
                        f"{row[key] - base[key]:+.2f}" if key == "kappa" else signed(100 * (row[key] / base[key] - 1))
                        for key in UNITS
                    ),
                ]
            )
    return lines


def convergence():
    runs = verdict.rows("convergence")
    grids = [row for row in runs if row["increments"] == 80]
    steps = sorted((row for row in runs if row["mesh"] == "study"), key=lambda row: row["increments"])
    lines = differences(grids, grids[-1], [[row["mesh"], f"{row['nodes']:.0f}", "80"] for row in grids])
    lines += differences(
        steps, steps[-1], [["study", f"{row['nodes']:.0f}", f"{row['increments']:.0f}"] for row in steps]
    )
    return table(["mesh", "nodes", "increments", *UNITS.values()], lines)


def sensitivity():
    runs, cases = verdict.rows("sensitivity"), verdict.by_case("cases_more")
    base = next(row for row in runs if row["case"] == "reference")
    lines = []
    for row in runs:
        of = base if row["preload_N"] == base["preload_N"] else cases[f"P{row['preload_N']:g}"]
        lines += differences([row], of, [[row["case"]]])
    return table(["change", *UNITS.values()], lines)


def paper_size():
    file = RESULTS / "paper_size.csv"
    if not file.exists():
        return "Not finished yet; `make study-paper-size` runs it."
    row, study = verdict.rows("paper_size")[0], verdict.by_case("identified")[verdict.REFERENCE]
    k_alpha, F_s, X_s, kappa = paper.PRELOAD[900]
    made = json.loads((RESULTS / "provenance.json").read_text())
    nodes, elements = made["cases"]["nodes"], made["cases"]["elements"]
    return table(
        ["", "paper", f"mepc, {row['nodes']:.0f} nodes", f"mepc, {nodes} nodes"],
        [
            ["nodes / elements", "138730 / 124748", f"{row['nodes']:.0f} / {row['elements']:.0f}", f"{nodes} / {elements}"],
            ["k_alpha (N/mm)", k_alpha, f"{row['k_alpha']:.1f}", f"{study['k_alpha_N_per_mm']:.1f}"],
            ["F_s (N)", F_s, f"{row['F_s']:.2f}", f"{study['F_s_N']:.2f}"],
            ["X_s (µm)", f"{MICRO * X_s:.2f}", f"{MICRO * row['X_s']:.2f}", f"{MICRO * study['X_s_mm']:.2f}"],
            ["kappa", kappa, f"{row['kappa']:.3f}", f"{study['kappa']:.3f}"],
            [
                "dissipation (N mm)",
                f"{verdict.papers_loss('P', 900):.2f}",
                f"{row['dissipation_Nmm']:.2f}",
                f"{study['dissipation_Nmm']:.2f}",
            ],
            [
                "time to condense / for the loop (s)",
                "",
                f"{row['seconds_condensing']:.0f} / {row['seconds_loop']:.0f}",
                "",
            ],
            ["memory (GiB)", "", row["peak_GiB"], ""],
        ],
    )


def kratos():
    result = json.loads((RESULTS / "kratos/result.json").read_text())
    size = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in result["size"].items())
    names = {
        "force": "force, anywhere in the loop, over F_s",
        "bolt_force": "force in the bolt, over P",
        "preload": "preload",
        "area": "area of the loop",
    }
    lines = [
        [names.get(name, name), f"{value:.1e}", f"{result['bound']:g}", "ok" if value <= result["bound"] else "BROKEN"]
        for name, value in result["differences"].items()
    ]
    lines += [
        [f"for scale: {name}, force over F_s", f"{value:.2f}", "", ""]
        for name, value in result["differences_for_scale"].items()
    ]
    return f"{size}.\n\n" + table(["difference of the two codes", "seen", "bound", "verdict"], lines)


def flat_slider():
    file = SLIDER / "results/summary.csv"
    if not file.exists():
        return "No results yet."
    with file.open() as source:
        runs = [{key: verdict.number(value) for key, value in row.items()} for row in csv.DictReader(source)]
    finest = max(row["elements"] for row in runs)
    runs = [row for row in runs if row["elements"] == finest]
    return table(
        [
            "method",
            "plateau + / -, over mu N",
            "stick stiffness of the contact (kN/mm)",
            "the same at the driven side (kN/mm)",
            "slip amplitude (µm)",
            "area of the loop (N mm)",
        ],
        [
            [
                row["method"],
                f"{row['plateau_plus']:.5f} / {row['plateau_minus']:.5f}",
                number(row["stick_slope"] / 1e3, 3),
                number(row["driven_stick_slope"] / 1e3, 3),
                number(MICRO * row["slip_amplitude"]),
                number(row["loop_area"]),
            ]
            for row in runs
        ],
    )


def made_with():
    kept = json.loads((RESULTS / "provenance.json").read_text())["cases"]
    return ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in kept.items()) + "."


TABLES = {
    "bounds": bounds,
    "calibrated": calibrated,
    "contradiction": contradiction,
    "preload-ratio": preload_ratio,
    "table-2": lambda: papers_table("P", "P (N)"),
    "table-3": lambda: papers_table("mu", "mu"),
    "table-4": lambda: papers_table("A", "A (µm)"),
    "regression": regression,
    "trends": trends,
    "procedures": procedures,
    "exponents": exponents,
    "stick": stick,
    "methods": methods,
    "blind": blind,
    "convergence": convergence,
    "sensitivity": sensitivity,
    "paper-size": paper_size,
    "kratos": kratos,
    "flat-slider": flat_slider,
    "made-with": made_with,
}


# --- the page -------------------------------------------------------------------------------------------------------------

MARKED = re.compile(r"(<!-- table: ([\w-]+) -->\n).*?(<!-- end -->)", re.S)
LINKED = re.compile(r"\]\((?!https?:|#|mailto:)([^)#\s]+)")
STYLE = """
body { font: 16px/1.5 sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; color: #222 }
table { border-collapse: collapse; margin: 1rem 0; font-size: 85%; font-variant-numeric: tabular-nums }
th, td { border: 1px solid #ccc; padding: .2rem .5rem; text-align: left }
th { background: #f2f2f2 } img { max-width: 100%; height: auto } code { background: #f2f2f2 }
"""


def filled(page):
    """The page with its tables made anew, and the names of those that differ."""
    differ = []

    def one(match):
        text = f"{match[1]}\n{TABLES[match[2]]()}\n\n{match[3]}"
        if text != match[0]:
            differ.append(match[2])
        return text

    return MARKED.sub(one, page), differ


def missing(page):
    return [link for link in LINKED.findall(page) if not (PAGE.parent / link).exists()]


def rendered(page):
    """One file that shows everything: pictures inside, other links relative to where it stands."""
    from markdown_it import MarkdownIt

    body = MarkdownIt("commonmark").enable("table").render(page)

    def source(match):
        file = (PAGE.parent / match[1]).resolve()
        kind = mimetypes.guess_type(file.name)[0]
        return f'src="data:{kind};base64,{base64.b64encode(file.read_bytes()).decode()}"'

    def target(match):
        if match[1].startswith(("http:", "https:", "#")):
            return match[0]
        return f'href="{Path("../..") / (PAGE.parent / match[1]).resolve().relative_to(ROOT)}"'

    body = re.sub(r'href="([^"]+)"', target, re.sub(r'src="([^"]+)"', source, body))

    def anchor(match):
        slug = re.sub(r"[^\w\s-]", "", match[2].lower()).replace(" ", "-")  # as GitHub makes them
        return f'<h{match[1]} id="{slug}">{match[2]}</h{match[1]}>'

    body = re.sub(r"<h(\d)>(.*?)</h\d>", anchor, body)
    title = re.search(r"^# (.*)", page, re.M)[1]
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style></head>\n'
        f"<body>\n{body}</body></html>\n"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    check = parser.parse_args().check
    page = PAGE.read_text()
    new, differ = filled(page)
    unused = TABLES.keys() - {match[2] for match in MARKED.finditer(page)}
    wrong = [f"tables not in {PAGE.name}: {', '.join(sorted(unused))}"] if unused else []
    wrong += [f"missing: {link}" for link in missing(new)]
    if check:
        wrong += [f"{PAGE.name}: table {name} differs from the results; run studies/report.py" for name in differ]
    else:
        PAGE.write_text(new)
        HTML.parent.mkdir(parents=True, exist_ok=True)
        HTML.write_text(rendered(new))
        print(f"{PAGE.relative_to(ROOT)}: {len(differ)} tables new; {HTML.relative_to(ROOT)}")
    if wrong:
        sys.exit("\n".join(wrong))


if __name__ == "__main__":
    main()
