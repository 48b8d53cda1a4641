// The maps' part of the API: sources, offline areas, elevation. Every failure is a ProblemError.
import { Http } from './http';
import type {
  Area,
  AreaEstimate,
  AreaRequest,
  Attribution,
  Bounds,
  Capabilities,
  ElevationPoint,
  ElevationProfile,
  MapConfig,
  MapFile,
  MapKind,
  MapSource,
  MapSources,
  Place,
  Preset,
  SourceSettings,
  SourceState,
  UploadedFile,
} from './maps-types';

const part = encodeURIComponent;

export class MapsApi extends Http {
  sources = () => this.json<MapSources>('GET', '/maps/sources');
  config = () => this.json<MapConfig>('GET', '/maps/config');
  putSource = (settings: SourceSettings) => this.json<MapSource>('PUT', `/maps/sources/${part(settings.id)}`, settings);
  removeSource = (id: string, alsoCache: boolean) =>
    this.json<unknown>('DELETE', `/maps/sources/${part(id)}?cache=${alsoCache}`);
  clearCache = (id: string) => this.json<unknown>('DELETE', `/maps/sources/${part(id)}/cache`);
  putOrder = (ids: readonly string[]) => this.json<MapSources>('PUT', '/maps/order', { ids });
  kinds = () => this.json<MapKind[]>('GET', '/maps/kinds');
  presets = () => this.json<Preset[]>('GET', '/maps/presets');
  capabilities = (body: { kind: MapKind['kind']; url: string; key?: string; local_network?: boolean }) =>
    this.json<Capabilities>('POST', '/maps/capabilities', body);
  /** Fetches one tile now, past the cache. */
  check = (id: string) => this.json<SourceState>('POST', `/maps/sources/${part(id)}/check`);
  /** The attribution that a view of the map demands, for sources where it depends on the place. */
  attribution = (id: string, view: Bounds, zoom: number) =>
    this.json<{ attribution: Attribution[] }>(
      'GET',
      `/maps/sources/${part(id)}/attribution?${new URLSearchParams(
        Object.entries({ ...view, zoom }).map(([name, value]) => [name, String(value)]),
      )}`,
    );

  files = () => this.json<MapFile[]>('GET', '/maps/files');
  upload = (file: File) =>
    this.json<UploadedFile>('POST', `/maps/files?name=${part(file.name)}`, file, { signal: null });
  /** The picture of an image overlay. */
  image = (id: string): Promise<Blob> => this.blob('GET', `/maps/sources/${part(id)}/image`);

  areas = () => this.json<Area[]>('GET', '/maps/areas');
  estimateArea = (body: AreaRequest) => this.json<AreaEstimate>('POST', '/maps/areas/estimate', body);
  addArea = (body: AreaRequest) => this.json<Area>('POST', '/maps/areas', body);
  pauseArea = (id: string) => this.json<Area>('POST', `/maps/areas/${part(id)}/pause`);
  resumeArea = (id: string) => this.json<Area>('POST', `/maps/areas/${part(id)}/resume`);
  removeArea = (id: string) => this.json<unknown>('DELETE', `/maps/areas/${part(id)}`);
  importArea = (source: string, file: File) =>
    this.json<Area>('POST', `/maps/areas/import?source=${part(source)}&name=${part(file.name)}`, file, {
      signal: null,
    });
  /** Where an area can be fetched as an MBTiles file, for a link. */
  exportAddress = (id: string) => this.address(`/maps/areas/${part(id)}/export`);

  elevation = (points: readonly Place[]) => this.json<{ points: ElevationPoint[] }>('POST', '/elevation', { points });
  elevationProfile = (points: readonly Place[], spacing_m?: number) =>
    this.json<ElevationProfile>('POST', '/elevation/profile', { points, ...(spacing_m && { spacing_m }) });
}
