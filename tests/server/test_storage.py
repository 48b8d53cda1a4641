"""What `vencejo serve` and the Python package say of a disk that does not work."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import vencejo
from vencejo.cli.serve import tell_storage
from vencejo.storage import StorageProblem, create_file, write_file

from tests.server.client import Client


@pytest.mark.fault(58, figure="`vencejo serve` starts without a disk and says so on standard error")
@pytest.mark.e2e
def test_serve_starts_where_nothing_can_be_written_and_says_so(tmp_path: Path) -> None:
    (tmp_path / "no-folder").write_text("a file in its place")
    command = [sys.executable, "-m", "vencejo.cli", "serve", "--port", "0", "--json", "--link", "udpin:127.0.0.1:0"]
    env = {**os.environ, "VENCEJO_DATA": str(tmp_path / "no-folder" / "data")}
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        try:
            client = Client(json.loads(process.stdout.readline())["url"])
            said = ""
            while any(words not in said for words in ("not being recorded", "not stored", "in memory only")):
                line = process.stderr.readline()
                assert line, said
                said += line
            assert said.count("Warning: ") == 3
            told = {(problem["what"], problem["fault"]["kind"]) for problem in client.done("GET", "storage")}
            assert told == {(what, "unwritable") for what in ("telemetry", "maps", "draft")}
            assert client.done("GET", "links")[0]["state"] == "up"
        finally:
            process.terminate()
            process.wait(20)


def test_each_fault_is_said_once_and_its_end_too(capsys: pytest.CaptureFixture[str]) -> None:
    low = StorageProblem(what="telemetry", fault="low_space", text="telemetry is not being recorded: only 400 MB")
    less = StorageProblem(what="telemetry", fault="low_space", text="telemetry is not being recorded: only 300 MB")
    nose = StorageProblem(what="video", name="nose", fault="ended", text="camera 'nose' is not being recorded: full")
    belly = StorageProblem(what="video", name="belly", fault="ended", text="camera 'belly' is not being recorded: full")
    told = tell_storage([low], {})
    told = tell_storage([less], told)
    told = tell_storage([less, nose, belly], told)
    told = tell_storage([nose], told)
    told = tell_storage([], told)
    assert tell_storage([], told) == {}
    assert capsys.readouterr().err.splitlines() == [
        "Warning: telemetry is not being recorded: only 400 MB",
        "Warning: camera 'nose' is not being recorded: full",
        "Warning: camera 'belly' is not being recorded: full",
        "Telemetry is recorded again",
        "Camera 'belly' is recorded again",
        "Camera 'nose' is recorded again",
    ]


def test_a_program_is_told_when_the_recording_stops(tmp_path: Path) -> None:
    (tmp_path / "no-folder").write_text("a file in its place")
    with vencejo.Station(record=tmp_path / "no-folder" / "telemetry") as station:
        changes = station.recorder_changes(30.0)
        problems = (info.problem for info in changes)
        assert next(problem for problem in problems if problem is not None)
        assert not station.recorder.is_recording if station.recorder else False
        station.close()
        assert list(changes) == []


def test_floors_have_the_flight_recorder_last() -> None:
    assert vencejo.Floors() == vencejo.Floors(maps_mb=2000, video_mb=1000, telemetry_mb=500)
    for wrong in ({"telemetry_mb": 1500}, {"video_mb": 3000}, {"maps_mb": -1}, {"maps_mb": 10_000_001}):
        with pytest.raises(vencejo.InvalidRequest):
            vencejo.Floors(**wrong)


def test_files_are_written_whole_and_errors_are_pythons_own(tmp_path: Path) -> None:
    path = tmp_path / "a.param"
    vencejo.save_params(path, {"WP_RADIUS": 60.0})
    vencejo.save_params(path, {"WP_RADIUS": 90.0})
    assert vencejo.load_params(path) == {"WP_RADIUS": 90.0}
    assert not create_file(path, b"x")
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.param"]
    with pytest.raises(FileNotFoundError) as caught:
        write_file(tmp_path / "slip" / "a.param", b"x")
    assert caught.value.filename == str(tmp_path / "slip" / "a.param")
    write_file("/dev/null", b"x")
