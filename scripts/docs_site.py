"""Generates pages of the documentation site from the code: the command, HTTP, Ice, and the package's modules.

A hook of MkDocs (mkdocs.yml). Documents outside of docs/ become pages too, and links to files without a page lead to
the repository. Generated pages are not stored; MkDocs is needed only to build the site.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import posixpath
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any
from unittest import mock

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
REPOSITORY = "https://github.com/jderobot/vencejo"
LINK = re.compile(r"(!?\[[^\]]*\]\()([^)\s]+)(\))")
FENCE = re.compile(r"(^```.*?^```)", re.MULTILINE | re.DOTALL)

DOCUMENTS = {
    "ARCHITECTURE.md": "project/architecture.md",
    "TESTING.md": "project/testing.md",
    "SECURITY.md": "project/security.md",
    "CHANGELOG.md": "project/changelog.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "examples/README.md": "examples.md",
    "README.md": "index.md",
    "README.es.md": "es/index.md",
}
"""Files of the checkout that become pages unchanged."""
HIDDEN_MODULES = {"vencejo.cli", "vencejo.jderobot"}
"""Rooms documented elsewhere: by the command's page, and by docs/jderobot.md."""


# Python -----------------------------------------------------------------------------------------------------------------


def modules() -> list[str]:
    """Return the public modules of the package: those without an underscore."""
    package = ROOT / "python/vencejo"
    found = ["vencejo"]
    for path in sorted(package.iterdir()):
        name = path.stem if path.suffix == ".py" else path.name if (path / "__init__.py").is_file() else ""
        if name and not name.startswith("_") and f"vencejo.{name}" not in HIDDEN_MODULES:
            found.append(f"vencejo.{name}")
    return found


def module_page(name: str) -> str:
    """Return the page of a module, which mkdocstrings fills."""
    page = f"# {name}\n\n::: {name}\n"
    if name == "vencejo":
        # Names imported from its modules are documented there.
        return page + "    options:\n      members: false\n      summary: false\n\n" + "\n".join(exported()) + "\n"
    return page


def exported() -> Iterator[str]:
    """Yield a list of everything exported by `import vencejo`, with links to the documentation."""
    import vencejo

    yield "| name | from |\n|---|---|"
    for name in vencejo.__all__:
        module = getattr(getattr(vencejo, name), "__module__", "vencejo")
        if module == "vencejo._native" or name == "__version__":
            yield f"| `{name}` | |"
        else:
            yield f"| [`{name}`][{module}.{name}] | [{module}]({module}.md) |"


# The command ------------------------------------------------------------------------------------------------------------


def command_page() -> str:
    """Return the help of every command, as shown by a terminal of 100 columns."""
    import typer
    from vencejo.cli.commands import app

    root: Any = typer.main.get_command(app)
    parts = ["# The command", "Written by each command's `--help`."]

    def walk(command: Any, words: tuple[str, ...]) -> None:
        name = " ".join(("vencejo", *words))
        output = io.StringIO()
        terminal = {"COLUMNS": "100", "TERM": "dumb", "NO_COLOR": "1"}
        with mock.patch.dict(os.environ, terminal), contextlib.redirect_stdout(output), contextlib.suppress(SystemExit):
            root.main([*words, "--help"], prog_name="vencejo", standalone_mode=False)
        told = output.getvalue()
        told = "\n".join(line.rstrip() for line in told.strip("\n").splitlines())
        parts.append(f"{'#' * min(2 + max(len(words) - 1, 0), 4)} {name}\n\n```text\n{told}\n```")
        for child, inner in getattr(command, "commands", {}).items():
            walk(inner, (*words, child))

    walk(root, ())
    return "\n\n".join(parts) + "\n"


# HTTP -------------------------------------------------------------------------------------------------------------------


def cell(text: object) -> str:
    """Return a text escaped for a table cell."""
    return " ".join(str(text).split()).replace("|", "\\|").replace("<", "&lt;")


def type_of(schema: Mapping[str, Any]) -> str:
    """Return a schema's type as text, with links to named schemas."""
    if "$ref" in schema:
        name = str(schema["$ref"]).rsplit("/", 1)[1]
        return f"[{name}](#{name.lower()})"
    for key in ("oneOf", "anyOf", "allOf"):
        if key in schema:
            return " or ".join(dict.fromkeys(type_of(each) for each in schema[key]))
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if "enum" in schema:
        return " ".join(f"`{json.dumps(each)}`" for each in schema["enum"])
    kinds = schema.get("type", "any")
    kinds = [kinds] if isinstance(kinds, str) else list(kinds)
    said = []
    for kind in kinds:
        if kind == "array":
            items = schema.get("items")
            said.append("list of " + type_of(items) if isinstance(items, dict) else "list")
        elif kind == "object" and isinstance(schema.get("additionalProperties"), dict):
            said.append("map of " + type_of(schema["additionalProperties"]))
        else:
            said.append(f"{kind}")
    limits = [f"{sign} {schema[key]:g}" for key, sign in (("minimum", "≥"), ("maximum", "≤")) if key in schema]
    return " or ".join(said) + (f" ({', '.join(limits)})" if limits else "")


def properties(schema: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of an object's properties."""
    required = set(schema.get("required", ()))
    if schema.get("properties"):
        yield "| field | type | meaning |\n|---|---|---|"
        for name, field in schema["properties"].items():
            is_optional = "" if name in required else " (optional)"
            yield f"| `{name}`{is_optional} | {type_of(field)} | {cell(field.get('description', ''))} |"


def schema_part(name: str, schema: Mapping[str, Any]) -> Iterator[str]:
    """Yield a named schema: its description, properties and variants."""
    yield f"### {name} {{ #{name.lower()} }}\n"
    if schema.get("description"):
        yield f"{schema['description']}\n"
    kinds = schema.get("oneOf") or schema.get("anyOf") or schema.get("allOf")
    yield from properties(schema)
    if kinds is not None:
        for kind in kinds:
            said = cell(kind.get("description", "")) if "$ref" not in kind else ""
            yield f"\n{'One of' if 'allOf' not in schema else 'With'} {type_of(kind)}{': ' + said if said else ''}\n"
            yield from properties(kind)
    elif "properties" not in schema:
        yield type_of(schema)
    yield ""


def operation_part(method: str, path: str, operation: Mapping[str, Any]) -> Iterator[str]:
    """Yield one operation: its parameters, request body and responses."""
    yield f"### {method.upper()} {path}\n".replace("{", "&#123;")
    for key in ("summary", "description"):
        if operation.get(key):
            yield f"{operation[key]}\n"
    if operation.get("parameters"):
        yield "| parameter | in | type | meaning |\n|---|---|---|---|"
        for parameter in operation["parameters"]:
            name = f"`{parameter['name']}`" + ("" if parameter.get("required") else " (optional)")
            kind = type_of(parameter.get("schema", {}))
            yield f"| {name} | {parameter['in']} | {kind} | {cell(parameter.get('description', ''))} |"
        yield ""
    for media, content in operation.get("requestBody", {}).get("content", {}).items():
        yield f"Body (`{media}`): {type_of(content.get('schema', {}))}\n"
    yield "| status | answer | |\n|---|---|---|"
    for status, answer in operation["responses"].items():
        kinds = [
            f"{type_of(content['schema'])}" if "schema" in content else f"`{media}`"
            for media, content in answer.get("content", {}).items()
        ]
        yield f"| {'otherwise' if status == 'default' else status} | {', '.join(kinds)} | {cell(answer.get('description', ''))} |"
    yield ""


def http_page(api: Mapping[str, Any]) -> str:
    """Return the page of the whole API, from its OpenAPI description."""
    groups: dict[str, list[str]] = {}
    for path, methods in api["paths"].items():
        for method, operation in methods.items():
            group = (operation.get("tags") or ["other"])[0]
            groups.setdefault(group, []).extend(operation_part(method, path, operation))
    lines = ["# HTTP and WebSocket\n", f"{api['info']['description']}\n"]
    lines.append(
        f"Made from [schemas/openapi.json]({REPOSITORY}/blob/main/schemas/openapi.json), which a server gives out too.\n"
    )
    for group in sorted(groups):
        lines += [f"## {group.capitalize()}\n", *groups[group]]
    lines.append("## Schemas\n")
    for name, schema in api["components"]["schemas"].items():
        lines += schema_part(name, schema)
    return "\n".join(lines) + "\n"


# Ice --------------------------------------------------------------------------------------------------------------------

DECLARATION = re.compile(
    r"^(?:local )?(interface|struct|class|exception|enum|sequence|dictionary|const)\b[\s<](.*?)[;{]?$"
)


def comment_text(lines: Iterable[str]) -> str:
    """Return a comment's text without its markers."""
    return " ".join(" ".join(re.sub(r"^\s*(/\*\*?|\*/|\*|//)?|\*/\s*$", "", line) for line in lines).split())


def ice_file(path: Path) -> Iterator[str]:
    """Yield the declarations of a Slice file with their doc comments."""
    lines = path.read_text(encoding="utf-8").splitlines()
    comment: list[str] = []
    depth, position = 0, 0
    is_first, in_table = True, False
    while position < len(lines):
        line = lines[position].strip()
        position += 1
        if line.startswith("/*"):
            comment = [line]
            while "*/" not in line:
                line = lines[position].strip()
                position += 1
                comment.append(line)
            continue
        if line.startswith("//"):
            comment.append(line)
            continue
        if not line or line.startswith(("#", "[[")):
            if is_first and comment:
                yield comment_text(comment) + "\n"
                is_first = False
            comment = []
            continue
        line, _, trailing = line.partition(" //")
        line = line.strip()
        said = " ".join(filter(None, (comment_text(comment), trailing.strip())))
        comment = []
        is_first = False
        if line in ("{", "}", "};"):
            depth += 1 if line == "{" else -1
            if depth <= 1 and in_table:
                yield ""
                in_table = False
            continue
        if line.startswith("module "):
            yield f"Module `{line.removeprefix('module ').rstrip('{ ')}`.\n"
            depth += line.count("{")
            continue
        # A declaration may span several lines.
        while (
            not re.search(r"[;{},]$", line)
            and position < len(lines)
            and lines[position].strip() not in ("{", "}", "};")
        ):
            line += " " + lines[position].strip()
            position += 1
        top = DECLARATION.match(line) if depth <= 1 else None
        if top is not None and top[1] in ("interface", "struct", "class", "exception", "enum"):
            if in_table:
                yield ""
            name = top[2].partition("{")[0].strip()
            own, *base = name.split(None, 1)
            yield f"#### {top[1]} {own}\n"
            if base:
                yield f"`{base[0]}`\n"
            if said:
                yield f"{said}\n"
            body = line.partition("{")[2].rstrip("}; ").strip()
            if body:
                yield f"`{body}`\n"
            depth += line.count("{") - line.count("}")
            in_table = False
            continue
        if depth <= 1:
            yield f"`{line.rstrip(';')}`{': ' + said if said else ''}\n"
            continue
        if not in_table:
            yield "| member | meaning |\n|---|---|"
            in_table = True
        yield f"| `{cell(line.rstrip(';,')).replace('&lt;', '<')}` | {cell(said)} |"
        depth += line.count("{") - line.count("}")
    yield ""


def ice_page() -> str:
    """Return the page of all Slice files: ours, and those of the JdeRobot platform."""
    lines = [
        "# ZeroC Ice\n",
        "Made from the Slice files. What each value means, and how old clients use them: [the JdeRobot interfaces](../jderobot.md).\n",
    ]
    folder = ROOT / "python/vencejo/jderobot/slice"
    for group in ("vencejo", "jderobot"):
        lines.append(f"## {group}\n")
        for path in sorted((folder / group).glob("*.ice")):
            lines += [f"### {path.name}\n", *ice_file(path)]
    return "\n".join(lines) + "\n"


# Links ------------------------------------------------------------------------------------------------------------------


def lead_on(markdown: str, source: str, page: str) -> str:
    """Return the page of the file `source` of the checkout with its links adapted to the site, where it is `page`."""

    def where(target: str) -> str:
        path, _, anchor = target.partition("#")
        if re.match(r"[a-z]+:", target) or not path:
            return target
        linked = posixpath.normpath(posixpath.join(posixpath.dirname(source), path))
        suffix = f"#{anchor}" if anchor else ""
        if linked in DOCUMENTS:
            there = DOCUMENTS[linked]
        elif linked.startswith("docs/") and (ROOT / linked).is_file():
            there = linked.removeprefix("docs/")
        else:
            kind = "tree" if (ROOT / linked).is_dir() else "blob"
            return f"{REPOSITORY}/{kind}/main/{linked}{suffix}"
        return posixpath.relpath(there, posixpath.dirname(page) or ".") + suffix

    parts = FENCE.split(markdown)
    parts[::2] = [LINK.sub(lambda found: f"{found[1]}{where(found[2])}{found[3]}", part) for part in parts[::2]]
    return "".join(parts)


# MkDocs -----------------------------------------------------------------------------------------------------------------


def generated() -> dict[str, str]:
    """Return the generated pages by address."""
    api = json.loads((ROOT / "schemas/openapi.json").read_text(encoding="utf-8"))
    pages = {
        "reference/command.md": command_page(),
        "reference/http.md": http_page(api),
        "reference/ice.md": ice_page(),
        **{f"reference/sdk/{name}.md": module_page(name) for name in modules()},
    }
    for source, page in DOCUMENTS.items():
        pages[page] = lead_on((ROOT / source).read_text(encoding="utf-8"), source, page)
    return pages


def _fill(nav: list[Any]) -> list[Any]:
    """Return the navigation with its generated lists filled in."""
    lists: dict[str, list[Any]] = {
        "adr": ["adr/README.md", *(f"adr/{path.name}" for path in sorted((ROOT / "docs/adr").glob("[0-9]*.md")))],
        "reference/sdk": [{name: f"reference/sdk/{name}.md"} for name in modules()],
    }
    filled: list[Any] = []
    for entry in nav:
        if isinstance(entry, dict):
            ((title, inside),) = entry.items()
            filled.append({title: _fill(inside) if isinstance(inside, list) else lists.get(inside, inside)})
        else:
            filled.append(entry)
    return filled


def on_config(config: Any) -> Any:
    """Fill the generated lists of the navigation."""
    config["nav"] = _fill(config["nav"])
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add the generated pages."""
    from mkdocs.structure.files import File

    for page, text in generated().items():
        files.append(File.generated(config, page, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Adapt links out of docs/ to where the files are on the site."""
    if page.file.generated_by is not None:
        return markdown
    return lead_on(markdown, f"docs/{page.file.src_uri}", page.file.src_uri)


ELSEWHERE = re.compile(r'<script src="https://unpkg\.com/iframe-worker/shim[^"]*"></script>')


def stay_here(output: str, page: str) -> str:
    """Return a page that loads nothing from other sites: the theme's only such address is replaced by our own file.

    Raises
    ------
    RuntimeError
        When the page would still load something.
    """
    ours = posixpath.relpath("file-search.js", posixpath.dirname(page) or ".")
    output = ELSEWHERE.sub(f'<script src="{ours}"></script>', output)
    if found := re.search(r'<(?:script|img|link rel="stylesheet")[^>]*(?:src|href)="?https?:[^>]*', output):
        raise RuntimeError(f"{page} fetches from elsewhere: {found[0]}")
    return output


def on_post_page(output: str, page: Any, **_: Any) -> str:
    """Make pages load nothing from other sites."""
    return stay_here(output, page.url)


def on_post_template(output_content: str, template_name: str, **_: Any) -> str:
    """The same for templates such as 404.html."""
    return stay_here(output_content, template_name) if template_name.endswith(".html") else output_content
