// The shapes of the maps' API, where the server's description explains each field.
export interface Attribution {
  text: string;
  url?: string | null;
}

export interface Bounds {
  west_deg: number;
  south_deg: number;
  east_deg: number;
  north_deg: number;
}

export interface Place {
  lat_deg: number;
  lon_deg: number;
}

export type SourceKind = 'xyz' | 'wms' | 'wmts' | 'mbtiles' | 'pmtiles' | 'geotiff' | 'image' | 'google' | 'dem';
export type SourceRole = 'base' | 'overlay' | 'elevation';

export interface TileLevel {
  resolution: number;
  origin: [number, number];
  tile_px: [number, number];
  size?: [number, number] | null;
}

export interface TileGrid {
  crs: string;
  proj4?: string | null;
  extent?: [number, number, number, number] | null;
  levels: TileLevel[];
  min_level: number;
  max_level: number;
}

export interface SourceState {
  status: 'unused' | 'ok' | 'failing' | 'offline' | 'invalid' | 'key_missing';
  detail?: string | null;
  last_success_at?: number | null;
  last_error_at?: number | null;
  last_error?: string | null;
  fetched: number;
  revalidated: number;
  hits: number;
  stale: number;
  failed: number;
  bytes_fetched: number;
  cache?: { tiles: number; bytes: number; pinned_tiles: number; max_bytes: number } | null;
}

export interface MapSource {
  id: string;
  name: string;
  kind: SourceKind;
  role: SourceRole;
  visible: boolean;
  opacity: number;
  order: number;
  min_zoom?: number | null;
  max_zoom?: number | null;
  bounds?: Bounds | null;
  attribution: Attribution[];
  attribution_by_view: boolean;
  logo?: 'google' | null;
  grid?: TileGrid | null;
  tiles_url: string;
  may_cache: boolean;
  offline: { allowed: boolean; reason?: string | null };
  needs_key: boolean;
  has_key: boolean;
  corners?: Place[] | null;
  state: SourceState;
}

export interface MapSources {
  sources: MapSource[];
  file: string;
  file_error?: string | null;
}

/** What the file of sources holds of one; what is absent has its default. */
export interface SourceSettings {
  id: string;
  name: string;
  kind: SourceKind;
  role?: SourceRole;
  visible?: boolean;
  opacity?: number;
  order?: number;
  min_zoom?: number | null;
  max_zoom?: number | null;
  bounds?: Bounds | null;
  attribution?: Attribution[];
  url?: string | null;
  subdomains?: string[];
  /** Write only: absent keeps it, empty removes it. */
  key?: string;
  has_key?: boolean;
  tile_px?: number | null;
  tms?: boolean | null;
  layers?: string[];
  styles?: string[];
  version?: string | null;
  crs?: string | null;
  format?: string | null;
  transparent?: boolean | null;
  parameters?: Record<string, string>;
  layer?: string | null;
  matrix_set?: string | null;
  style?: string | null;
  map_type?: 'satellite' | 'roadmap' | 'terrain' | null;
  language?: string | null;
  region?: string | null;
  path?: string | null;
  corners?: Place[] | null;
  encoding?: 'terrarium' | 'terrain-rgb' | null;
  datum?: string | null;
  cache?: 'keep' | 'headers' | 'none';
  cache_min_days?: number | null;
  max_mb?: number | null;
  offline?: boolean | null;
  offline_reason?: string | null;
  parallel?: number | null;
  terms_url?: string | null;
  attribution_url?: string | null;
  local_network?: boolean;
}

export interface MapConfig {
  sources: SourceSettings[];
  cache_max_mb: number;
  folder: string;
  file: string;
  file_error?: string | null;
}

export interface Preset {
  id: string;
  name: string;
  description: string;
  terms_url?: string | null;
  needs_key: boolean;
  key_url?: string | null;
  settings: SourceSettings;
}

export interface CapLayer {
  name?: string | null;
  title: string;
  abstract?: string | null;
  depth: number;
  styles: { name: string; title: string }[];
  crs: string[];
  other_crs: number;
  formats: string[];
  matrix_sets: { id: string; crs: string; levels: number }[];
  bounds?: Bounds | null;
  attribution?: Attribution | null;
  opaque: boolean;
  min_zoom?: number | null;
  max_zoom?: number | null;
}

export interface Capabilities {
  kind: 'wms' | 'wmts';
  version: string;
  title?: string | null;
  abstract?: string | null;
  fees?: string | null;
  access_constraints?: string | null;
  attribution?: Attribution | null;
  formats: string[];
  layers: CapLayer[];
}

export interface MapFile {
  path: string;
  bytes: number;
  kind?: SourceKind | null;
}

export interface UploadedFile {
  path: string;
  bytes: number;
  settings: SourceSettings;
}

export type AreaShape =
  | ({ kind: 'box' } & Bounds)
  | { kind: 'polygon'; points: Place[] }
  | { kind: 'route'; points: Place[]; buffer_m: number };

export interface AreaRequest {
  source: string;
  name: string;
  shape: AreaShape;
  min_level: number;
  max_level: number;
}

export interface AreaEstimate {
  tiles: number;
  have: number;
  bytes: number;
  tile_bytes: number;
  tile_bytes_measured: boolean;
  levels: { level: number; tiles: number }[];
  max_tiles: number;
  refused?: string | null;
}

export interface Area {
  id: string;
  source: string;
  name: string;
  shape: AreaShape;
  min_level: number;
  max_level: number;
  state: 'running' | 'paused' | 'done' | 'failed';
  detail?: string | null;
  tiles: number;
  done: number;
  failed: number;
  bytes: number;
  created_at: number;
  rate_tiles_s?: number | null;
}

export interface ElevationPoint {
  alt_amsl_m?: number | null;
  source?: string | null;
  resolution_m?: number | null;
  datum?: string | null;
}

export interface ElevationProfile {
  length_m: number;
  samples: { distance_m: number; lat_deg: number; lon_deg: number; alt_amsl_m?: number | null }[];
  sources: string[];
  datum?: string | null;
  max_alt_amsl_m?: number | null;
  unknown: number;
  error?: string | null;
}
