// Draws pictures on a canvas as soon as they are decoded. H.264 by WebCodecs, JPEG by the browser's own decoder; both work
// beside the page's thread. Pictures that come faster than they can be decoded are dropped.
import { h264Codec, type Picture } from '$lib/domain/video';

/** Pictures in the decoder from which on drawing each would only make it later. */
const BUSY = 3;
/** Pictures in the decoder from which on it begins again at the next key frame. */
const OVERRUN = 60;
/** Decoders that end before they show anything until H.264 is given up: a first picture may have come to harm on its way. */
const MAX_FAILURES = 3;

interface PlayerEvents {
  /** A picture is on the canvas. */
  shown(captured_unix_us: number): void;
  /** H.264 cannot be decoded here. */
  cannotDecode(): void;
}

/** Whether this browser decodes H.264: without a secure context (https or localhost) none does. */
export async function showsH264(): Promise<boolean> {
  if (typeof VideoDecoder === 'undefined') return false;
  try {
    const { supported } = await VideoDecoder.isConfigSupported({ codec: 'avc1.64001F' });
    return supported === true;
  } catch {
    return false;
  }
}

/** Takes the last picture off a canvas. */
export function wipe(canvas: HTMLCanvasElement): void {
  // setting the size, even to what it was, empties it
  canvas.width = canvas.width;
}

export class Player {
  readonly #canvas: HTMLCanvasElement;
  readonly #context: CanvasRenderingContext2D | null;
  readonly #events: PlayerEvents;
  #decoder: VideoDecoder | null = null;
  #codec: string | null = null;
  /** Decoders in a row that ended before they showed anything. */
  #failures = 0;
  #needsKey = true;
  /** The newest JPEG picture that waits for the one before it. */
  #waiting: Picture | null = null;
  #isDecoding = false;
  #isClosed = false;

  constructor(canvas: HTMLCanvasElement, events: PlayerEvents) {
    this.#canvas = canvas;
    this.#context = canvas.getContext('2d', { alpha: false });
    this.#events = events;
  }

  push(picture: Picture): void {
    if (this.#isClosed) return;
    if (picture.codec === 'h264') this.#decode(picture);
    else if (this.#isDecoding) this.#waiting = picture;
    else void this.#still(picture);
  }

  close(): void {
    this.#isClosed = true;
    this.#drop();
  }

  #decode(picture: Picture): void {
    if (picture.isKey) {
      const codec = h264Codec(picture.data);
      if (codec === null) return;
      const isBehind = (this.#decoder?.decodeQueueSize ?? 0) > OVERRUN;
      if (codec !== this.#codec || isBehind || this.#decoder?.state !== 'configured') this.#configure(codec);
      this.#needsKey = false;
    }
    const decoder = this.#decoder;
    if (decoder === null || decoder.state !== 'configured' || this.#needsKey) return;
    if (decoder.decodeQueueSize > OVERRUN) {
      this.#needsKey = true;
      return;
    }
    const { isKey, captured_unix_us, data } = picture;
    try {
      decoder.decode(new EncodedVideoChunk({ type: isKey ? 'key' : 'delta', timestamp: captured_unix_us, data }));
    } catch {
      // A chunk that is not a key frame makes it throw instead of calling `error`.
      this.#fail(false);
    }
  }

  #configure(codec: string): void {
    this.#drop();
    const decoder = new VideoDecoder({
      output: (frame) => {
        if (decoder === this.#decoder && decoder.decodeQueueSize <= BUSY) {
          this.#draw(frame, frame.displayWidth, frame.displayHeight, frame.timestamp);
        }
        frame.close();
      },
      error: (error) => {
        if (decoder === this.#decoder) this.#fail(error.name === 'NotSupportedError');
      },
    });
    this.#decoder = decoder;
    this.#codec = codec;
    try {
      decoder.configure({ codec, optimizeForLatency: true });
    } catch {
      this.#fail(true);
    }
  }

  /** A decoder failed, as it does at a broken picture; a new one starts at the next key frame. */
  #fail(isHopeless: boolean): void {
    this.#drop();
    this.#failures += 1;
    if (isHopeless || this.#failures >= MAX_FAILURES) this.#events.cannotDecode();
  }

  async #still(picture: Picture): Promise<void> {
    this.#isDecoding = true;
    try {
      const bitmap = await createImageBitmap(new Blob([picture.data], { type: 'image/jpeg' }));
      if (!this.#isClosed) this.#draw(bitmap, bitmap.width, bitmap.height, picture.captured_unix_us);
      bitmap.close();
    } catch {
      // A broken picture: the next one may be whole.
    }
    this.#isDecoding = false;
    const next = this.#waiting;
    this.#waiting = null;
    if (next !== null && !this.#isClosed) void this.#still(next);
  }

  #draw(image: CanvasImageSource, width: number, height: number, captured_unix_us: number): void {
    const canvas = this.#canvas;
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    this.#context?.drawImage(image, 0, 0);
    this.#failures = 0;
    this.#events.shown(captured_unix_us);
  }

  #drop(): void {
    const decoder = this.#decoder;
    this.#decoder = null;
    this.#codec = null;
    this.#needsKey = true;
    if (decoder !== null && decoder.state !== 'closed') decoder.close();
  }
}
