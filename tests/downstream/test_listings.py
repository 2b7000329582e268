# SPDX-License-Identifier: MIT OR Apache-2.0
"""Every program in the pages of the documentation, compiled and run as a reader would, against the installed prefix.

A block in one of the languages below is a whole program; those in Python go on from the block before on the same page.
A block of text after it is what it prints. Lines that begin with "traction" are those of one small history, known from
Masing's rules. MEPC_PREFIX: the prefix; MEPC_CRATE: the unpacked Rust crate; MEPC_TARGET: where cargo builds.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PREFIX = Path(os.environ["MEPC_PREFIX"])
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "hosts").glob("*/README.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LANGUAGES = ("c", "cpp", "fortran", "rust", "python")
SHOWN = ("text", "sh", "console", "toml", "json", "csv")


def f(s):
    return 1 - (1 - s) ** 2.5


TRACTIONS = [30 * f(0.5), 30 * (f(0.5) - 2 * f(0.375)), 30 * (f(0.5) - 2 * f(0.375) + 2 * f(0.125))]


def listings():
    """Page, number, language, program (for Python: with those before), what it prints (None: not said)."""
    for page in PAGES:
        blocks = BLOCK.findall(page.read_text())
        before = ""
        for number, (language, code) in enumerate(blocks):
            assert language in LANGUAGES + SHOWN, f"{page}: a block in {language}"
            if language not in LANGUAGES:
                continue
            after = blocks[number + 1] if number + 1 < len(blocks) else (None, None)
            said = after[1] if after[0] == "text" else None
            yield pytest.param(language, before if language == "python" else "", code, said,
                               id=f"{page.relative_to(ROOT)}-{number}-{language}")
            if language == "python":
                before += code


def build(language, code, folder):
    """The command that runs the program."""
    include, lib = PREFIX / "include", PREFIX / "lib"
    link = [f"-I{include}", f"-L{lib}", "-lmepc", f"-Wl,-rpath,{lib}"]
    program = folder / "program"
    if language == "python":
        (folder / "program.py").write_text(code)
        return [sys.executable, "program.py"]
    if language == "rust":
        (folder / "src").mkdir()
        (folder / "src/main.rs").write_text(code)
        (folder / "Cargo.toml").write_text(
            '[package]\nname = "listing"\nversion = "0.1.0"\nedition = "2024"\n[workspace]\n'
            f'[dependencies]\nmepc = {{ path = "{os.environ["MEPC_CRATE"]}" }}\n')
        (folder / "Cargo.lock").write_bytes((ROOT / "Cargo.lock").read_bytes())
        return ["cargo", "run", "--quiet", "--target-dir", os.environ["MEPC_TARGET"]]
    source = folder / {"c": "program.c", "cpp": "program.cpp", "fortran": "program.f90"}[language]
    source.write_text(code)
    command = {
        "c": ["cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", source],
        "cpp": ["c++", "-std=c++17", "-Wall", "-Wextra", "-Werror", source],
        "fortran": ["gfortran", "-std=f2018", "-Wall", include / "mepc.f90", source],
    }[language]
    done = subprocess.run([*command, *link, "-o", program], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [program]


@pytest.mark.parametrize("language, before, code, said", list(listings()))
def test_listing(language, before, code, said, tmp_path):
    # What the blocks before print has been looked at with them.
    mark = "--- this block ---\n"
    whole = before + f"print({mark[:-1]!r})\n" + code if before else code
    run = subprocess.run(build(language, whole, tmp_path), cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    printed = run.stdout.split(mark)[-1]
    if said is not None:
        assert printed.split() == said.split()
    tractions = [float(line.split()[1]) for line in printed.splitlines() if line.startswith("traction")]
    if tractions:
        assert tractions == pytest.approx(TRACTIONS, abs=1e-5)


def test_the_languages_are_all_there():
    found = {parameter.values[0] for parameter in listings()}
    assert found == set(LANGUAGES)
