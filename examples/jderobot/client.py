"""A JdeRobot client in Python: shows where the plane is and, with --fly, has it fly a mission. Knows only the Slice files.

Start the driver first, for instance with a simulated plane: `vencejo sim` and `vencejo serve --link tcp:127.0.0.1:5760 --ice`. Environment variables, such as `ardrone_pose3d`, hold other proxies.
"""

import os
import sys
from pathlib import Path

import Ice

SLICES = Path(__file__).resolve().parents[2] / "slice"
files = [str(SLICES / "jderobot" / f"{name}.ice") for name in ("pose3d", "navdata", "ardroneextra", "mission")]
Ice.loadSlice("", ["--all", f"-I{SLICES}", *files])
import jderobot  # noqa: E402 - Ice has just made it

ANSWERS = ["it flies", "bad pose", "no vehicle", "busy", "not sent", "refused", "no answer", "not GUIDED", "other"]
"""As in docs/jderobot.md. The reason in words is in the driver's terminal, and on its page."""


def main() -> int:
    with Ice.initialize() as communicator:

        def proxy(kind, name, port):
            text = os.environ.get(name, f"{name}:tcp -h 127.0.0.1 -p {port}")
            return kind.checkedCast(communicator.stringToProxy(text))

        pose = proxy(jderobot.Pose3DPrx, "ardrone_pose3d", 9998).getPose3DData()
        navdata = proxy(jderobot.NavdataPrx, "ardrone_navdata", 9996).getNavdata()
        where = "on the ground" if navdata.state == 2 else "not known to be on the ground: nothing is flown from here"
        print(f"at {pose.x:.5f}, {pose.y:.5f}, {pose.z:.0f} m, battery {navdata.batteryPercent:.0f} %, {where}")
        if "--fly" not in sys.argv or navdata.state != 2:  # the mission lands where it begins
            return int("--fly" in sys.argv)
        extra = proxy(jderobot.ArDroneExtraPrx, "ardrone_extra", 9994)
        extra.takeoff()  # the first pose is the take-off
        extra.land()  # the last is the landing
        places = [(0.0, -0.003, 50), (0.004, -0.006, 80), (0.004, 0.006, 80), (0.0, 0.012, 60), (0.0, 0.0, 0)]
        poses = [jderobot.Pose3DData(x=pose.x + dx, y=pose.y + dy, h=height) for dx, dy, height in places]
        answer = proxy(jderobot.MissionPrx, "ardrone_mission", 10008).setMissionData(jderobot.MissionData(poses))
        print(ANSWERS[0] if answer == 0 else f"it does not fly: {ANSWERS[answer]} ({answer})")
        return answer


if __name__ == "__main__":
    sys.exit(main())
