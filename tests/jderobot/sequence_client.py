"""A client of the other Mission dialect, mission_sequence.ice: sends a bare sequence of poses. Knows only the Slice files."""

from __future__ import annotations

import sys
import time


def main(slices: str, proxy: str) -> None:
    """Read the mission, send a bad one and a good one, read it back; each answer is a line."""
    import Ice

    Ice.loadSlice("", ["--all", f"-I{slices}", f"{slices}/jderobot/mission_sequence.ice"])
    jderobot = sys.modules["jderobot"]
    with Ice.initialize() as communicator:
        mission = jderobot.MissionPrx.checkedCast(communicator.stringToProxy(proxy))
        print([pose.h for pose in mission.getMissionData()])  # noqa: T201 - its answers
        print(mission.setMissionData([]))  # noqa: T201
        poses = [
            jderobot.Pose3DData(x=40.3362, y=-3.7978, h=60.0),
            jderobot.Pose3DData(x=40.3392, y=-3.7978, h=70.0),
        ]
        answer = 2
        deadline = time.monotonic() + 60.0
        while answer == 2 and time.monotonic() < deadline:  # no vehicle has been heard yet
            answer = mission.setMissionData(poses)
        print(answer)  # noqa: T201
        print([pose.h for pose in mission.getMissionData()])  # noqa: T201


if __name__ == "__main__":
    main(*sys.argv[1:])
