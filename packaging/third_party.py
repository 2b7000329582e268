"""Licences of the crates that are linked into the library and the tool, from their own packages, on standard output."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OURS = ("mepc", "mepc-cli")
HEAD = """Crates that are linked into libmepc and the tool mepc, with the licences that their packages carry. The Rust
standard library is linked in, too: MIT OR Apache-2.0, The Rust Project Contributors.
"""


def main():
    run = subprocess.run(
        ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", "x86_64-unknown-linux-gnu"],
        cwd=ROOT, stdout=subprocess.PIPE, check=True)
    metadata = json.loads(run.stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    todo = [name for name, package in packages.items() if package["name"] in OURS and package["source"] is None]
    linked = set(todo)
    while todo:
        for dependency in nodes[todo.pop()]["deps"]:
            # Not what only tests (dev) or build scripts (build) use.
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]) and dependency["pkg"] not in linked:
                linked.add(dependency["pkg"])
                todo.append(dependency["pkg"])
    print(HEAD)
    printed = {}  # text: the package that came with it first
    foreign = (packages[name] for name in linked if packages[name]["source"])
    for package in sorted(foreign, key=lambda package: (package["name"], package["version"])):
        folder = Path(package["manifest_path"]).parent
        texts = sorted(file for file in folder.iterdir()
                       if file.is_file() and file.name.upper().startswith(("LICEN", "COPYING", "UNLICENSE", "NOTICE")))
        if not package["license"] and not texts:
            sys.exit(f"third_party.py: {package['name']} {package['version']} names no licence")
        print("=" * 100)
        print(f"{package['name']} {package['version']}: {package['license']}")
        for file in texts:
            text = file.read_text(encoding="utf-8", errors="replace").strip()
            first = printed.setdefault(text, package["name"])
            print("-" * 40, file.name)
            print(text if first == package["name"] else f"The same text as above, with {first}.")


if __name__ == "__main__":
    main()
