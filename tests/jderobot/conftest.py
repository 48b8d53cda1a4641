"""A simulated plane on the ground, a driver with Ice, and a client: made once for the tests that do not fly."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.jderobot.support import Client, client_of, driver
from tests.server.client import Served
from tests.support import simulated_plane


@pytest.fixture(autouse=True)
def own_configuration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody's own configuration takes part."""
    monkeypatch.setenv("VENCEJO_CONFIG", str(tmp_path / "none.toml"))


@pytest.fixture(scope="module")
def grounded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A driver with a plane that stands."""
    with (
        simulated_plane() as link,
        driver(link, data=tmp_path_factory.mktemp("data")) as served,
    ):
        yield served


@pytest.fixture
def client(grounded: Served) -> Iterator[Client]:
    """A client of it, whose plane is ready."""
    with client_of(grounded.said["ice"]) as client:
        client.wait_ready()
        yield client
