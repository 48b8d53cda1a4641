// Texts of the map and of plan editing, in Spanish.
import type { mapEn } from './map.en';

export const mapEs: Record<keyof typeof mapEn, string> = {
  'map.label': 'Mapa',
};
