// The shapes that go over the API, under the names the app uses. Units and datum stand in the names;
// what is not known is null.

/** What every telemetry group has in common. */
export interface Group {
  /** How long ago the message had arrived when this was sent, in seconds. */
  age_s: number;
  /** Whether the message held a value that cannot be; such fields are null. */
  has_invalid: boolean;
}

export interface Heartbeat extends Group {
  mode: string;
  mode_number: number;
  is_armed: boolean;
  system_status: string;
  mav_type: number;
  autopilot: number;
}

/** Body (forward, right, down) in the local frame (north, east, down), Tait-Bryan ZYX. */
export interface Attitude extends Group {
  roll_rad: number | null;
  pitch_rad: number | null;
  yaw_rad: number | null;
  roll_rate_rad_s: number | null;
  pitch_rate_rad_s: number | null;
  yaw_rate_rad_s: number | null;
}

export interface Position extends Group {
  lat_deg: number | null;
  lon_deg: number | null;
  alt_amsl_m: number | null;
  alt_rel_home_m: number | null;
  velocity_north_m_s: number | null;
  velocity_east_m_s: number | null;
  velocity_down_m_s: number | null;
  heading_deg: number | null;
}

export interface Hud extends Group {
  airspeed_m_s: number | null;
  groundspeed_m_s: number | null;
  heading_deg: number | null;
  throttle_pct: number | null;
  alt_amsl_m: number | null;
  climb_m_s: number | null;
}

export interface Gps extends Group {
  fix: number;
  fix_name: string;
  satellites: number | null;
  hdop: number | null;
  vdop: number | null;
  lat_deg: number | null;
  lon_deg: number | null;
  alt_amsl_m: number | null;
  groundspeed_m_s: number | null;
  course_deg: number | null;
  horizontal_accuracy_m: number | null;
  vertical_accuracy_m: number | null;
}

export interface SysStatus extends Group {
  is_ready_to_arm: boolean | null;
  unhealthy_sensors: string[];
  load_pct: number | null;
  voltage_v: number | null;
  current_a: number | null;
  battery_remaining_pct: number | null;
  drop_rate_pct: number | null;
}

export interface Battery extends Group {
  id: number;
  voltage_v: number | null;
  current_a: number | null;
  consumed_mah: number | null;
  consumed_j: number | null;
  remaining_pct: number | null;
  temperature_c: number | null;
  time_remaining_s: number | null;
}

export type Triple<T = number> = [T, T, T];

/** Body axes forward, right, down. */
export interface Imu extends Group {
  acc_g: Triple | null;
  gyro_rad_s: Triple | null;
  mag_gauss: Triple | null;
  temperature_c: number | null;
}

export interface Pressure extends Group {
  absolute_pa: number | null;
  differential_pa: number | null;
  temperature_c: number | null;
}

export interface Wind extends Group {
  /** Where the wind comes from. */
  from_deg: number | null;
  speed_m_s: number | null;
  speed_down_m_s: number | null;
}

export interface HomePosition extends Group {
  lat_deg: number;
  lon_deg: number;
  alt_amsl_m: number;
}

export interface MissionCurrent extends Group {
  /** Item in execution; on ArduPilot 0 is home. */
  seq: number;
  total: number | null;
  state: string | null;
}

export interface NavController extends Group {
  nav_roll_deg: number | null;
  nav_pitch_deg: number | null;
  nav_bearing_deg: number | null;
  target_bearing_deg: number | null;
  wp_distance_m: number | null;
  alt_error_m: number | null;
  airspeed_error_m_s: number | null;
  cross_track_error_m: number | null;
}

export interface ExtendedState extends Group {
  landed: string;
  vtol: number | null;
}

export interface Ekf extends Group {
  flags: number;
  velocity_variance: number | null;
  pos_horiz_variance: number | null;
  pos_vert_variance: number | null;
  compass_variance: number | null;
  terrain_alt_variance: number | null;
}

export interface Vibration extends Group {
  vibration_m_s2: Triple<number | null>;
  clipping: Triple;
}

export interface AutopilotVersion extends Group {
  flight_sw: string;
  git_hash: string;
  capabilities: number;
  uid: number | null;
}

export interface Radio extends Group {
  rssi: number | null;
  remote_rssi: number | null;
  noise: number | null;
  remote_noise: number | null;
  tx_buffer_pct: number | null;
  rx_errors: number;
  fixed: number;
}

export interface AirspeedSensor extends Group {
  id: number;
  airspeed_m_s: number | null;
  differential_pa: number | null;
  temperature_c: number | null;
  is_unhealthy: boolean;
  is_used: boolean;
}

export interface ServoOutputs extends Group {
  pulse_us: (number | null)[];
}

export interface RcChannels extends Group {
  count: number;
  pulse_us: (number | null)[];
  rssi: number | null;
}

export interface SystemTime extends Group {
  utc_us: number | null;
  boot_ms: number;
}

export interface FenceStatus extends Group {
  is_breached: boolean;
  breach_count: number;
  breach_type: number;
}

/** All groups by name; a group is absent until the vehicle has sent it. */
export interface TelemetryGroups {
  heartbeat?: Heartbeat;
  attitude?: Attitude;
  position?: Position;
  hud?: Hud;
  gps?: Gps;
  sys_status?: SysStatus;
  imu?: Imu;
  pressure?: Pressure;
  wind?: Wind;
  home?: HomePosition;
  mission?: MissionCurrent;
  nav?: NavController;
  extended?: ExtendedState;
  ekf?: Ekf;
  vibration?: Vibration;
  version?: AutopilotVersion;
  radio?: Radio;
  airspeed?: AirspeedSensor;
  servos?: ServoOutputs;
  rc?: RcChannels;
  system_time?: SystemTime;
  fence?: FenceStatus;
  /** Inertial sensors 1 to 3; the first is `imu`. */
  imus?: (Imu | null)[];
  /** The batteries heard so far. */
  batteries?: Battery[];
}
/** What changed of the groups; null for one that the vehicle no longer has, as after a reboot. */
export type TelemetryChanges = { [Name in keyof TelemetryGroups]?: TelemetryGroups[Name] | null };
export type GroupName = keyof TelemetryGroups;

export interface MissionProgress {
  /** Item in execution, counted from 1 as a plan's items are. */
  item: number | null;
  total: number | null;
  reached: number[];
  is_complete: boolean;
  distance_m: number | null;
  time_s: number | null;
  leg_distance_m: number | null;
}

export type PlanKind = 'mission' | 'fence' | 'rally';

/** What is known of a plan on board; only a read-back makes it known. */
export interface PlanState {
  state: 'unknown' | 'empty' | 'verified';
  count: number | null;
  hash: string | null;
  detail: string;
}

export interface LinkInfo {
  id: number;
  name: string;
  address: string;
  local_address: string | null;
  state: 'connecting' | 'up' | 'down' | 'ended';
  detail: string | null;
  /** Whether frames between it and the other links are passed on. */
  forward: boolean;
  frames_received: number;
  frames_sent: number;
  bytes_received: number;
  bytes_sent: number;
  bad_crc: number;
  garbage_bytes: number;
  frames_lost: number;
  loss_pct: number | null;
  round_trip_ms: number | null;
  age_s: number | null;
  frames_per_s: number;
  /** Share of the frames that were lost lately. */
  recent_loss_pct: number | null;
}

export interface VehicleSummary {
  system_id: number;
  mav_type: number | null;
  autopilot: number | null;
  mode: string | null;
  is_armed: boolean | null;
  age_s: number | null;
  /** Id of the link that it is reached over. */
  link: number | null;
  loss_pct: number | null;
  round_trip_ms: number | null;
}

export interface VehicleState {
  system_id: number;
  /** On the station's clock. */
  time_s: number;
  telemetry: TelemetryGroups;
  progress: MissionProgress;
  plan_states: Record<PlanKind, PlanState>;
  mode_names: string[];
  /** The link that it is reached over, with the vehicle's own counters. */
  link: LinkInfo | null;
}

/** RFC 9457, with the vehicle's reasons and what to do. */
export interface Problem {
  type?: string;
  title: string;
  status: number;
  detail: string;
  reasons?: string[];
  remedy?: string;
}

export interface LatLon {
  lat_deg: number;
  lon_deg: number;
}

export interface PlanItem {
  /** MAV_CMD number and name. */
  command: number;
  name: string;
  /** MAV_FRAME: 0 above sea level, 3 above home, 10 above terrain. */
  frame: number;
  /** x, y, z (degrees, degrees, metres for a command with a position) are params[4] to params[6]. */
  params: [number | null, number | null, number | null, number | null, number | null, number | null, number | null];
  autocontinue: boolean;
}

export interface Home extends LatLon {
  alt_amsl_m: number;
}

export interface FenceZone {
  inclusion: boolean;
  shape: 'polygon' | 'circle';
  points: LatLon[];
  radius_m: number | null;
}

export interface ReturnPoint extends LatLon {
  alt_rel_home_m: number;
}

export interface Fence {
  zones: FenceZone[];
  return_point: ReturnPoint | null;
}

export interface RallyPoint extends LatLon {
  alt_m: number;
  frame: number;
}

export interface Plan {
  items: PlanItem[];
  home: Home | null;
  fence: Fence;
  rally: RallyPoint[];
}

export interface PlanFinding {
  severity: 'error' | 'warning';
  code: string;
  /** From 1; null for the whole plan. */
  item: number | null;
  message: string;
  remedy: string;
}

export interface CommandParam {
  /** Empty when the command does not use the parameter. */
  label: string;
  /** Empty when there is none. */
  unit: string;
  min: number | null;
  max: number | null;
  default: number | null;
}

export interface CommandInfo {
  number: number;
  name: string;
  title: string;
  category: 'nav' | 'condition' | 'do' | 'fence' | 'rally';
  support: 'flown' | 'needs_vtol' | 'ignored' | 'list';
  has_position: boolean;
  is_destination: boolean;
  /** Parameters 1 to 7. */
  params: CommandParam[];
}

export interface Operation<Result = unknown> {
  id: number;
  vehicle: number;
  kind: string;
  state: 'running' | 'done' | 'failed' | 'cancelled';
  done: number;
  total: number;
  error?: Problem;
  result?: Result;
}

export interface Session {
  session: string;
  name: string;
  role: 'viewer' | 'operator';
  has_control: boolean;
  holder: string | null;
  /** Who asks for control. */
  requested_by: string | null;
}

export interface Info {
  name: string;
  version: string;
  needs_token: boolean;
}

export interface StatusText {
  /** MAV_SEVERITY: 0 emergency to 7 debug. */
  severity: number;
  text: string;
  time_s: number;
}

export interface Parameter {
  name: string;
  value: number;
  /** Its type on the wire: `int8` … `real32`. */
  kind: string;
}

export type ServerMessage =
  | ({ type: 'hello'; version: string; time_s: number } & Session)
  | { type: 'vehicles'; vehicles: VehicleSummary[] }
  | {
      type: 'telemetry';
      vehicle: number;
      time_s: number;
      groups: TelemetryChanges;
      progress?: MissionProgress;
    }
  | ({ type: 'text'; vehicle: number } & StatusText)
  | { type: 'event'; vehicle: number; kind: string; detail: Record<string, string | number>; time_s: number }
  | { type: 'plan_state'; vehicle: number; kind: PlanKind; state: PlanState }
  | ({ type: 'operation' } & Operation)
  | { type: 'links'; links: LinkInfo[] }
  | { type: 'control'; has_control: boolean; holder: string | null; requested_by: string | null }
  | { type: 'error'; detail: string };

export type ClientMessage =
  { type: 'subscribe'; vehicle: number; rate_hz: number } | { type: 'unsubscribe'; vehicle: number };
