// Texts of the map and of plan editing, in English.
export const mapEn = {
  'map.label': 'Map',
} as const;
