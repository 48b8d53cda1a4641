// Many vehicles for the mock: circles beside each other; of each fifty, some need attention.
import type { RosterRow } from '../../src/lib/domain/roster';

const MODES = ['AUTO', 'AUTO', 'AUTO', 'LOITER', 'AUTO', 'RTL'];

/** The row of a vehicle far away, counted from 0, at a time. */
export function fleetRow(index: number, count: number, t_s: number): RosterRow {
  const of = index % 50;
  const isLost = of === 7;
  const isFlying = of !== 9;
  const side = Math.ceil(Math.sqrt(count));
  const angle = t_s / 20 + index;
  const name = `plane${String(index).padStart(String(count).length, '0')}`;
  return {
    id: 300 + index,
    remote_name: name,
    is_recorded: false,
    mav_type: 1,
    mode: isFlying ? (MODES[index % MODES.length] ?? 'AUTO') : 'MANUAL',
    is_armed: isFlying,
    is_on_ground: !isFlying,
    lat_deg: 40.3332 + Math.floor(index / side) * 0.009 + (isFlying ? 0.003 * Math.cos(angle) : 0),
    lon_deg: -3.7978 + (index % side) * 0.012 + (isFlying ? 0.004 * Math.sin(angle) : 0),
    alt_rel_home_m: isFlying ? 80 + (index % 9) * 10 : 0,
    heading_deg: ((angle * 180) / Math.PI + 90) % 360,
    airspeed_m_s: isFlying ? 17 + (index % 5) : 0,
    battery_pct: of === 3 ? 12 : of === 11 ? 27 : 95 - (index % 60),
    heard_s: isLost ? Math.min(t_s, 214) : of === 5 ? t_s - 4 : t_s - 0.2,
    loss_pct: null,
    is_reached: null,
    is_contested: false,
    silence: null,
    holder: of === 10 ? 'Field team' : index % 4 === 0 ? 'Mock' : null,
    is_held_here: of !== 10 && index % 4 === 0,
    requested_by: of === 4 ? 'tower · Ana' : null,
    is_requested_here: false,
    is_revoked: false,
    item: 1 + (index % 24),
    items: 24,
    is_complete: false,
    target_off_m: of === 8 ? 340 : null,
    may_be_mixed: of === 6,
    alarm: of === 2 ? { severity: 2, text: 'EKF3 lane switch 1', time_s: t_s - 3 } : null,
  };
}
