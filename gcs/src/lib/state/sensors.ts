// What the sensor plots show, and the recent past of each, kept outside of reactivity: long arrays of numbers.
import type { TelemetryGroups } from '$lib/api/types';
import { Series } from '$lib/domain/series';

export const SENSORS = {
  acceleration: { columns: 3, digits: 2, unit: 'g' },
  rotation: { columns: 3, digits: 1, unit: '°/s' },
  magnetic: { columns: 3, digits: 3, unit: 'G' },
  pressure: { columns: 1, digits: 2, unit: 'hPa' },
  differential: { columns: 1, digits: 1, unit: 'Pa' },
  temperature: { columns: 2, digits: 1, unit: '°C' },
  wind: { columns: 1, digits: 1, unit: 'm/s' },
  windFrom: { columns: 1, digits: 0, unit: '°' },
  voltage: { columns: 1, digits: 2, unit: 'V' },
  current: { columns: 1, digits: 1, unit: 'A' },
  vibration: { columns: 3, digits: 1, unit: 'm/s²' },
  loss: { columns: 1, digits: 1, unit: '%' },
  roundTrip: { columns: 1, digits: 0, unit: 'ms' },
} as const satisfies Record<string, { columns: number; digits: number; unit: string }>;
export type Sensor = keyof typeof SENSORS;
export const SENSOR_NAMES = Object.keys(SENSORS) as Sensor[];

/** Ten minutes at 10 Hz. */
const CAPACITY = 6000;
const SPACING_S = 0.095;

const DEG = 180 / Math.PI;

export class SensorHistory {
  readonly #series = new Map<Sensor, Series>();

  series(sensor: Sensor): Series {
    let series = this.#series.get(sensor);
    if (series === undefined) {
      series = new Series(SENSORS[sensor].columns, CAPACITY);
      this.#series.set(sensor, series);
    }
    return series;
  }

  /** Forgets what it has; the series stay the same, and those who plot them go on. */
  clear(): void {
    for (const series of this.#series.values()) series.clear();
  }

  /** Takes new telemetry; `now_s` is monotonic. */
  take(now_s: number, groups: TelemetryGroups): void {
    const { imu, pressure, wind, vibration, batteries, sys_status } = groups;
    if (imu) {
      this.#push('acceleration', now_s, imu.acc_g ?? []);
      this.#push('rotation', now_s, imu.gyro_rad_s?.map((rate) => rate * DEG) ?? []);
      this.#push('magnetic', now_s, imu.mag_gauss ?? []);
    }
    if (pressure) {
      this.#push('pressure', now_s, [pressure.absolute_pa === null ? null : pressure.absolute_pa / 100]);
      this.#push('differential', now_s, [pressure.differential_pa]);
      this.#push('temperature', now_s, [pressure.temperature_c, imu?.temperature_c]);
    }
    if (wind) {
      this.#push('wind', now_s, [wind.speed_m_s]);
      this.#push('windFrom', now_s, [wind.from_deg]);
    }
    const power = batteries?.[0] ?? sys_status;
    if (power) {
      this.#push('voltage', now_s, [power.voltage_v]);
      this.#push('current', now_s, [power.current_a]);
    }
    if (vibration) this.#push('vibration', now_s, vibration.vibration_m_s2);
  }

  takeLink(now_s: number, link: { loss_pct: number | null; round_trip_ms: number | null }): void {
    this.#push('loss', now_s, [link.loss_pct]);
    this.#push('roundTrip', now_s, [link.round_trip_ms]);
  }

  #push(sensor: Sensor, now_s: number, values: readonly (number | null | undefined)[]): void {
    const series = this.series(sensor);
    const last_s = series.lastTime_s;
    if (last_s === null || now_s - last_s >= SPACING_S) series.push(now_s, values);
  }
}
