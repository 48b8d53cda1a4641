"""The documents are correct where that can be checked: links, code map, changelog, decisions, commands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.browser.texts import catalogues
from tests.house.support import ROOT, table_rows, tracked

DOCUMENTS = [path for path in tracked("*.md") if "fixtures" not in path.parts]
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def anchors(page: str) -> set[str]:
    """Return the anchors that a hosting site generates for the headings."""
    titles = re.findall(r"^#+ (.+)$", FENCE.sub("", page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_resolve(path: Path) -> None:
    for target in LINK.findall(FENCE.sub("", path.read_text(encoding="utf-8"))):
        if re.match(r"[a-z]+:", target):
            assert target.startswith("https://"), f"{target}: not https"
            continue
        name, _, anchor = target.partition("#")
        linked = (path.parent / name).resolve() if name else path
        assert linked.exists(), f"{path.relative_to(ROOT)} links to {target}, which is not there"
        if anchor:
            assert anchor in anchors(linked.read_text(encoding="utf-8")), f"{target}: no such heading"


def test_there_are_documents_with_links() -> None:
    names = {path.name for path in DOCUMENTS}
    assert {"README.md", "ARCHITECTURE.md", "TESTING.md", "CONTRIBUTING.md", "CHANGELOG.md"} <= names
    assert LINK.search((ROOT / "README.md").read_text(encoding="utf-8"))


def test_code_map_has_one_line_for_each_crate_and_room() -> None:
    page = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    code_map = page.partition("## Code map")[2].partition("\n## ")[0]
    mapped = {row[0].strip("`") for row in table_rows(code_map, first_header="crate")}
    crates = {str(path.parent.relative_to(ROOT)) for path in tracked("crates/*/Cargo.toml", "bench/*/Cargo.toml")}
    assert len(crates) >= 6
    assert mapped == crates
    mapped_rooms = {
        row[0].strip("`").rstrip("/") for row in table_rows(code_map, first_header="room in `python/vencejo`")
    }
    rooms = {path.relative_to(ROOT / "python/vencejo").parts[0] for path in tracked("python/vencejo/*/*.py")}
    assert rooms <= mapped_rooms, "a room of python/vencejo is not in ARCHITECTURE.md"


def test_changelog_has_an_unreleased_part_that_says_something() -> None:
    page = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    unreleased = re.search(r"^## \[Unreleased\]\n(.*?)(?=^## |\Z)", page, re.MULTILINE | re.DOTALL)
    assert unreleased is not None
    assert re.search(r"^### (Added|Changed|Deprecated|Removed|Fixed|Security)$", unreleased[1], re.MULTILINE)
    assert re.search(r"^- ", unreleased[1], re.MULTILINE)


def test_decisions_are_numbered_and_listed() -> None:
    pages = sorted(path for path in (ROOT / "docs/adr").glob("*.md") if path.name != "README.md")
    index = (ROOT / "docs/adr/README.md").read_text(encoding="utf-8")
    assert len(pages) >= 4
    for number, path in enumerate(pages, start=1):
        assert path.name.startswith(f"{number:04d}-"), path.name
        text = path.read_text(encoding="utf-8")
        assert text.startswith(f"# {number:04d}: "), path.name
        for part in ("## Context", "## Decision", "## Consequences"):
            assert part in text, f"{path.name}: no {part!r}"
        assert f"({path.name})" in index, f"{path.name} is not in docs/adr/README.md"


def test_the_words_of_the_glossary_are_those_of_the_page() -> None:
    page = (ROOT / "docs/glossary.md").read_text(encoding="utf-8")
    rows = table_rows(page, first_header="English")
    assert len(rows) > 30
    for column, language in ((0, "en"), (1, "es")):
        texts = " ".join(catalogues()[language].values()).lower()  # type: ignore[index]
        words = [word for row in rows for word in row[column].split(", ")]
        assert words == list(dict.fromkeys(words)), "one word for one thing"
        assert [word for word in words if not re.search(rf"\b{re.escape(word.lower())}", texts)] == []


def test_make_targets_in_the_documents_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z][a-z-]*):", makefile, re.MULTILINE))
    named: set[str] = set()
    for path in DOCUMENTS:
        text = path.read_text(encoding="utf-8")
        named |= set(re.findall(r"`make ([a-z-]+)", text)) | set(re.findall(r"^make ([a-z-]+)", text, re.MULTILINE))
    assert {"demo", "test"} <= named
    assert named <= targets, f"not in the Makefile: {named - targets}"


def test_layers_in_testing_exist() -> None:
    rows = table_rows((ROOT / "TESTING.md").read_text(encoding="utf-8"), first_header="layer")
    assert len(rows) >= 6
    for row in rows:
        for folder in re.findall(r"`((?:tests|crates)/[\w/]+)`", row[1]):
            assert (ROOT / folder).is_dir(), f"TESTING.md names {folder}, which is not there"
