"""Gathers the documentation into target/site: the pages of the repository as a book, rustdoc, and the Python package.

`python tools/site/build.py [MDBOOK]` wants `cargo doc` to have run, and a Python that has the package with its extra `docs`. The
book has the pages where the repository has them, so that links between them are the same in both. A link that leads nowhere and
a page in docs/ that tools/site/SUMMARY.md does not name are errors.
"""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "tools" / "site"
BOOK = ROOT / "target" / "book"
SITE = ROOT / "target" / "site"
#: What pages of the book may link to beside each other.
BESIDE = ["docs", "LICENSE-MIT", "LICENSE-APACHE", "README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md",
          "scenes/README.md", "fuzz/README.md"]


class Page(HTMLParser):
    """Where a page leads, and the places on it."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.names: set[str] = set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if value and name in ("href", "src"):
                self.links.append(value)
            elif value and name in ("id", "name"):
                self.names.add(value)


def stage() -> None:
    """Lays the pages out as in the repository, and the book's own beside them."""
    shutil.rmtree(BOOK, ignore_errors=True)
    pages = BOOK / "pages"
    for name in BESIDE:
        source, copy = ROOT / name, pages / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, copy)
        else:
            shutil.copy(source, copy)
    for name in ("SUMMARY.md", "api.md"):
        shutil.copy(SOURCE / name, pages / name)
    shutil.copy(SOURCE / "book.toml", BOOK / "book.toml")


def rename_links() -> None:
    """A folder's README is its index in the book; links to it follow."""
    for file in (BOOK / "html").rglob("*.html"):
        page = file.read_text(encoding="utf-8")
        file.write_text(re.sub(r'(href="(?![^"]*:)[^"]*?)\bREADME\.html', r"\1index.html", page), encoding="utf-8")


def unlisted() -> list[str]:
    """Pages in docs/ that the book does not have."""
    listed = set(re.findall(r"\]\(([^)]+)\)", (SOURCE / "SUMMARY.md").read_text(encoding="utf-8")))
    pages = sorted(page.relative_to(ROOT).as_posix() for page in (ROOT / "docs").rglob("*.md"))
    return [f"{page} is not in tools/site/SUMMARY.md" for page in pages if page not in listed]


def broken() -> list[str]:
    """Links of the book that lead to no file, or to no place on a page."""
    found, pages = [], {}
    parts = [SITE / "rust", SITE / "python"]
    for file in sorted(SITE.rglob("*.html")):
        # rustdoc has checked its own; pages of the book alone link to other parts.
        if file.name in ("404.html", "print.html", "toc.html") or any(part in file.parents for part in parts):
            continue
        pages[file] = Page(file)
    for file, page in pages.items():
        for link in page.links:
            url = urlsplit(link)
            if url.scheme or url.netloc:
                continue
            target = (file.parent / unquote(url.path)).resolve() if url.path else file
            target = target / "index.html" if target.is_dir() else target
            lost = target in pages and url.fragment and unquote(url.fragment) not in pages[target].names
            if lost or not target.exists():
                found.append(f"{file.relative_to(SITE)}: {link} leads nowhere")
    return found


def main(mdbook: str = "mdbook") -> int:
    """Builds and checks; the exit code is 1 where a link leads nowhere."""
    stage()
    subprocess.run([mdbook, "build", str(BOOK)], check=True)
    rename_links()
    shutil.rmtree(SITE, ignore_errors=True)
    shutil.copytree(BOOK / "html", SITE)
    shutil.copytree(ROOT / "target" / "doc", SITE / "rust")
    modules = ["lightmesh", "lightmesh.cluster", "lightmesh.errors", "lightmesh.plot"]
    subprocess.run([sys.executable, "-m", "pdoc", "--output-directory", str(SITE / "python"), *modules], check=True)
    errors = unlisted() + broken()
    for error in errors:
        print(error, file=sys.stderr)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
