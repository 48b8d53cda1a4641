// The plan between the editor and files, which the core reads and writes.
import type { Plan, PlanFileFormat, PlanFileNote, PlanKind, Problem } from '$lib/api/types';
import { isFenceEmpty } from '$lib/domain/area-edit';
import { areas } from './areas.svelte';
import { PLAN_PARTS } from './on-board.svelte';
import { plan } from './plan.svelte';
import { api, problemFrom } from './station.svelte';
import { vehicles } from './vehicles.svelte';

/** Files that hold a mission and never a fence or rally points. */
const MISSION_ALONE = /\.(waypoints|txt|mission|gpx)$/i;

/** The vehicle that a file is written for, where its format names one: that of the file that was opened, else the selected one. */
function plannedFor(format: PlanFileFormat): Pick<Plan, 'planned_for'> {
  const heartbeat = vehicles.selected?.groups.heartbeat;
  if (format !== 'plan' || plan.draft.plannedFor !== null || heartbeat === undefined) return {};
  const { mav_type: vehicle_type, autopilot: firmware_type } = heartbeat;
  return { planned_for: { cruise_speed_m_s: null, hover_speed_m_s: null, vehicle_type, firmware_type } };
}

class PlanFiles {
  /** Notes about the file read or written last. */
  notes = $state.raw<readonly PlanFileNote[]>([]);
  /** Parts of the draft that the file had none of, and that went with the old plan. */
  removed = $state.raw<readonly PlanKind[]>([]);

  /** What went wrong with the file read or written last. */
  problem = $state.raw<Problem | null>(null);

  async loadFile(file: File): Promise<boolean> {
    try {
      this.forgetNotes();
      const { plan: read, notes } = await api.parsePlan(file.name, file);
      const before = PLAN_PARTS.filter((part) => !plan.isEmpty(part));
      this.#take(file.name, read);
      this.notes = notes;
      this.removed = before.filter((part) => plan.isEmpty(part));
      return true;
    } catch (error) {
      this.problem = problemFrom(error);
      return false;
    }
  }

  /** A file of one part takes the place of that part: Mission Planner writes mission, fence and rally points apart. */
  #take(name: string, read: Plan): void {
    const { fence, rally } = read;
    if (read.items.length === 0 && !(isFenceEmpty(fence) && rally.length === 0)) {
      plan.editAreas((old) => ({
        fence: isFenceEmpty(fence) ? old.fence : fence,
        rally: rally.length === 0 ? old.rally : rally,
      }));
      if (!isFenceEmpty(fence)) areas.cancelSketch();
    } else if (MISSION_ALONE.test(name)) {
      const { fence, rally } = plan.draft;
      plan.replace({ ...read, fence, rally: [...rally] });
    } else plan.replace(read);
  }

  forgetNotes(): void {
    this.problem = null;
    this.notes = [];
    this.removed = [];
  }

  async fileOf(as: PlanFileFormat): Promise<Blob | null> {
    try {
      this.problem = null;
      await plan.settled;
      const { file, notes } = await api.formatPlan({ ...plan.asApi(), ...plannedFor(as) }, as);
      this.forgetNotes();
      this.notes = notes;
      return file;
    } catch (error) {
      this.problem = problemFrom(error);
      return null;
    }
  }
}

export const planFiles = new PlanFiles();
