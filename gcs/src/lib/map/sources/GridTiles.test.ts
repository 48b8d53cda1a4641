import { get as getProjection } from 'ol/proj';
import TileGrid from 'ol/tilegrid/TileGrid';
import { describe, expect, it } from 'vitest';
import { GridTiles } from './GridTiles';

describe('tiles of a grid in degrees', () => {
  // 12 columns of 32°: the last one begins at 172° and reaches beyond the date line
  const tileGrid = new TileGrid({
    resolutions: [0.125],
    origin: [-180, 90],
    tileSize: 256,
    extent: [-180, -90, 180, 90],
    sizes: [[12, 6]],
  });
  const projection = getProjection('EPSG:4326')!;
  const tiles = new GridTiles({ projection, tileGrid, wrapX: true, tileUrlFunction: () => 'tile' });

  it('are asked for by their own numbers up to the date line', () => {
    expect(tiles.getTileCoordForTileUrlFunction([0, 10, 3], projection)).toEqual([0, 10, 3]);
    expect(tiles.getTileCoordForTileUrlFunction([0, 11, 3], projection)).toEqual([0, 11, 3]);
    expect(tiles.getTileCoordForTileUrlFunction([0, 12, 3], projection)).toBeNull();
  });

  it('are shown on every copy of the world', () => {
    const mercator = getProjection('EPSG:3857')!;
    expect(tiles.getTileCoordForTileUrlFunction([2, 4, 1], mercator)).toEqual([2, 0, 1]);
  });
});
