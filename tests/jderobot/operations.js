// Calls every operation of every interface from JavaScript: `node operations.js NAME=PROXY…`. It says "called Interface.operation" for
// each, and ends with an error where an answer is not what it should be. Knows only what slice2js made of the Slice files.
"use strict";
const assert = require("node:assert/strict");
const { Ice } = require("ice");
const files = ["camera", "pose3d", "navdata", "ardroneextra", "cmdvel", "mission"];
const { jderobot } = files.map((name) => require(`jderobot/${name}`)).pop();
const { vencejo } = require("vencejo/vencejo");

const proxies = Object.fromEntries(process.argv.slice(2).map((text) => text.split(/=(.*)/s).slice(0, 2)));

async function main(communicator) {
  const proxy = (type, text) => type.checkedCast(communicator.stringToProxy(text));
  const precise = (name) => proxies.Precise.replace("_telemetry", `_${name}`);
  const objects = {
    Pose3D: await proxy(jderobot.Pose3DPrx, proxies.Pose3D),
    Navdata: await proxy(jderobot.NavdataPrx, proxies.Navdata),
    ArDroneExtra: await proxy(jderobot.ArDroneExtraPrx, proxies.Extra),
    CMDVel: await proxy(jderobot.CMDVelPrx, proxies.CMDVel),
    Mission: await proxy(jderobot.MissionPrx, proxies.Mission),
    ImageProvider: await proxy(jderobot.CameraPrx, proxies.Camera),
    Camera: await proxy(jderobot.CameraPrx, proxies.Camera),
    Telemetry: await proxy(vencejo.TelemetryPrx, precise("telemetry")),
    Missions: await proxy(vencejo.MissionsPrx, precise("missions")),
    Control: await proxy(vencejo.ControlPrx, precise("control")),
  };
  const call = async (name, ...parameters) => {
    const [type, operation] = name.split(".");
    console.log(`called ${name}`);
    return objects[type][operation](...parameters);
  };
  const refused = async (kind, name, ...parameters) => {
    await assert.rejects(
      () => call(name, ...parameters),
      (error) => error instanceof kind,
    );
  };
  const near = (value, wanted, by) => assert.ok(Math.abs(value - wanted) <= by, `${value} is not near ${wanted}`);

  const pose = await call("Pose3D.getPose3DData");
  near(pose.x, 40.3332, 1e-3);
  near(pose.q0 ** 2 + pose.q1 ** 2 + pose.q2 ** 2 + pose.q3 ** 2, 1, 1e-5);
  assert.equal(await call("Pose3D.setPose3DData", pose), 7);
  const navdata = await call("Navdata.getNavdata");
  assert.equal(navdata.state, 2);
  assert.equal(navdata.vehicle, 1);
  assert.equal(await call("CMDVel.setCMDVelData", new jderobot.CMDVelData(1, 0, 0, 0, 0, 0)), 7);
  await call("ArDroneExtra.takeoff");
  await call("ArDroneExtra.land");
  await call("ArDroneExtra.toggleCam");
  await call("ArDroneExtra.recordOnUsb", false);
  await call("ArDroneExtra.ledAnimation", 1, 1, 1);
  await call("ArDroneExtra.flightAnimation", 1, 1);
  await call("ArDroneExtra.flatTrim");
  await call("ArDroneExtra.reset");
  await call("Mission.getMissionData");
  assert.equal(await call("Mission.setMissionData", new jderobot.MissionData([])), 1);
  assert.equal(await call("Mission.setMissionData", new jderobot.MissionData([new jderobot.Pose3DData(NaN, 0, 0, 50)])), 1);
  assert.equal((await call("ImageProvider.getImageFormat"))[0], "RGB8");
  assert.equal((await call("ImageProvider.getImageDescription")).format, "RGB8");
  await refused(jderobot.DataNotExistException, "ImageProvider.getImageData", "RGB8");
  const description = await call("Camera.getCameraDescription");
  assert.equal(await call("Camera.setCameraDescription", description), 0);
  assert.equal(await call("Camera.startCameraStreaming"), "");
  await call("Camera.stopCameraStreaming");
  await call("Camera.reset");

  assert.deepEqual(await call("Telemetry.vehicles"), [1]);
  const fine = await call("Telemetry.getPose", 0);
  near(fine.latDeg, 40.3332, 1e-3);
  assert.ok(fine.at.bootS > 0);
  assert.equal((await call("Telemetry.getNavigation", 0)).isArmed, false);
  await refused(vencejo.NoVehicle, "Telemetry.getPose", 99);
  await refused(vencejo.InvalidRequest, "Telemetry.subscribe", 0, null, 1);

  // A client behind a router, or a browser, is called back over its own connection.
  const heard = new Set();
  const pushed = new Promise((resolve) => {
    const hear = (what) => {
      heard.add(what);
      if (heard.size === 2) {
        resolve();
      }
    };
    class Watcher extends vencejo.Observer {
      moved(pose, navigation) {
        assert.equal(pose.systemId, navigation.systemId);
        hear("moved");
      }
      happened(event) {
        assert.equal(event.systemId, 1);
        hear("happened");
      }
    }
    objects.watcher = new Watcher();
  });
  const adapter = await communicator.createObjectAdapter("");
  adapter.add(objects.watcher, Ice.stringToIdentity("watcher"));
  (await objects.Telemetry.ice_getConnection()).setAdapter(adapter);
  const subscription = await call("Telemetry.subscribeHere", 0, "watcher", 20);
  await call("Control.setMode", 0, "FBWA");
  await pushed;
  console.log(`pushed: ${[...heard].sort().reverse().join(" ")}`);
  await call("Telemetry.unsubscribe", subscription);

  const { MissionPlan } = vencejo.PlanKind;
  const item = (command, x, y, z) => {
    const made = new vencejo.MissionItem(command, 3);
    [made.x, made.y, made.z] = [x, y, z];
    return made;
  };
  const plan = new vencejo.Plan([item(22, 40.3332, -3.7978, 50), item(16, 40.3362, -3.7978, 60)], undefined, [], undefined, []);
  assert.deepEqual((await call("Missions.check", 0, plan)).filter((finding) => finding.isError), []);
  assert.equal((await call("Missions.upload", 0, MissionPlan, plan)).state, "verified");
  assert.equal((await call("Missions.getPlanState", 0, MissionPlan)).count, 2);
  assert.equal((await call("Missions.download", 0, MissionPlan)).items[1].x, 40.3362);
  const wrong = new vencejo.Plan([item(16, 95, 0, 60)], undefined, [], undefined, []);
  await refused(vencejo.PlanRefused, "Missions.upload", 0, MissionPlan, wrong);
  await call("Missions.setCurrentItem", 0, 2);
  assert.equal((await call("Missions.getProgress", 0)).isComplete, false);
  await call("Missions.prepareFlight", 0);
  await call("Missions.start", 0, 1);
  await call("Missions.pause", 0);
  await call("Missions.resume", 0);

  assert.ok((await call("Control.modes", 0)).includes("AUTO"));
  await call("Control.goTo", 0, 40.3342, -3.7978, 60, true);
  await call("Control.flyCourse", 0, 90, 5);
  await call("Control.climbTo", 0, 680, 2);
  await call("Control.setAirspeed", 0, 18);
  await call("Control.setAltitude", 0, 70);
  await refused(vencejo.InvalidRequest, "Control.setVelocity", 0, 1, 0, 0, 0);
  await call("Control.loiter", 0);
  await call("Control.returnToLaunch", 0);
  await call("Control.takeoff", 0, 60);
  await refused(vencejo.InvalidRequest, "Control.land", 0);
  await refused(vencejo.VencejoException, "Control.abortLanding", 0);
  assert.equal(await call("Control.command", 0, 410, []), 0);
  await call("Control.setMode", 0, "MANUAL");
  await call("Control.arm", 0);
  await call("Control.disarm", 0);
  await call("Missions.clear", 0, MissionPlan, new Map([["confirm", "clear-mission"]]));
}

(async () => {
  const communicator = Ice.initialize();
  try {
    await main(communicator);
  } finally {
    await communicator.destroy();
  }
})().catch((error) => {
  console.error(error);
  process.exitCode = 1;
});
