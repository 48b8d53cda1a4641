// The selected camera's picture on a canvas: one stream for as long as it is looked at, its age, and how it is.
import { CameraStream } from '$lib/api/camera';
import { ServerClock } from '$lib/domain/server-clock';
import { cameras } from '$lib/state/camera.svelte';
import { clock } from '$lib/state/clock.svelte';
import { Player, showsH264, wipe } from './player';

/** Older pictures are marked as late. */
const LATE_S = 1.0;

type Condition = 'away' | 'none' | 'starting' | 'live' | 'late' | 'stalled' | 'dead';

/** To be made in a component: its effects end with that. */
export class LivePicture {
  #canH264 = $state<boolean | null>(null);
  #isConnected = $state(false);
  /** A hidden page needs no pictures. */
  #isVisible = $state(document.visibilityState === 'visible');
  #shown_unix_us = $state.raw<number | null>(null);
  readonly #clock = new ServerClock();
  /** When the server's time was last received; ages are computed again then. */
  #heard_ms = $state(0);
  /** The camera whose picture is on the canvas. */
  #pictured: string | null = null;

  /** `null` without a picture. */
  age_s = $derived(
    this.#shown_unix_us === null
      ? null
      : this.#clock.age_s(this.#shown_unix_us / 1000, Math.max(clock.now_ms, this.#heard_ms)),
  );
  condition = $derived.by<Condition>(() => {
    const camera = cameras.selected;
    if (camera === null) return 'none';
    if (!this.#isConnected) return 'away';
    if (camera.state === 'live') {
      if (this.age_s === null) return 'starting';
      return this.age_s > LATE_S ? 'late' : 'live';
    }
    // It is being opened, because we look.
    return camera.state === 'standby' ? 'starting' : camera.state;
  });
  isOld = $derived(this.#shown_unix_us !== null && this.condition !== 'live');
  #name = $derived(cameras.selected?.name ?? null);

  constructor(canvas: () => HTMLCanvasElement, cannotDecode: () => void) {
    $effect(() => {
      void showsH264().then((shows) => (this.#canH264 = shows));
      const onVisible = () => (this.#isVisible = document.visibilityState === 'visible');
      document.addEventListener('visibilitychange', onVisible);
      return () => document.removeEventListener('visibilitychange', onVisible);
    });
    $effect(() => this.#play(canvas(), cannotDecode));
  }

  #play(canvas: HTMLCanvasElement, cannotDecode: () => void): (() => void) | undefined {
    const name = this.#name;
    if (name !== this.#pictured) {
      // the last picture of one camera must not stand under the name of another
      wipe(canvas);
      this.#shown_unix_us = null;
      this.#pictured = name;
    }
    const canH264 = this.#canH264;
    if (name === null || canH264 === null || !this.#isVisible) return undefined;
    const player = new Player(canvas, {
      shown: (captured_unix_us) => (this.#shown_unix_us = captured_unix_us),
      cannotDecode: () => {
        this.#canH264 = false;
        cannotDecode();
      },
    });
    const stream = new CameraStream(name, canH264, {
      picture: (picture) => player.push(picture),
      camera: (info) => cameras.update(info),
      time: (unix_ms) => {
        this.#heard_ms = performance.now();
        this.#clock.hear(unix_ms, this.#heard_ms);
      },
      connected: (isThere) => {
        this.#isConnected = isThere;
        if (!isThere) void cameras.refresh();
      },
    });
    return () => {
      stream.close();
      player.close();
      this.#isConnected = false;
    };
  }
}
