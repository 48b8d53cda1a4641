"""The descriptors embedded in history files match the payloads."""

from __future__ import annotations

from google.protobuf import descriptor_pool
from google.protobuf.descriptor_pb2 import FileDescriptorSet

from scripts.fleet_schema import made


def test_the_committed_descriptors_are_of_the_payloads() -> None:
    for path, content in made().items():
        assert path.read_bytes() == content, f"{path.name} is of other payloads: run scripts/fleet_schema.py"


def test_they_name_every_field() -> None:
    pool = descriptor_pool.DescriptorPool()
    for content in made().values():
        for file in FileDescriptorSet.FromString(content).file:
            pool.Add(file)
    state = pool.FindMessageTypeByName("vencejo.v1.State")
    assert [(field.name, field.number) for field in state.fields][:4] == [
        ("version", 1), ("boot", 2), ("clock_ms", 3), ("sequence", 4),
    ]  # fmt: skip
    order = pool.FindMessageTypeByName("vencejo.v1.Order")
    wanted = {field.name for field in order.oneofs_by_name["want"].fields}
    assert wanted == {"ask", "renew", "release", "keep", "act", "recall", "part"}
    act = pool.FindMessageTypeByName("vencejo.v1.Act")
    assert {"arm", "plan_put", "param_set"} <= {field.name for field in act.oneofs_by_name["deed"].fields}
    fix = pool.FindMessageTypeByName("foxglove.LocationFix")
    assert [(field.name, field.number) for field in fix.fields] == [
        ("latitude", 1), ("longitude", 2), ("altitude", 3), ("timestamp", 6), ("frame_id", 7),
    ]  # fmt: skip
