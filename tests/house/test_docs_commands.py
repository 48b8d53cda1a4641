"""Every command in the documents is run by a test, parsed by the real parser, or listed here with a reason."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import vencejo

from tests.browser.texts import Language, catalogues
from tests.house.commands import check_mention, parse
from tests.house.support import ROOT, tracked
from tests.house.test_docs import DOCUMENTS

PAGES = [path for path in DOCUMENTS if path.name != "CHANGELOG.md" and "adr" not in path.parts]
BLOCK = re.compile(r"^( *)```(\w+)\n(.*?)^\1```", re.MULTILINE | re.DOTALL)

RUN_BY = {
    r"make demo": "tests/cli/test_demo.py",
    r"make test": ".ci/run",
    r"make (lint|faults)": "Makefile",
    r"python examples/(design_landing|fly_plan)\.py .*": "tests/sdk/test_example_programs.py",
    r"jupyter notebook examples/draw_flight\.ipynb": "tests/sdk/test_example_programs.py",
    r"npm run (slices|client).*": "tests/jderobot/test_javascript.py",
    r"curl .*": "tests/fleet/test_orders.py",
}
"""Commands that a test, or the test run itself, executes: pattern, and where."""

NOT_RUN = {
    r"git clone .*": "the checkout is there already, and a test has no network",
    r"source \.venv/bin/activate": "changes the shell alone; the tests use .venv/bin/python",
    r"make (fmt|bench|truth|soak|ros|fuzz|audit|sanitize|screenshots|lock|wheel|clean|docs|help)( [A-Z_]+=.*)?": "changes files, takes long, or needs a network; "
    "test_make_targets_in_the_documents_exist sees that it is there",
    r"(apt|apt-get|sudo|useradd|install|udevadm|systemctl|journalctl|nmcli) .*": "changes the system; packaging/ is looked at by test_packaging.py",
    r"(/opt/vencejo/bin/)?(python3 -m venv|pip install) .*|\. \.venv/bin/activate": "installs from the network; test_wheel.py installs what we build",
    r"VENCEJO_DATA=\S+ sudo .*": "acts as another user",
    r"ssh -N -L .*": "another machine",
    r"docker compose .*": "needs Docker; tests/fleet/test_example_fleet.py runs the commands of the containers without them",
    r"source /opt/ros/jazzy/setup\.bash|ros2 .*|export (RMW_IMPLEMENTATION|ZENOH_CONFIG_OVERRIDE)=.*|transport/link/tls/.*": "needs ROS 2, which no package registry has",
    r"mavproxy\.py .*": "another program; tests/peers/test_mavproxy.py runs it",
}
"""Commands that are not run here, and why."""


def blocks(kind: str) -> Iterator[tuple[Path, str]]:
    for path in PAGES:
        for block in BLOCK.finditer(path.read_text(encoding="utf-8")):
            if block[2] == kind:
                yield path, block[3]


def lines() -> Iterator[tuple[str, str]]:
    """Yield the commands of all `sh` blocks, one per line, without comments, with continued lines joined."""
    for path, block in blocks("sh"):
        for line in block.replace("\\\n", " ").splitlines():
            words = re.sub(r"(^|\s)#.*$", "", line).strip()
            for part in re.split(r"\s*(?:&&|;)\s*", words):
                if part:
                    yield str(path.relative_to(ROOT)), part


COMMANDS = sorted(set(lines()))


def judge(command: str) -> None:
    """Check that a command is run somewhere, or can be parsed.

    Raises
    ------
    ValueError
        When it does not exist and is not listed here.
    """
    if command.startswith("vencejo "):
        parse(command)
        return
    if command.startswith("cd "):
        return
    scripts = json.loads((ROOT / "gcs/package.json").read_text(encoding="utf-8"))["scripts"]
    words = command.split()
    while words and re.fullmatch(r"[A-Z_]+=\S*", words[0]):
        words.pop(0)
    plain = " ".join(words)
    if test := next((test for pattern, test in RUN_BY.items() if re.fullmatch(pattern, plain)), None):
        if not (ROOT / test).is_file():
            raise ValueError(f"{command}: run by {test}, which is not there")
    elif found := re.match(r"npm --prefix gcs (?:run (?:--silent )?)?([\w:-]+)", plain):
        if found[1] not in {*scripts, "ci"}:
            raise ValueError(f"{command}: gcs/package.json has no {found[1]}")
    elif found := re.match(r"(?:cargo test .*-p|cargo build .*-p) ([\w-]+)", plain):
        if not any(f'name = "{found[1]}"' in path.read_text(encoding="utf-8") for path in tracked("*Cargo.toml")):
            raise ValueError(f"{command}: no crate {found[1]}")
    elif found := re.match(
        r"(?:\.venv/bin/)?(?:python3?|pytest|node|bash)? ?(?:-m pytest )?((?:[\w.-]+/)*[\w.-]+\.(?:py|sh|js|mjs)|tests/\S+)\b",
        plain,
    ):
        if not (ROOT / found[1]).exists():
            raise ValueError(f"{command}: {found[1]} is not there")
    elif not any(re.fullmatch(pattern, plain) for pattern in NOT_RUN):
        raise ValueError(f"{command}: neither run nor parsed; say why not in NOT_RUN")


@pytest.mark.parametrize("page", sorted({page for page, _ in COMMANDS}))
def test_commands_of_a_page_are_run_or_parsed_or_said_not_to_be(page: str) -> None:
    for command in [command for where, command in COMMANDS if where == page]:
        judge(command)


def test_there_are_commands_and_each_reason_is_needed() -> None:
    assert len(COMMANDS) > 80
    for pattern in (*RUN_BY, *NOT_RUN):
        # Commands mentioned in text need no block.
        assert any(re.fullmatch(pattern, command) for _, command in COMMANDS) or pattern.startswith(
            ("make", "mavproxy", "npm")
        )


@pytest.mark.parametrize(
    "line",
    [
        "vencejo fly",
        "vencejo fly a.plan --lnk x",
        "vencejo mission send a.plan",
        "rm -rf x",
        "cargo test -p nobody",
        "pytest tests/none.py",
    ],
)
def test_what_is_not_there_is_noticed(line: str) -> None:
    with pytest.raises(ValueError, match=re.escape(line)):
        judge(line)


def test_commands_in_texts_exist_with_their_options() -> None:
    count = 0
    for path in PAGES:
        text = BLOCK.sub("", path.read_text(encoding="utf-8"))
        for mention in re.findall(r"`(vencejo [^`]+)`", text):
            check_mention(mention)
            count += 1
    assert count > 40
    with pytest.raises(ValueError, match="--nothing"):
        check_mention("vencejo serve --link … --nothing")


def test_python_in_the_documents_compiles_and_names_what_there_is() -> None:
    found = list(blocks("python"))
    assert len(found) >= 5
    for path, code in found:
        compile(code, str(path), "exec")
        for name in re.findall(r"\bvencejo\.([A-Za-z]\w*)", re.sub(r"(from|import) vencejo\.\S+", "", code)):
            assert hasattr(vencejo, name), f"{path.name}: vencejo has no {name}"


@pytest.mark.parametrize(("page", "language"), [("docs/tutorial.md", "en"), ("docs/es/tutorial.md", "es")])
def test_the_tutorial_names_the_buttons_as_the_page_does(page: str, language: Language) -> None:
    named = set(re.findall(r"(?<!\*)\*([^*\n]+)\*(?!\*)", (ROOT / page).read_text(encoding="utf-8")))
    assert len(named) >= 10
    # Menu entries through which the English page is switched to Spanish.
    texts = {*catalogues()[language].values(), "Settings", "Español"}
    assert named <= texts, f"the page says none of {named - texts}"
