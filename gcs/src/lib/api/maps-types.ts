// The shapes of the maps' API under the names the app uses, generated from the server's description, where each field is explained.
import type { components } from './schema';

type Schemas = components['schemas'];

export type Attribution = Schemas['MapAttribution'];
export type Bounds = Schemas['MapBounds'];
export type Place = Schemas['MapCorner'];
export type MapSource = Schemas['MapSource'];
export type MapSources = Schemas['MapSources'];
/** What is absent has its default. */
export type SourceSettings = Partial<Schemas['MapSourceSettings']> &
  Pick<Schemas['MapSourceSettings'], 'id' | 'name' | 'kind'>;
export type SourceState = Schemas['MapSourceState'];
export type SourceRole = MapSource['role'];
export type MapKind = Schemas['MapKind'];
export type MapConfig = Schemas['MapConfiguration'];
export type Preset = Omit<Schemas['MapPreset'], 'settings'> & { settings: SourceSettings };
export type CapLayer = Schemas['MapCapLayer'];
export type Capabilities = Schemas['MapCapabilities'];
export type MapFile = Schemas['MapFileInfo'];
export type UploadedFile = Schemas['MapFileTaken'];
export type AreaShape = Schemas['MapAreaShape'];
export type AreaRequest = Schemas['AreaRequest'];
export type AreaEstimate = Schemas['MapAreaEstimate'];
export type Area = Schemas['MapArea'];
export type ElevationPoint = Schemas['ElevationPoint'];
export type ElevationProfile = Schemas['ElevationProfile'];
