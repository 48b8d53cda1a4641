// The plan between the editor and files, which the core reads and writes.
import type { PlanFileFormat, PlanFileNote } from '$lib/api/types';
import { plan } from './plan.svelte';
import { api, problemFrom } from './station.svelte';

class PlanFiles {
  /** What the file that was read or written last leaves to say. */
  notes = $state.raw<readonly PlanFileNote[]>([]);

  async loadFile(file: File): Promise<boolean> {
    try {
      plan.problem = null;
      this.notes = [];
      const { plan: read, notes } = await api.parsePlan(file.name, file);
      plan.replace(read);
      this.notes = notes;
      return true;
    } catch (error) {
      plan.problem = problemFrom(error);
      return false;
    }
  }

  async fileOf(as: PlanFileFormat): Promise<Blob | null> {
    try {
      plan.problem = null;
      await plan.settled;
      const { file, notes } = await api.formatPlan(plan.asApi(), as);
      this.notes = notes;
      return file;
    } catch (error) {
      plan.problem = problemFrom(error);
      return null;
    }
  }
}

export const planFiles = new PlanFiles();
