// The history of planes far away: what is kept of each, what is missing in it, and its files.
import { Http } from './http';
import type { components } from './schema';

export type AircraftHistory = components['schemas']['AircraftHistory'];

const http = new Http();

export const historyApi = {
  list: () => http.json<AircraftHistory[]>('GET', '/history'),
  address: (place: string, name: string) =>
    http.address(`/history/${encodeURIComponent(place)}/${encodeURIComponent(name)}`),
};
