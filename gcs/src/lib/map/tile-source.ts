// A source of map tiles, as a person may type it.

/** A source of tiles in Web Mercator. */
export interface TileSource {
  /** With {x}, {y} and {z}. */
  readonly url: string;
  /** Shown on the map, always; plain text. */
  readonly attribution: string;
  readonly maxZoom: number;
}

/** Why an address cannot be a source of tiles; `null` when it can. */
export function tileUrlFault(url: string): 'placeholders' | 'scheme' | null {
  if (!['{x}', '{z}'].every((part) => url.includes(part)) || !/\{-?y\}/.test(url)) return 'placeholders';
  return /^https?:\/\//.test(url) || /^\/(?!\/)/.test(url) ? null : 'scheme';
}

export function escapeMarkup(text: string): string {
  const named: Record<string, string> = { '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;', "'": '&#39;' };
  return text.replace(/[&<>"']/g, (char) => named[char] ?? char);
}
