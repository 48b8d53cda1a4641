"""The sources of the site built by `make docs` are complete: navigation and generated pages.

The build itself, which finds broken links and unresolved names, needs requirements/docs.lock: `make docs`, also in
.github/workflows.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

import pytest
import yaml

from tests.house.commands import commands
from tests.house.support import ROOT, load, tracked

site = load("scripts/docs_site.py")


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    found: dict[str, str] = site.generated()
    return found


def leaves(nav: Any) -> Iterator[str]:
    if isinstance(nav, str):
        yield nav
    else:
        for entry in nav.values() if isinstance(nav, dict) else nav:
            yield from leaves(entry)


def test_every_page_has_one_place_in_the_navigation(pages: dict[str, str]) -> None:
    settings = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    listed = list(leaves(site._fill(settings["nav"])))
    written = {str(path.relative_to(ROOT / "docs")) for path in tracked("docs/*.md")}
    assert len(written) > 30
    assert sorted(listed) == sorted(written | set(pages))


def test_nothing_is_fetched_from_elsewhere() -> None:
    settings = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    assert settings["theme"]["font"] is False
    assert "repo_url" not in settings
    shim = '<script src="https://unpkg.com/iframe-worker/shim"></script>'
    assert site.stay_here(shim, "es/tutorial.html") == '<script src="../file-search.js"></script>'
    assert (ROOT / "docs/file-search.js").is_file()
    with pytest.raises(RuntimeError, match="fetches from elsewhere"):
        site.stay_here('<img src="https://example.org/a.png">', "index.html")


def test_the_command_page_has_each_command_and_its_options(pages: dict[str, str]) -> None:
    page = pages["reference/command.md"]
    for name, command in commands().items():
        part = re.search(rf"^#+ {name}\n\n```text\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
        assert part is not None, name
        for parameter in getattr(command, "params", ()):
            assert all(option in part[1] for option in parameter.opts if option.startswith("--")), (
                name,
                parameter.opts,
            )
    assert max(map(len, page.splitlines())) <= 110


def test_the_http_page_has_each_operation_and_schema(pages: dict[str, str]) -> None:
    page = pages["reference/http.md"]
    api = json.loads((ROOT / "schemas/openapi.json").read_text(encoding="utf-8"))
    for path, methods in api["paths"].items():
        for method in methods:
            assert f"### {method.upper()} {path}\n".replace("{", "&#123;") in page
    anchors = set(re.findall(r"\{ #(\w+) \}", page))
    assert anchors == {name.lower() for name in api["components"]["schemas"]}
    assert set(re.findall(r"\]\(#(\w+)\)", page)) <= anchors


def test_the_ice_page_has_each_declaration(pages: dict[str, str]) -> None:
    page = pages["reference/ice.md"]
    count = 0
    for path in tracked("python/vencejo/jderobot/slice/*/*.ice"):
        source = re.sub(r"/\*.*?\*/|//.*", "", path.read_text(encoding="utf-8"))
        for kind, name in re.findall(r"^ *(interface|struct|class|exception|enum) (\w+)", source, re.MULTILINE):
            assert f"#### {kind} {name}\n" in page, f"{path.name}: {kind} {name}"
            count += 1
    assert count > 30


def test_links_lead_to_pages_or_to_the_repository() -> None:
    text = "[a](station.md#x) [b](../SECURITY.md) [c](../tests/faults/REPORT.md) `[d](e)`\n\n```md\n[f](../g)\n```\n"
    assert site.lead_on(text, "docs/maps.md", "maps.md").startswith(
        "[a](station.md#x) [b](project/security.md) "
        "[c](https://github.com/jderobot/vencejo/blob/main/tests/faults/REPORT.md)"
    )
    assert "[f](../g)" in site.lead_on(text, "docs/maps.md", "maps.md")
