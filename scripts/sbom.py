"""Writes the software bill of materials (CycloneDX 1.5) of everything in the wheel or installed with it.

    scripts/sbom.py parts FOLDER   parts unknown to maturin: the web app's packages, and Python's; for `maturin build --sbom-include`
    scripts/sbom.py merge WHEEL    all documents in the wheel's `.dist-info/sboms` as one file beside it, NAME.cdx.json

maturin lists the crates, and npm the packages of the web app. `make wheel` does both steps.
"""

from __future__ import annotations

import contextlib
import json
import re
import sys
import uuid
import zipfile
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from scripts import audit  # noqa: E402

Document = dict[str, Any]


def document(name: str, version: str, purl: str, components: list[Document], depends: dict[str, list[str]]) -> Document:
    """Return a CycloneDX document about one component."""
    content = json.dumps([components, depends], sort_keys=True)
    return {
        "$schema": "http://cyclonedx.org/schema/bom-1.5.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, purl + content)}",
        "version": 1,
        "metadata": {
            "timestamp": datetime.now(timezone.utc).isoformat(timespec="seconds"),
            "component": {"type": "application", "bom-ref": purl, "name": name, "version": version, "purl": purl},
        },
        "components": components,
        "dependencies": [{"ref": ref, "dependsOn": sorted(set(on))} for ref, on in sorted(depends.items())],
    }


def version() -> str:
    """Return the version of this checkout."""
    found = re.search(
        r'^\[workspace\.package\]\nversion = "([^"]+)"', (ROOT / "Cargo.toml").read_text("utf-8"), re.MULTILINE
    )
    if found is None:
        raise SystemExit("sbom: Cargo.toml names no version")
    return found[1]


def locked_python(lock: str) -> dict[str, str]:
    """Return the names of a lock's packages by purl; some occur twice, in versions for different Pythons."""
    text = (ROOT / f"requirements/{lock}.lock").read_text(encoding="utf-8")
    return {f"pkg:pypi/{re.sub(r'[-_.]+', '-', name).lower()}@{pin}": name for name, pin in audit.PIN.findall(text)}


def python_part() -> Document:
    """Return the Python packages installed with the wheel (run.lock), and those of its extras (optional)."""
    needed = locked_python("run")
    components = []
    for purl, name in sorted({**locked_python("ice"), **locked_python("demo"), **needed}.items()):
        scope = "required" if purl in needed else "optional"
        if name == "maturin":
            scope = "excluded"  # builds the wheel
        component: Document = {
            "type": "library",
            "bom-ref": purl,
            "name": name,
            "version": purl.rpartition("@")[2],
            "purl": purl,
            "scope": scope,
        }
        with contextlib.suppress(PackageNotFoundError):  # for another platform or Python
            component["licenses"] = [{"expression": audit.python_licence(name)}]
        components.append(component)
    root = f"pkg:pypi/vencejo@{version()}"
    return document("vencejo", version(), root, components, {root: [each["bom-ref"] for each in components]})


def web_part() -> Document:
    """Return the web app's packages: npm's own list, without development dependencies."""
    listed = audit.run("npm", "sbom", "--sbom-format", "cyclonedx", "--package-lock-only", cwd=ROOT / "gcs")
    if listed.returncode != 0:
        raise SystemExit(f"sbom: npm sbom failed: {listed.stderr.strip()}")
    found: Document = json.loads(listed.stdout)
    kept = {
        (place.rpartition("node_modules/")[2], package["version"])
        for place, package in audit.npm_packages("gcs").items()
        if not package.get("dev")
    }
    found["components"] = [each for each in found["components"] if (npm_name(each), each["version"]) in kept]
    refs = {each["bom-ref"] for each in found["components"]} | {found["metadata"]["component"]["bom-ref"]}
    found["dependencies"] = [
        {"ref": each["ref"], "dependsOn": [on for on in each.get("dependsOn", ()) if on in refs]}
        for each in found["dependencies"]
        if each["ref"] in refs
    ]
    return found


def npm_name(component: Document) -> str:
    """Return a component's name as in the lock, including its group."""
    group = component.get("group")
    return f"{group}/{component['name']}" if group else str(component["name"])


def sqlite() -> Document:
    """Return SQLite, which is compiled into the wheel: the crate's version is not the library's."""
    crate = next(each for each in audit.crates() if each["name"] == "libsqlite3-sys")
    header = (Path(crate["manifest_path"]).parent / "sqlite3/sqlite3.h").read_text(encoding="utf-8")
    found = re.search(r'#define SQLITE_VERSION +"([\d.]+)"', header)
    if found is None:
        raise SystemExit("sbom: libsqlite3-sys brings no SQLite along any more")
    return {
        "type": "library",
        "bom-ref": f"pkg:generic/sqlite@{found[1]}",
        "name": "sqlite",
        "version": found[1],
        "scope": "required",
        "licenses": [{"license": {"name": "SQLite blessing (public domain)"}}],
        "cpe": f"cpe:2.3:a:sqlite:sqlite:{found[1]}:*:*:*:*:*:*:*",
        "purl": f"pkg:generic/sqlite@{found[1]}",
    }


def merge(parts: list[Document]) -> Document:
    """Return several documents merged: references become purls, and our own parts become children of the package."""
    root = f"pkg:pypi/vencejo@{version()}"
    components: dict[str, Document] = {}
    depends: dict[str, list[str]] = {root: []}
    for part in parts:
        main = part["metadata"]["component"]
        purls = {each["bom-ref"]: each["purl"].partition("?")[0] for each in [main, *part["components"]]}
        members = list(part["components"])
        if purls[main["bom-ref"]] != root:
            members.append({key: value for key, value in main.items() if key != "components"})
            depends[root].append(purls[main["bom-ref"]])
        for each in members:
            purl = purls[each["bom-ref"]]
            components[purl] = {**each, "bom-ref": purl, "purl": purl}
        for each in part.get("dependencies", ()):
            on = [purls[ref] for ref in each.get("dependsOn", ()) if ref in purls]
            depends.setdefault(purls[each["ref"]], []).extend(on)
    library = sqlite()
    components[library["bom-ref"]] = library
    for purl, on in depends.items():
        if purl.startswith("pkg:cargo/libsqlite3-sys@"):
            on.append(library["bom-ref"])
    return document("vencejo", version(), root, [components[purl] for purl in sorted(components)], depends)


def everything() -> set[str]:
    """Return the purls of all locked run-time packages: crates by cargo's graph, npm's and Python's by their locks."""
    listed = audit.run("cargo", "metadata", "--format-version", "1", "--locked", "--offline")
    if listed.returncode != 0:
        raise SystemExit(f"sbom: {listed.stderr.strip()}")
    found = json.loads(listed.stdout)
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    waiting = [package["id"] for package in found["packages"] if package["name"] == "vencejo-py"]
    reached: set[str] = set()
    while waiting:
        crate = waiting.pop()
        if crate not in reached:
            reached.add(crate)
            waiting += [
                each["pkg"] for each in nodes[crate]["deps"] if any(kind["kind"] is None for kind in each["dep_kinds"])
            ]
    crates = {f"pkg:cargo/{each['name']}@{each['version']}" for each in found["packages"] if each["id"] in reached}
    web = {
        f"pkg:npm/{place.rpartition('node_modules/')[2].replace('@', '%40')}@{package['version']}"
        for place, package in audit.npm_packages("gcs").items()
        if not package.get("dev")
    }
    return crates | web | set(locked_python("run")) | set(locked_python("demo"))


def of_wheel(wheel: Path) -> list[Document]:
    """Return the documents in a wheel."""
    with zipfile.ZipFile(wheel) as packed:
        names = [name for name in packed.namelist() if "/sboms/" in name and name.endswith(".json")]
        return [json.loads(packed.read(name)) for name in sorted(names)]


def write(path: Path, content: Document) -> None:
    """Write a document."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def main() -> int:
    """Write the parts, or merge those of a wheel."""
    match sys.argv[1:]:
        case ["parts", folder]:
            write(Path(folder) / "vencejo-gcs.cyclonedx.json", web_part())
            write(Path(folder) / "vencejo-python.cyclonedx.json", python_part())
        case ["merge", wheel]:
            parts = of_wheel(Path(wheel))
            if len(parts) < 3:
                raise SystemExit(
                    f"sbom: {wheel} holds {len(parts)} lists, not those of crates, web app and Python packages"
                )
            write(Path(wheel).with_suffix(".cdx.json"), merge(parts))
        case _:
            print(__doc__, file=sys.stderr)
            return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
