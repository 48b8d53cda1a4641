// Objects placed on the map for the maps panel: a picture by its corners, a new offline area, and existing areas.
import type { Place } from '$lib/api/maps-types';
import { destination, distance_m } from '$lib/domain/geo';
import { type LonLat, wrap180_deg } from '$lib/domain/lonlat';
import { type Box, boxCorners } from '$lib/domain/tiling';
import { t } from '$lib/i18n/index.svelte';
import { offlineAreas } from './maps-offline.svelte';

export const CORNERS = [0, 1, 2, 3] as const;

class PicturePlacing {
  image = $state.raw<HTMLImageElement | null>(null);
  /** Top left, top right, bottom right, bottom left of the picture. */
  corners = $state.raw<readonly LonLat[]>([]);
  opacity = $state(0.7);
  #run = 0;

  /** Starts placing a picture; without corners it goes into the middle of the view. */
  async begin(picture: Blob, corners: readonly LonLat[] | null, view: Box | null): Promise<void> {
    const run = ++this.#run;
    const address = URL.createObjectURL(picture);
    const image = new Image();
    image.src = address;
    try {
      await image.decode();
    } finally {
      URL.revokeObjectURL(address);
    }
    if (run !== this.#run) return;
    this.image = image;
    this.corners = corners ?? [];
    if (corners === null && view !== null) this.toView(view);
  }

  /** Into the middle of a view, upright, in its own proportions, as two thirds of the view. */
  toView(view: Box): void {
    if (this.image === null) return;
    const [northWest, northEast, southEast] = boxCorners(view);
    if (!northWest || !northEast || !southEast) return;
    const middle = {
      lon_deg: wrap180_deg((northWest.lon_deg + southEast.lon_deg) / 2),
      lat_deg: (northWest.lat_deg + southEast.lat_deg) / 2,
    };
    const width_m = distance_m({ ...middle, lon_deg: northWest.lon_deg }, { ...middle, lon_deg: northEast.lon_deg });
    const height_m = distance_m(northEast, southEast);
    const { naturalWidth, naturalHeight } = this.image;
    const perPixel_m = Math.min(width_m / naturalWidth, height_m / naturalHeight) * 0.66;
    const [right_m, up_m] = [(naturalWidth * perPixel_m) / 2, (naturalHeight * perPixel_m) / 2];
    const corner = (east: number, north: number): LonLat =>
      destination(destination(middle, 0, north * up_m), 90, east * right_m);
    this.corners = [corner(-1, 1), corner(1, 1), corner(1, -1), corner(-1, -1)];
  }

  move(index: number, to: LonLat): void {
    if (index < 4) {
      this.corners = this.corners.with(index, to);
      return;
    }
    const from = middleOf(this.corners);
    const [lon_deg, lat_deg] = [wrap180_deg(to.lon_deg - from.lon_deg), to.lat_deg - from.lat_deg];
    this.corners = this.corners.map((corner) => ({
      lon_deg: wrap180_deg(corner.lon_deg + lon_deg),
      lat_deg: Math.max(-85, Math.min(85, corner.lat_deg + lat_deg)),
    }));
  }

  end(): void {
    this.#run += 1;
    this.image = null;
    this.corners = [];
  }
}

export const picturePlacing = new PicturePlacing();

function middleOf(corners: readonly LonLat[]): LonLat {
  const [first] = corners;
  if (first === undefined) return { lon_deg: 0, lat_deg: 0 };
  const lon = corners.reduce((sum, corner) => sum + wrap180_deg(corner.lon_deg - first.lon_deg), 0) / corners.length;
  const lat = corners.reduce((sum, corner) => sum + corner.lat_deg, 0) / corners.length;
  return { lon_deg: wrap180_deg(first.lon_deg + lon), lat_deg: lat };
}

interface PlacedArea {
  readonly corners: readonly LonLat[];
  readonly buffer_m: number | null;
  readonly label: string;
  readonly isDraft: boolean;
}

/** What the map draws; `areIn`: whether areas are shown. */
export function placingOf(areIn: boolean) {
  const { image, corners, opacity } = picturePlacing;
  const isPicture = image !== null && corners.length === 4;
  const areas: PlacedArea[] = !areIn
    ? []
    : offlineAreas.areas.map((area) => ({ ...outlineOf(area.shape), label: area.name, isDraft: false }));
  const { drawn, isDrafting, points, shape } = offlineAreas;
  if (isDrafting && drawn !== null) areas.push({ ...outlineOf(drawn), label: '', isDraft: true });
  const drags = isDrafting && (shape === 'box' || shape === 'polygon' || shape === 'view') ? points : [];
  return {
    areas,
    picture: isPicture ? { image, corners, opacity } : null,
    handles: isPicture
      ? [
          ...CORNERS.map((index) => ({ at: corners[index] as LonLat, label: t(`maps.cornerShort.${index}`) })),
          { at: middleOf(corners), label: t('maps.middle') },
        ]
      : drags.map((at, index) => ({ at, label: shape === 'polygon' ? String(index + 1) : '' })),
    drag: (index: number, to: LonLat) => (isPicture ? picturePlacing.move(index, to) : offlineAreas.move(index, to)),
  };
}

type Shape = NonNullable<typeof offlineAreas.drawn>;

function outlineOf(shape: Shape): { corners: readonly LonLat[]; buffer_m: number | null } {
  switch (shape.kind) {
    case 'box':
      return { corners: boxCorners(shape), buffer_m: null };
    case 'polygon':
      return { corners: shape.points, buffer_m: null };
    case 'route':
      return { corners: shape.points, buffer_m: shape.buffer_m };
  }
}

/** Corners as the API takes them. */
export const placesOf = (corners: readonly LonLat[]): Place[] =>
  corners.map(({ lat_deg, lon_deg }) => ({ lat_deg, lon_deg }));
