// All texts of the app. Each area has its own pair of files; English decides which keys there are.
import { shellEn } from './shell.en';
import { shellEs } from './shell.es';
import { mapEn } from './map.en';
import { mapEs } from './map.es';
import { fenceEn } from './fence.en';
import { fenceEs } from './fence.es';
import { mapsEn } from './maps.en';
import { mapsEs } from './maps.es';
import { cameraEn } from './camera.en';
import { cameraEs } from './camera.es';
import { fleetEn } from './fleet.en';
import { fleetEs } from './fleet.es';
import { filesEn } from './files.en';
import { filesEs } from './files.es';
import { findingsEn } from './findings.en';
import { findingsEs } from './findings.es';
import { fixesEn } from './fixes.en';
import { fixesEs } from './fixes.es';
import { paramsEn } from './params.en';
import { paramsEs } from './params.es';
import { profileEn } from './profile.en';
import { profileEs } from './profile.es';
import { replayEn } from './replay.en';
import { replayEs } from './replay.es';
import { serverEn } from './server.en';
import { serverEs } from './server.es';
import { signingEn } from './signing.en';
import { signingEs } from './signing.es';
import { surveyEn } from './survey.en';
import { surveyEs } from './survey.es';

export type Language = 'en' | 'es';

export const en = {
  ...shellEn,
  ...mapEn,
  ...fenceEn,
  ...mapsEn,
  ...cameraEn,
  ...serverEn,
  ...fleetEn,
  ...filesEn,
  ...findingsEn,
  ...fixesEn,
  ...paramsEn,
  ...profileEn,
  ...replayEn,
  ...signingEn,
  ...surveyEn,
} as const;
export type MessageKey = keyof typeof en;

export const es: Record<MessageKey, string> = {
  ...shellEs,
  ...mapEs,
  ...fenceEs,
  ...mapsEs,
  ...cameraEs,
  ...serverEs,
  ...fleetEs,
  ...filesEs,
  ...findingsEs,
  ...fixesEs,
  ...paramsEs,
  ...profileEs,
  ...replayEs,
  ...signingEs,
  ...surveyEs,
};

export const messages: Record<Language, Record<MessageKey, string>> = { en, es };
