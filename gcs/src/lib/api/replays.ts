// Recordings on the server, and their replay.
import { Http } from './http';
import type { components } from './schema';

type Schemas = components['schemas'];
export type Recording = Schemas['Recording'];
export type RecordingSummary = Schemas['RecordingSummary'];
export type Replay = Schemas['Replay'];
export type NewReplay = Schemas['NewReplay'];
export type ReplayChange = Schemas['ReplayChange'];
export type ReplayMark = Schemas['ReplayMark'];

const http = new Http();

export const replaysApi = {
  recordings: () => http.json<Recording[]>('GET', '/recordings'),
  address: (name: string) => http.address(`/recordings/${encodeURIComponent(name)}`),
  summary: (name: string) => http.json<RecordingSummary>('GET', `/recordings/${encodeURIComponent(name)}/summary`),
  open: (body: NewReplay) => http.json<Replay>('POST', '/replays', body),
  change: (id: number, body: ReplayChange) => http.json<Replay>('PATCH', `/replays/${id}`, body),
  close: (id: number) => http.json<unknown>('DELETE', `/replays/${id}`),
  marks: (id: number) => http.json<ReplayMark[]>('GET', `/replays/${id}/marks`),
};
