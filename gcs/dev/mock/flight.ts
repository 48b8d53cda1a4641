// A made-up flight as a pure function of time, for working on the app without a server. Nothing here is measured.
import type { MissionProgress, PlanItem, TelemetryGroups } from '../../src/lib/api/types';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600 };
const M_PER_DEG = 111_132;
const RADIUS_M = 240;
const SPEED_M_S = 16.5;
const WIND = { from_deg: 242, speed_m_s: 5.4 };
const DEG = Math.PI / 180;

const at = (north_m: number, east_m: number) => ({
  lat_deg: HOME.lat_deg + north_m / M_PER_DEG,
  lon_deg: HOME.lon_deg + east_m / (M_PER_DEG * Math.cos(HOME.lat_deg * DEG)),
});

function item(command: number, name: string, north_m: number, east_m: number, alt_m: number, p1 = 0, p3 = 0): PlanItem {
  const { lat_deg, lon_deg } = at(north_m, east_m);
  return { command, name, frame: 3, params: [p1, 0, p3, 0, lat_deg, lon_deg, alt_m], autocontinue: true };
}

export const mission: PlanItem[] = [
  item(22, 'NAV_TAKEOFF', 0, 120, 60, 12),
  item(16, 'NAV_WAYPOINT', 240, 300, 90),
  item(16, 'NAV_WAYPOINT', 520, 60, 110),
  item(18, 'NAV_LOITER_TURNS', 300, -320, 110, 2, 80),
  item(16, 'NAV_WAYPOINT', -60, -420, 80),
  item(16, 'NAV_WAYPOINT', -40, -200, 40),
  item(21, 'NAV_LAND', 0, 0, 0),
];

export const home = HOME;

/** Small movements that look like air, the same at the same time. */
const wobble = (t: number, seed: number): number =>
  0.5 * Math.sin(t * 1.3 + seed) + 0.3 * Math.sin(t * 2.9 + 2 * seed) + 0.2 * Math.sin(t * 7.7 + 3 * seed);

/** Everything the vehicle would say at `t` seconds; `offset_m` moves a second plane away. */
export function telemetryAt(
  t: number,
  { isArmed = true, offset_m = 0 } = {},
): {
  groups: TelemetryGroups;
  progress: MissionProgress;
} {
  const angle = (t * SPEED_M_S) / RADIUS_M;
  const isMoving = isArmed ? 1 : 0;
  const place = isArmed ? at(260 + RADIUS_M * Math.cos(angle), offset_m + RADIUS_M * Math.sin(angle)) : at(0, offset_m);
  const course_rad = angle + Math.PI / 2;
  const alt_rel_home_m = isArmed ? 92 + 18 * Math.sin(t / 14) : 0.1;
  const climb_m_s = isMoving * ((18 / 14) * Math.cos(t / 14) + 0.2 * wobble(t, 1));
  const roll_rad = isMoving * (0.17 + 0.13 * wobble(t, 2));
  const pitch_rad = isMoving * (0.05 + 0.03 * wobble(t, 3)) + climb_m_s * 0.04;
  const heading_deg = ((((course_rad + 0.12) / DEG) % 360) + 360) % 360;
  const groundspeed_m_s = isMoving * (SPEED_M_S + 3 * Math.cos(course_rad));
  const airspeed_m_s = isMoving * (SPEED_M_S + 0.6 * wobble(t, 4));
  const north_m_s = groundspeed_m_s * Math.cos(course_rad);
  const east_m_s = groundspeed_m_s * Math.sin(course_rad);
  const used = Math.min(t / 1400, 0.9);
  const voltage_v = 12.5 - 1.4 * used + 0.05 * wobble(t, 5);
  const index = isArmed ? 2 + (Math.floor(t / 25) % 5) : 1;
  const group = { age_s: 0, has_invalid: false };
  const imu = {
    ...group,
    acc_g: [0.02 * wobble(t, 6), 0.05 * wobble(t, 7), -1 / Math.cos(roll_rad) + 0.04 * wobble(t * 3, 8)] as [
      number,
      number,
      number,
    ],
    gyro_rad_s: [0.15 * wobble(t, 9), 0.06 * wobble(t, 10), isMoving * 0.069 + 0.02 * wobble(t, 11)] as [
      number,
      number,
      number,
    ],
    mag_gauss: [0.25 * Math.cos(heading_deg * DEG), -0.25 * Math.sin(heading_deg * DEG), 0.37] as [
      number,
      number,
      number,
    ],
    temperature_c: 41 + 0.1 * wobble(t / 9, 12),
  };
  const battery = {
    ...group,
    id: 0,
    voltage_v,
    current_a: isMoving * (7 + 1.4 * wobble(t, 13)) + 0.3,
    consumed_mah: 2200 * used,
    consumed_j: null,
    remaining_pct: Math.round(100 * (1 - used)),
    temperature_c: null,
    time_remaining_s: null,
  };
  return {
    groups: {
      heartbeat: {
        ...group,
        mode: isArmed ? 'AUTO' : 'FBWA',
        mode_number: isArmed ? 10 : 5,
        is_armed: isArmed,
        system_status: isArmed ? 'active' : 'standby',
        mav_type: 1,
        autopilot: 3,
      },
      attitude: {
        ...group,
        roll_rad,
        pitch_rad,
        yaw_rad: heading_deg * DEG,
        roll_rate_rad_s: 0,
        pitch_rate_rad_s: 0,
        yaw_rate_rad_s: isMoving * (SPEED_M_S / RADIUS_M),
      },
      position: {
        ...group,
        ...place,
        alt_amsl_m: HOME.alt_amsl_m + alt_rel_home_m,
        alt_rel_home_m,
        velocity_north_m_s: north_m_s,
        velocity_east_m_s: east_m_s,
        velocity_down_m_s: -climb_m_s,
        heading_deg,
      },
      hud: {
        ...group,
        airspeed_m_s,
        groundspeed_m_s,
        heading_deg,
        throttle_pct: isMoving * Math.round(46 + 5 * wobble(t, 14)),
        alt_amsl_m: HOME.alt_amsl_m + alt_rel_home_m,
        climb_m_s,
      },
      gps: {
        ...group,
        fix: 3,
        fix_name: '3D fix',
        satellites: 14,
        hdop: 0.82,
        vdop: 1.3,
        ...place,
        alt_amsl_m: HOME.alt_amsl_m + alt_rel_home_m,
        alt_ellipsoid_m: HOME.alt_amsl_m + alt_rel_home_m + 51.2,
        groundspeed_m_s,
        course_deg: ((((course_rad / DEG) % 360) + 360) % 360) * isMoving,
        horizontal_accuracy_m: 0.9,
        vertical_accuracy_m: 1.4,
      },
      sys_status: {
        ...group,
        is_ready_to_arm: !isArmed ? false : true,
        unhealthy_sensors: [],
        load_pct: 23.4,
        voltage_v,
        current_a: battery.current_a,
        battery_remaining_pct: battery.remaining_pct,
        drop_rate_pct: 0,
      },
      imu,
      imus: [imu, null, null],
      batteries: [battery],
      pressure: {
        ...group,
        absolute_pa: 94_300 - 11 * alt_rel_home_m + 4 * wobble(t, 15),
        differential_pa: 0.6 * airspeed_m_s ** 2,
        temperature_c: 21.5 - 0.006 * alt_rel_home_m,
      },
      wind: {
        ...group,
        from_deg: WIND.from_deg + 6 * wobble(t / 5, 16),
        speed_m_s: WIND.speed_m_s + 0.8 * wobble(t / 3, 17),
        speed_down_m_s: 0,
      },
      home: { ...group, ...HOME },
      mission: { ...group, seq: index, total: mission.length, state: isArmed ? 'active' : 'not started' },
      nav: {
        ...group,
        nav_roll_deg: roll_rad / DEG,
        nav_pitch_deg: pitch_rad / DEG,
        nav_bearing_deg: heading_deg - 180,
        target_bearing_deg: heading_deg - 170,
        wp_distance_m: 260 - (t % 25) * 10,
        alt_error_m: 2 * wobble(t, 18),
        airspeed_error_m_s: 0.3,
        cross_track_error_m: 6 * wobble(t / 4, 19),
      },
      extended: { ...group, landed: isArmed ? 'in air' : 'on ground', vtol: null },
      vibration: {
        ...group,
        vibration_m_s2: [8 + 2 * wobble(t, 20), 7 + 2 * wobble(t, 21), 14 + 3 * wobble(t, 22)],
        clipping: [0, 0, 0],
      },
      version: { ...group, flight_sw: '4.6.3', git_hash: '3fc7011a', capabilities: 0, uid: null },
      system_time: { ...group, utc_us: null, boot_ms: Math.round((t + 95) * 1000) },
      fence: { ...group, is_breached: false, breach_count: 0, breach_type: 0 },
    },
    progress: {
      follows_mission: isArmed,
      is_landing: false,
      turn_rate_deg_s: null,
      item: index,
      total: mission.length,
      reached: Array.from({ length: index - 1 }, (_, n) => n + 1),
      is_complete: false,
      distance_m: isArmed ? 2860 - (t % 125) * 14 : null,
      time_s: isArmed ? 174 - (t % 125) : null,
      leg_distance_m: isArmed ? 260 - (t % 25) * 10 : null,
      circled_turns: null,
      circled_s: null,
      target_off_m: null,
      preparation: null,
    },
  };
}
