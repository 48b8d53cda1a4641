// A JdeRobot client in JavaScript: shows where the plane is and, with --fly, has it fly a mission. Knows only the Slice files.
// `npm install && npm run slices` first; start the driver as client.py says.
"use strict";
const { Ice } = require("ice");
const { jderobot } = ["pose3d", "navdata", "ardroneextra", "mission"].map((name) => require(`jderobot/${name}`)).pop();

/** As in docs/jderobot.md. The reason in words is in the driver's terminal, and on its page. */
const ANSWERS = [
  "it flies",
  "a bad pose, or a mission that the checks refuse",
  "no vehicle is heard",
  "another mission or transfer is in progress",
  "the mission could not be sent or verified",
  "the vehicle refused, for example arming",
  "the vehicle did not answer",
  "the vehicle must be in GUIDED",
  "something else",
];

async function main(communicator) {
  const proxy = (kind, name, port) => {
    const text = process.env[name] ?? `${name}:tcp -h 127.0.0.1 -p ${port}`;
    return kind.checkedCast(communicator.stringToProxy(text));
  };
  const pose = await (await proxy(jderobot.Pose3DPrx, "ardrone_pose3d", 9998)).getPose3DData();
  const navdata = await (await proxy(jderobot.NavdataPrx, "ardrone_navdata", 9996)).getNavdata();
  const ground = navdata.state === 2 ? "on the ground" : "not known to be on the ground: nothing is flown from here";
  const where = `${pose.x.toFixed(5)}, ${pose.y.toFixed(5)}, ${pose.z.toFixed(0)} m`;
  console.log(`at ${where}, battery ${navdata.batteryPercent.toFixed(0)} %, ${ground}`);
  const flies = process.argv.includes("--fly");
  if (!flies || navdata.state !== 2) return Number(flies); // the mission lands where it begins
  const extra = await proxy(jderobot.ArDroneExtraPrx, "ardrone_extra", 9994);
  for (const mark of ["takeoff", "land"]) await extra[mark](); // the first pose is the take-off, the last the landing
  const places = [[0, -0.003, 50], [0.004, -0.006, 80], [0.004, 0.006, 80], [0, 0.012, 60], [0, 0, 0]];
  const poses = places.map(([dx, dy, h]) => new jderobot.Pose3DData(pose.x + dx, pose.y + dy, 0, h));
  const mission = await proxy(jderobot.MissionPrx, "ardrone_mission", 10008);
  const answer = await mission.setMissionData(new jderobot.MissionData(poses));
  console.log(answer === 0 ? ANSWERS[0] : `it does not fly: ${ANSWERS[answer]} (${answer})`);
  return answer;
}

const communicator = Ice.initialize();
main(communicator)
  .then((answer) => (process.exitCode = answer))
  .finally(() => communicator.destroy());
