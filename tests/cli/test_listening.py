"""Who is heard when no link is named: asked once, kept, and never more than was chosen."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from vencejo.cli import listening
from vencejo.cli.listening import Listening, default_link


@pytest.fixture(autouse=True)
def data_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("VENCEJO_DATA", str(tmp_path / "data"))
    return tmp_path / "data"


@pytest.mark.fault(40, figure="the default link listens on loopback where nobody can be asked")
def test_without_anybody_to_ask_it_is_this_machine_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert default_link(ask=True) == "udpin:127.0.0.1:14550"
    told = capsys.readouterr().err
    assert "this machine alone" in told
    assert "--listen network" in told
    assert listening.kept() is None, "what nobody chose is not kept"


def test_a_choice_is_kept(data_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert default_link(Listening.NETWORK) == "udpin:lan:14550"
    assert default_link() == "udpin:lan:14550", "at the next start too"
    assert capsys.readouterr().err.count("private networks") == 2
    assert json.loads((data_folder / "listen.json").read_text()) == {"listen": "network"}
    assert default_link(Listening.EVERYONE) == "udpin:0.0.0.0:14550"
    assert [path.name for path in data_folder.iterdir()] == ["listen.json"]


def test_a_damaged_choice_is_none(data_folder: Path) -> None:
    data_folder.mkdir()
    for text in ("", "[]", '{"listen": "all"}', "\x00"):
        (data_folder / "listen.json").write_text(text)
        assert default_link() == "udpin:127.0.0.1:14550", text


def test_at_a_terminal_it_is_asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    questions = []

    def answer(question: str, **_: object) -> int:
        questions.append(question)
        return 2

    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setattr("typer.prompt", answer)
    assert [default_link(ask=True) for _ in range(2)] == ["udpin:lan:14550"] * 2
    assert len(questions) == 1
