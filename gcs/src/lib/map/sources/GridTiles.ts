// Tiles of a source's own grid, as the map warps them into its own.
import TileImage from 'ol/source/TileImage';
import { equivalent } from 'ol/proj';
import type Projection from 'ol/proj/Projection';
import { type TileCoord, withinExtentAndZ } from 'ol/tilecoord';

/**
 * OpenLayers takes every grid of a whole world for one that its tiles divide evenly. One in degrees need not be: the middle of
 * its last column may lie beyond the date line, and the first column came in its place. The map's own grid is even and goes
 * around the world; tiles of the source's grid are only ever asked for within one world, by their own numbers.
 */
export class GridTiles extends TileImage {
  override getTileCoordForTileUrlFunction(tile: TileCoord, projection?: Projection): TileCoord | null {
    const own = this.getProjection();
    const grid = this.tileGrid;
    const isOwn = projection !== undefined && own !== null && equivalent(projection, own);
    if (!isOwn || grid === null || own.getCode() === 'EPSG:3857') {
      return super.getTileCoordForTileUrlFunction(tile, projection);
    }
    return withinExtentAndZ(tile, grid) ? tile : null;
  }
}
