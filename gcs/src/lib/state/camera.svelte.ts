// The cameras, and their window: which one it shows, where it lies, and whether video and map have changed places.
import { cameraApi, type CameraInfo } from '$lib/api/camera';
import { clampBox, readBox, type Box } from '$lib/domain/window-box';
import { load, save } from './stored';

export type { CameraInfo };

interface Kept {
  isOpen: boolean;
  name: string | null;
  box: Box;
}

const defaults: Kept = { isOpen: false, name: null, box: { x: 420, y: 96, width: 400, height: 344 } };

function read(value: unknown): Kept | null {
  if (typeof value !== 'object' || value === null) return null;
  const { isOpen, name, box } = value as Record<string, unknown>;
  const known = readBox(box);
  return known && { isOpen: isOpen === true, name: typeof name === 'string' ? name : null, box: known };
}

class Cameras {
  #kept = $state.raw<Kept>(load('camera', defaults, read));
  #isSwapped = $state(false);
  list = $state.raw<readonly CameraInfo[]>([]);
  /** Whether there is recorded footage; requested only when there is no camera. */
  hasFootage = $state(false);

  /** The one that is shown: the chosen one while it is there, else the first. */
  selected = $derived<CameraInfo | null>(
    this.list.find(({ name }) => name === this.#kept.name) ?? this.list[0] ?? null,
  );
  /** Whether there is anything to show. */
  isAny = $derived(this.list.length > 0 || this.hasFootage);
  isOpen = $derived(this.#kept.isOpen && this.isAny);
  /** Whether the video fills the window, and the map is the small one. */
  isSwapped = $derived(this.isOpen && this.#isSwapped);
  box = $derived<Box>(this.#kept.box);

  /** Fetches the list of cameras. On failure it stays as it was; the lost connection is shown elsewhere. */
  async refresh(): Promise<void> {
    try {
      this.list = await cameraApi.list();
      if (this.list.length === 0) this.hasFootage = (await cameraApi.footage()).length > 0;
    } catch {
      // The next connection asks again.
    }
  }

  toggle(): void {
    this.#isSwapped = false;
    this.#set({ isOpen: !this.isOpen });
    if (this.isOpen) void this.refresh();
  }

  close(): void {
    this.#isSwapped = false;
    this.#set({ isOpen: false });
  }

  select(name: string): void {
    this.#set({ name });
  }

  swap(): void {
    this.#isSwapped = !this.#isSwapped;
  }

  /** The newest state of one camera. */
  update(info: CameraInfo): void {
    this.list = this.list.map((camera) => (camera.name === info.name ? info : camera));
  }

  /** Moves the window to `box`, inside a room of this size. */
  place(box: Box, width: number, height: number): void {
    this.#set({ box: clampBox(box, width, height) });
  }

  #set(change: Partial<Kept>): void {
    this.#kept = { ...this.#kept, ...change };
    save('camera', this.#kept);
  }
}

export const cameras = new Cameras();
