// Stored history of remote aircraft: extent, gaps and files.
import { Http } from './http';
import type { components } from './schema';

export type AircraftHistory = components['schemas']['AircraftHistory'];

const http = new Http();

export const historyApi = {
  list: () => http.json<AircraftHistory[]>('GET', '/history'),
  address: (place: string, name: string) =>
    http.address(`/history/${encodeURIComponent(place)}/${encodeURIComponent(name)}`),
};
