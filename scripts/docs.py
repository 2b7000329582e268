"""The site: lays the pages of docs/SUMMARY.md and what they show into build/docs, runs mdBook, checks every link.

    scripts/docs.py MDBOOK        the program; the site is build/docs/html/index.html

Pages keep their places (docs/.., hosts/..), so that a link means the same on the site and in the repository. A link to
a directory is one to its README; other files that pages link to come along.
"""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build/docs"
SOURCE, SITE = BUILD / "src", BUILD / "html"
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
FENCE = re.compile(r"^(?:```|~~~)")


def pages():
    """The pages in the order of the summary, as paths in the repository."""
    summary = ROOT / "docs/SUMMARY.md"
    return [(summary.parent / target).resolve() for _, target, _ in LINK.findall(summary.read_text())]


def lay(page, known):
    """Copies a page, and what it links to; returns what is wrong with its links."""
    wrong = []

    def follow(match):
        before, target, after = match.groups()
        parts = urlsplit(target)
        if parts.scheme or not parts.path:
            return match.group()
        file = (page.parent / unquote(parts.path)).resolve()
        if file.is_dir():
            file, target = file / "README.md", f"{target.rstrip('/')}/README.md"
        if not file.is_relative_to(ROOT) or not file.is_file():
            wrong.append(f"{page.relative_to(ROOT)}: {target} is not there")
        elif file.suffix == ".md" and file not in known:
            wrong.append(f"{page.relative_to(ROOT)}: {target} is no page of docs/SUMMARY.md")
        elif file not in known:
            place(file, file.read_bytes())
        # mdBook writes a README as the index of its directory, and does not say so in links.
        return f"{before}{target.replace('README.md', 'index.md')}{after}"

    fenced, lines = False, []
    for line in page.read_text().splitlines(keepends=True):
        if FENCE.match(line.lstrip()):
            fenced = not fenced
        lines.append(line if fenced or line.startswith("    ") else LINK.sub(follow, line))
    place(page, "".join(lines).encode())
    return wrong


def place(file, data):
    copy = SOURCE / file.relative_to(ROOT)
    copy.parent.mkdir(parents=True, exist_ok=True)
    copy.write_bytes(data)


class Page(HTMLParser):
    """The names in a page that links may end at, and its own links."""

    def __init__(self, file):
        super().__init__()
        self.names, self.links = set(), []
        self.feed(file.read_text())

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.names.add(value)
            elif (tag, name) in (("a", "href"), ("img", "src"), ("script", "src"), ("link", "href")) and value:
                self.links.append(value)


def check():
    """Every link of the built site that leads to no file, or to no place in it."""
    read = {file: Page(file) for file in SITE.rglob("*.html")}

    def names(file):
        return read[file].names if file in read else ()

    wrong = set()
    for file, page in read.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            base = SITE if parts.path.startswith("/") else file.parent
            target = (base / unquote(parts.path).lstrip("/")).resolve() if parts.path else file
            if target.is_dir():
                target /= "index.html"
            found = target.is_file() and (not parts.fragment or parts.fragment in names(target))
            # 404.html is served from anywhere.
            if not found and file.name not in ("404.html", "print.html", "toc.html"):
                wrong.add(f"{file.relative_to(SITE)}: {link}")
    return sorted(wrong)


def main():
    mdbook = Path(sys.argv[1]).resolve()
    shutil.rmtree(BUILD, ignore_errors=True)
    SOURCE.mkdir(parents=True)
    known = pages()
    wrong = [f"docs/SUMMARY.md: {page} is not there" for page in known if not page.is_file()]
    for page in known if not wrong else ():
        wrong += lay(page, set(known))
    if not wrong:
        summary = LINK.sub(
            lambda match: f"{match[1]}{(ROOT / 'docs' / match[2]).resolve().relative_to(ROOT)}{match[3]}",
            (ROOT / "docs/SUMMARY.md").read_text())
        (SOURCE / "SUMMARY.md").write_text(summary)
        shutil.copy(ROOT / "docs/book.toml", BUILD)
        if subprocess.run([mdbook, "build", BUILD]).returncode:
            sys.exit("docs: mdBook failed")
        wrong = check()
    for line in wrong:
        print(f"docs: {line}", file=sys.stderr)
    if wrong:
        sys.exit(1)
    print(f"docs: {len(known)} pages, all links lead somewhere: build/docs/html/index.html")


if __name__ == "__main__":
    main()
