// A bounded series of samples over time, for plots: oldest samples fall out.

/** Columns of numbers that share their times. NaN marks a gap, which is what the plots understand. */
export class Series {
  readonly columns: number;
  readonly capacity: number;
  readonly #times: Float64Array;
  readonly #values: Float32Array[];
  #start = 0;
  #length = 0;

  constructor(columns: number, capacity: number) {
    this.columns = columns;
    this.capacity = capacity;
    this.#times = new Float64Array(capacity);
    this.#values = Array.from({ length: columns }, () => new Float32Array(capacity));
  }

  get length(): number {
    return this.#length;
  }

  get lastTime_s(): number | null {
    return this.#length === 0 ? null : this.#times[(this.#start + this.#length - 1) % this.capacity]!;
  }

  clear(): void {
    this.#start = 0;
    this.#length = 0;
  }

  /** Adds a sample; one that is not later than the last is ignored. */
  push(time_s: number, values: readonly (number | null | undefined)[]): void {
    const last = this.lastTime_s;
    if (!Number.isFinite(time_s) || (last !== null && time_s <= last)) return;
    const at = (this.#start + this.#length) % this.capacity;
    this.#times[at] = time_s;
    for (let column = 0; column < this.columns; column += 1) this.#values[column]![at] = values[column] ?? Number.NaN;
    if (this.#length < this.capacity) this.#length += 1;
    else this.#start = (this.#start + 1) % this.capacity;
  }

  /** Times and columns since `from_s`, oldest first; absent values are null. */
  since(from_s: number): [number[], ...(number | null)[][]] {
    const times: number[] = [];
    const columns: (number | null)[][] = Array.from({ length: this.columns }, () => []);
    for (let index = 0; index < this.#length; index += 1) {
      const at = (this.#start + index) % this.capacity;
      const time_s = this.#times[at]!;
      if (time_s < from_s) continue;
      times.push(time_s);
      for (let column = 0; column < this.columns; column += 1) {
        const value = this.#values[column]![at]!;
        columns[column]!.push(Number.isNaN(value) ? null : value);
      }
    }
    return [times, ...columns];
  }
}
