#!/usr/bin/env python3
"""Finds circles between the source files of one crate, of python/vencejo, or of the web app.

An arrow leads from a file to the file that defines an imported name: re-exports are followed to the definition, so that
`use super::Name` through a `mod.rs` is not an arrow to that `mod.rs`, and a re-export itself is not an arrow either.
Type-only imports count too, since readers of one file have to know the other. Tests are excluded. Standard library
only.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

__all__ = ["circles", "python_arrows", "rust_arrows", "typescript_arrows"]

Arrows = dict[str, set[str]]
"""File → files that it imports from, as paths relative to the root."""
Module = tuple[str, ...]

_USE = re.compile(r"(?:^|[;{}\]\s])(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);")
_PATH = re.compile(r"\b(?:crate|super|self)(?:\s*::\s*\w+)+")
_DEFINES = re.compile(r"\b(?:struct|enum|union|fn|trait|type|const|static|mod|macro_rules!)\s+(\w+)")
_TEST_MODULE = re.compile(
    r"#\[cfg\((?:all\()?(?:test|any\(test)[^\]]*\]\s*(?:#\[[^\]]*\]\s*)*(?:pub(?:\([^)]*\))?\s+)?mod\s+(\w+)\s*([;{])"
)
_TS_IMPORT = re.compile(r"""(?:\bfrom|\bimport)\s*\(?\s*['"]([^'"]+)['"]""")


def circles(arrows: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """Return the sets of files that all lead to each other (the strongly connected components of more than one), sorted.

    Tarjan, "Depth-first search and linear graph algorithms", 1972.
    """
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(arrows.get(node, ())):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            at = stack.index(node)
            component = stack[at:]
            del stack[at:]
            if len(component) > 1:
                found.append(sorted(component))

    for node in sorted(arrows):
        if node not in index:
            visit(node)
    return sorted(found)


def rust_arrows(root: Path, crate: str) -> Arrows:
    """Return the arrows between the files of one crate."""
    return _Crate(root, root / "crates" / crate / "src").arrows()


class _Crate:
    """The modules of one crate, with their imports and re-exports."""

    def __init__(self, root: Path, source: Path) -> None:
        self._root = root
        texts: dict[Module, str] = {}
        self._paths: dict[Module, Path] = {}
        tests: set[Module] = set()
        for path in sorted(source.rglob("*.rs")):
            parts = path.relative_to(source).with_suffix("").parts
            module = parts[:-1] if parts[-1] in {"mod", "lib", "main"} else parts
            text = _without_comments(path.read_text(encoding="utf-8"))
            text, declared = _without_tests(text)
            tests |= {(*module, name) for name in declared}
            texts[module], self._paths[module] = text, path
        for module in [one for one in texts if any(one[: len(test)] == test for test in tests)]:
            del texts[module], self._paths[module]
        self._texts = texts
        self._uses = {module: list(_uses(text)) for module, text in texts.items()}
        self._defines = {module: set(_DEFINES.findall(text)) for module, text in texts.items()}

    def arrows(self) -> Arrows:
        found: Arrows = {}
        for module, text in self._texts.items():
            here = found.setdefault(self._shown(module), set())
            rest = _USE.sub(";", text)
            named = set(re.findall(r"\w+", rest))
            wanted = [path for path, name in self._uses[module] if name == "*" or name in named]
            wanted += [tuple(part.strip() for part in path.split("::")) for path in _PATH.findall(rest)]
            for path in wanted:
                target = self._target(module, path)
                if target is not None and target != module:
                    here.add(self._shown(target))
        return found

    def _shown(self, module: Module) -> str:
        return self._paths[module].relative_to(self._root).as_posix()

    def _target(
        self, module: Module, path: Module, seen: frozenset[tuple[Module, Module]] = frozenset()
    ) -> Module | None:
        """Return the module that defines the item at a path; ``None`` if it is not of this crate."""
        if (module, path) in seen:
            return None
        seen |= {(module, path)}
        at, rest = self._start(module, path)
        if at is None:
            return None
        while rest and (*at, rest[0]) in self._texts:
            at, rest = (*at, rest[0]), rest[1:]
        if not rest or rest[0] == "*":
            return at
        name = rest[0]
        if name in self._defines[at]:
            return at
        for used, alias in self._uses[at]:
            if alias == name:
                return self._target(at, (*used, *rest[1:]), seen) or self._target(at, used, seen)
        for used, alias in self._uses[at]:
            if alias == "*":
                target = self._target(at, (*used[:-1], *rest), seen)
                if target is not None and name in self._defines[target]:
                    return target
        return at

    def _start(self, module: Module, path: Module) -> tuple[Module | None, Module]:
        if path[0] == "crate":
            return (), path[1:]
        if path[0] == "self":
            return module, path[1:]
        at = module
        while path and path[0] == "super":
            at, path = at[:-1], path[1:]
        if at != module:
            return at, path
        return (module, path) if (*module, path[0]) in self._texts else (None, path)


def _without_comments(text: str) -> str:
    """Return the text without comments and strings; handles quotes in character literals, not `//` in strings."""
    text = re.sub(r"'(?:\\.|[^\\'])'", "' '", text)
    text = re.sub(r'r(#*)".*?"\1|"(?:\\.|[^"\\])*"', '""', text, flags=re.DOTALL)
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.DOTALL)


def _without_tests(text: str) -> tuple[str, set[str]]:
    """Return the text without its test modules, and the names of those that are files."""
    files = set()
    while (found := _TEST_MODULE.search(text)) is not None:
        end = found.end()
        if found.group(2) == ";":
            files.add(found.group(1))
        else:
            depth = 1
            while depth and end < len(text):
                depth += {"{": 1, "}": -1}.get(text[end], 0)
                end += 1
        text = text[: found.start()] + text[end:]
    return text, files


def _uses(text: str) -> Iterator[tuple[Module, str]]:
    """Yield each imported path with its local name."""
    for _, tree in _USE.findall(text):
        yield from _expand((), tree)


def _expand(before: Module, tree: str) -> Iterator[tuple[Module, str]]:
    tree = tree.strip()
    head, brace, inner = tree.partition("{")
    if brace:
        base = (*before, *(part.strip() for part in head.split("::") if part.strip()))
        for branch in _branches(inner[: inner.rindex("}")]):
            yield from _expand(base, branch)
        return
    path, _, alias = tree.partition(" as ")
    parts = (*before, *(part.strip() for part in path.split("::") if part.strip()))
    if parts and parts[-1] == "self":
        parts = parts[:-1]
    if parts:
        yield parts, alias.strip() or parts[-1]


def _branches(inner: str) -> Iterator[str]:
    depth, begin = 0, 0
    for at, character in enumerate(inner):
        depth += {"{": 1, "}": -1}.get(character, 0)
        if character == "," and depth == 0:
            yield inner[begin:at]
            begin = at + 1
    if inner[begin:].strip():
        yield inner[begin:]


def python_arrows(root: Path, package: str = "vencejo") -> Arrows:
    """Return the arrows between the modules of a package below ``python/``."""
    top = root / "python"
    files = {}
    for path in sorted((top / package).rglob("*.py*")):
        if path.suffix not in {".py", ".pyi"}:
            continue
        parts = path.relative_to(top).with_suffix("").parts
        files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    imports = {
        name: list(_imported(ast.parse(path.read_text(encoding="utf-8")), name, is_package=_is_package(path)))
        for name, path in files.items()
    }

    def target(name: str, seen: frozenset[str] = frozenset()) -> str | None:
        """Return the module that defines a dotted name; re-exports of a package are followed."""
        if name in files:
            return name
        module, _, attribute = name.rpartition(".")
        if module not in files or name in seen:
            return None
        for found, alias in imports[module]:
            if alias == attribute and _is_package(files[module]):
                return target(found, seen | {name}) or module
        return module

    found: Arrows = {}
    for name, path in files.items():
        here = found.setdefault(path.relative_to(root).as_posix(), set())
        for imported, _ in imports[name]:
            other = target(imported)
            if other is not None and other != name:
                here.add(files[other].relative_to(root).as_posix())
    return found


def _is_package(path: Path) -> bool:
    return path.name == "__init__.py"


def _imported(tree: ast.Module, module: str, *, is_package: bool) -> Iterator[tuple[str, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, alias.asname or alias.name
        elif isinstance(node, ast.ImportFrom):
            above = module.split(".") if is_package else module.split(".")[:-1]
            base = node.module or ""
            if node.level:
                base = ".".join([*above[: len(above) - node.level + 1], *([base] if base else [])])
            for alias in node.names:
                yield f"{base}.{alias.name}", alias.asname or alias.name


def typescript_arrows(root: Path) -> Arrows:
    """Return the arrows between the files of the web app."""
    source = root / "gcs/src"
    files = {path for path in source.rglob("*") if path.suffix in {".ts", ".svelte"} and ".test." not in path.name}
    found: Arrows = {}
    for path in sorted(files):
        here = found.setdefault(path.relative_to(root).as_posix(), set())
        for name in _TS_IMPORT.findall(
            re.sub(r"//[^\n]*|/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        ):
            base = (
                source / "lib" / name[5:]
                if name.startswith("$lib/")
                else (path.parent / name).resolve()
                if name[0] == "."
                else None
            )
            if base is None:
                continue
            for candidate in (
                base,
                *(base.with_name(base.name + end) for end in (".ts", ".svelte.ts", ".svelte")),
                base / "index.ts",
            ):
                if candidate in files and candidate != path:
                    here.add(candidate.relative_to(root).as_posix())
                    break
    return found
