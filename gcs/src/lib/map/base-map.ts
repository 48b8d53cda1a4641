// What lies under everything: coastlines that need no network.
import Feature from 'ol/Feature';
import MultiPolygon from 'ol/geom/MultiPolygon';
import VectorImageLayer from 'ol/layer/VectorImage';
import VectorSource from 'ol/source/Vector';
import Fill from 'ol/style/Fill';
import Stroke from 'ol/style/Stroke';
import Style from 'ol/style/Style';
import type { Topology } from 'topojson-specification';
import { type Corner, unwrapPolygon } from '$lib/domain/coast';
import type { Theme } from './frame';

/**
 * Nearer than this (metres per pixel) the coast is not drawn: its data are made for maps of the world, and a line that
 * is kilometres off is worse than none beside a plane.
 */
const COAST_FROM_M_PER_PX = 250;

/** Natural Earth's land at 1:110 million (public domain), as the package `world-atlas` ships it. */
export function coastLayer(): VectorImageLayer<VectorSource> {
  const source = new VectorSource<Feature>({ wrapX: true });
  const layer = new VectorImageLayer({
    source,
    minResolution: COAST_FROM_M_PER_PX,
    imageRatio: 1.5,
    zIndex: 0,
  });
  void loadCoast(source);
  return layer;
}

async function loadCoast(source: VectorSource<Feature>): Promise<void> {
  const [{ feature }, { default: world }] = await Promise.all([
    import('topojson-client'),
    import('world-atlas/land-110m.json'),
  ]);
  const topology = world as unknown as Topology;
  const land = topology.objects['land'];
  if (land === undefined) return;
  const shape = feature(topology, land);
  const parts = shape.type === 'FeatureCollection' ? shape.features : [shape];
  for (const { geometry } of parts) {
    if (geometry.type !== 'MultiPolygon') continue;
    const polygons = (geometry.coordinates as unknown as Corner[][][]).flatMap(unwrapPolygon);
    source.addFeature(new Feature(new MultiPolygon(polygons).transform('EPSG:4326', 'EPSG:3857')));
  }
}

export function coastStyle(theme: Theme): Style {
  return new Style({
    fill: new Fill({ color: theme.land }),
    stroke: new Stroke({ color: theme.coast, width: 1 }),
  });
}
