/** Reads a plan back from the browser's storage, which may hold anything. */

import { isLonLat } from './lonlat';
import {
  emptyPlan,
  type Fence,
  type FenceZone,
  type Home,
  type Params,
  type Plan,
  type PlanItem,
  type PlannedFor,
  type RallyPoint,
} from './plan';

/** More items than any vehicle holds. */
const MAX_ITEMS = 10_000;

type Fields = Record<string, unknown>;

const fields = (value: unknown): Fields | null =>
  typeof value === 'object' && value !== null && !Array.isArray(value) ? (value as Fields) : null;
const finite = (value: unknown): value is number => typeof value === 'number' && Number.isFinite(value);

/** The plan in `value`, or `null` when it is invalid. */
export function readPlan(value: unknown): Plan | null {
  const plan = fields(value);
  if (plan === null || !Array.isArray(plan['items']) || plan['items'].length > MAX_ITEMS) return null;
  const items = plan['items'].map(readItem);
  if (items.some((item) => item === null)) return null;
  return {
    items: items as PlanItem[],
    home: readHome(plan['home']),
    fence: readFence(plan['fence']) ?? emptyPlan().fence,
    rally: Array.isArray(plan['rally']) ? plan['rally'].map(readRally).filter((one) => one !== null) : [],
    ...readComplexItems(plan['complex_items']),
    ...readPlannedFor(plan['planned_for']),
  };
}

function readComplexItems(value: unknown): Pick<Plan, 'complex_items'> {
  if (!Array.isArray(value)) return {};
  const read = value.map(fields).flatMap((item) => {
    const { kind, json } = item ?? {};
    return typeof kind === 'string' && typeof json === 'string' ? [{ kind, json }] : [];
  });
  return read.length > 0 ? { complex_items: read } : {};
}

function readPlannedFor(value: unknown): Pick<Plan, 'planned_for'> {
  const planned_for = fields(value);
  if (planned_for === null) return {};
  const number = (key: keyof PlannedFor): number | null => (finite(planned_for[key]) ? planned_for[key] : null);
  const [cruise_speed_m_s, hover_speed_m_s] = [number('cruise_speed_m_s'), number('hover_speed_m_s')];
  const [vehicle_type, firmware_type] = [number('vehicle_type'), number('firmware_type')];
  return { planned_for: { cruise_speed_m_s, hover_speed_m_s, vehicle_type, firmware_type } };
}

function readItem(value: unknown): PlanItem | null {
  const item = fields(value);
  if (item === null) return null;
  const { command, name, frame, params, autocontinue } = item;
  if (!Number.isInteger(command) || typeof name !== 'string' || !Number.isInteger(frame)) return null;
  if (!Array.isArray(params) || params.length !== 7) return null;
  if (!params.every((param) => param === null || finite(param))) return null;
  return {
    command: command as number,
    name,
    frame: frame as number,
    params: [...params] as Params,
    autocontinue: autocontinue !== false,
  };
}

function readHome(value: unknown): Home | null {
  const home = fields(value);
  const at = readPoint(value);
  return home !== null && at !== null && finite(home['alt_amsl_m']) ? { ...at, alt_amsl_m: home['alt_amsl_m'] } : null;
}

function readPoint(value: unknown): { lat_deg: number; lon_deg: number } | null {
  const point = fields(value);
  const [lat_deg, lon_deg] = [point?.['lat_deg'], point?.['lon_deg']];
  return finite(lat_deg) && finite(lon_deg) && isLonLat(lon_deg, lat_deg) ? { lat_deg, lon_deg } : null;
}

function readFence(value: unknown): Fence | null {
  const fence = fields(value);
  if (fence === null || !Array.isArray(fence['zones'])) return null;
  const zones = fence['zones'].map(readZone);
  if (zones.some((zone) => zone === null)) return null;
  return { zones: zones as FenceZone[], return_point: readReturnPoint(fence['return_point']) };
}

function readReturnPoint(value: unknown): Fence['return_point'] {
  const at = readPoint(value);
  const alt_rel_home_m = fields(value)?.['alt_rel_home_m'];
  return at !== null && finite(alt_rel_home_m) ? { ...at, alt_rel_home_m } : null;
}

function readZone(value: unknown): FenceZone | null {
  const zone = fields(value);
  if (zone === null || !Array.isArray(zone['points'])) return null;
  const { inclusion, shape, radius_m } = zone;
  const points = zone['points'].map(readPoint);
  if (points.some((point) => point === null) || (shape !== 'polygon' && shape !== 'circle')) return null;
  return {
    inclusion: inclusion === true,
    shape,
    points: points as FenceZone['points'],
    radius_m: finite(radius_m) ? radius_m : null,
  };
}

function readRally(value: unknown): RallyPoint | null {
  const rally = fields(value);
  const at = readPoint(value);
  if (rally === null || at === null || !finite(rally['alt_m']) || !Number.isInteger(rally['frame'])) return null;
  return { ...at, alt_m: rally['alt_m'], frame: rally['frame'] as number };
}
