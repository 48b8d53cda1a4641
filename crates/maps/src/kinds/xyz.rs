//! Tiles by an address with places to fill: `{z} {x} {y} {-y} {q} {s} {switch:a,b} {key}`.

use std::sync::Arc;

use crate::address::escape;
use crate::cache::CachedTile;
use crate::crs::Crs;
use crate::grid::{TileGrid, TileId};
use crate::kind::{Kind, Opened, Opening};
use crate::live::{Asking, Live, Pending, Reply, Service};
use crate::settings::SourceSettings;

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &["url", "subdomains", "key", "local_network", "tms", "tile_px", "encoding", "below_sea_level", "cache"]
    }

    fn address_signs(&self) -> &'static [&'static str] {
        &["{x}", "{q}", "{quadkey}"]
    }

    fn faults(&self, settings: &SourceSettings, faults: &mut Vec<String>) {
        let url = settings.check_url(faults);
        let has = |place: &str| url.contains(place);
        if !(has("{q}") || (has("{z}") && has("{x}") && (has("{y}") || has("{-y}")))) {
            faults.push("url: needs {z}, {x} and {y} (or {-y}, or {q})".to_owned());
        }
        if has("{s}") && settings.subdomains.is_empty() {
            faults.push("subdomains: url has {s}, so say what it stands for, such as [\"a\", \"b\", \"c\"]".to_owned());
        }
        if let Err(fault) = Template::parse(url) {
            faults.push(format!("url: {fault}"));
        }
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        let template = Template::parse(opening.settings.url.as_deref().unwrap_or_default())?;
        Ok(Live::Service(Box::new(Addressed { template, grid: opening.standard_grid(Crs::WebMercator) })))
    }
}

/// A service of tiles by their address.
struct Addressed {
    template: Template,
    grid: Arc<TileGrid>,
}

impl Service for Addressed {
    fn grid(&self) -> Option<Arc<TileGrid>> {
        Some(self.grid.clone())
    }

    fn tile<'a>(&'a self, asking: Asking<'a>, tile: TileId, kept: Option<&'a CachedTile>) -> Pending<'a, Reply> {
        let settings = asking.settings;
        let url = self.template.fill(tile, &settings.subdomains, settings.tms, settings.key());
        Box::pin(async move { asking.tile(&url, kept).await })
    }
}

/// A part of an address.
#[derive(Debug, Clone, PartialEq)]
enum Part {
    Text(String),
    Zoom,
    Column,
    /// From the top.
    Row,
    /// From the bottom (TMS).
    RowFromBottom,
    /// Bing's and Azure's: a digit 0 to 3 a zoom.
    Quadkey,
    Subdomain,
    Switch(Vec<String>),
    Key,
}

/// An address with places to fill.
#[derive(Debug, Clone, PartialEq)]
pub struct Template {
    parts: Vec<Part>,
}

impl Template {
    /// Reads an address.
    ///
    /// # Errors
    /// The fault, as a sentence.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = Vec::new();
        let mut rest = text;
        while let Some(open) = rest.find('{') {
            if open > 0 {
                parts.push(Part::Text(rest[..open].to_owned()));
            }
            let Some(close) = rest[open..].find('}') else { return Err("a { is not closed".to_owned()) };
            let name = &rest[open + 1..open + close];
            parts.push(match name.to_ascii_lowercase().as_str() {
                "z" | "zoom" => Part::Zoom,
                "x" => Part::Column,
                "y" => Part::Row,
                "-y" => Part::RowFromBottom,
                "q" | "quadkey" => Part::Quadkey,
                "s" => Part::Subdomain,
                "key" => Part::Key,
                lower if lower.starts_with("switch:") => {
                    let choices: Vec<_> = name[7..].split(',').map(|choice| choice.trim().to_owned()).collect();
                    if choices.iter().any(String::is_empty) {
                        return Err(format!("{{{name}}} has an empty choice"));
                    }
                    Part::Switch(choices)
                }
                _ => {
                    return Err(format!(
                        "{{{name}}} is not known; {{z}} {{x}} {{y}} {{-y}} {{q}} {{s}} {{switch:a,b}} {{key}} are"
                    ));
                }
            });
            rest = &rest[open + close + 1..];
        }
        if rest.contains('}') {
            return Err("a } was not opened".to_owned());
        }
        if !rest.is_empty() {
            parts.push(Part::Text(rest.to_owned()));
        }
        Ok(Self { parts })
    }

    /// The address of a tile. The same tile gets the same server every time, so that caches on the way serve.
    pub fn fill(&self, tile: TileId, subdomains: &[String], is_tms: bool, key: Option<&str>) -> String {
        let TileId { level, column, row } = tile;
        let from_bottom = (1_u32 << level.min(31)).wrapping_sub(1).wrapping_sub(row);
        let spread = column.wrapping_add(row) as usize;
        let choice = |choices: &[String]| choices.get(spread % choices.len().max(1)).cloned().unwrap_or_default();
        self.parts
            .iter()
            .map(|part| match part {
                Part::Text(text) => text.clone(),
                Part::Zoom => level.to_string(),
                Part::Column => column.to_string(),
                Part::Row if is_tms => from_bottom.to_string(),
                Part::Row => row.to_string(),
                Part::RowFromBottom => from_bottom.to_string(),
                Part::Quadkey => quadkey(tile),
                Part::Subdomain => choice(subdomains),
                Part::Switch(choices) => choice(choices),
                Part::Key => key.map(escape).unwrap_or_default(),
            })
            .collect()
    }
}

/// Bing's name of a tile ("Bing Maps Tile System", Microsoft, 2018).
pub fn quadkey(tile: TileId) -> String {
    (0..tile.level)
        .rev()
        .map(|bit| {
            let digit = (tile.column >> bit & 1) + 2 * (tile.row >> bit & 1);
            char::from_digit(digit, 4).unwrap_or('0')
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: TileId = TileId { level: 3, column: 3, row: 5 };

    #[test]
    fn places_are_filled() {
        let names = ["a".to_owned(), "b".to_owned(), "c".to_owned()];
        for (template, filled) in [
            ("https://t/{z}/{x}/{y}.png", "https://t/3/3/5.png"),
            ("https://t/{z}/{x}/{-y}", "https://t/3/3/2"),
            ("https://{s}.t/{Z}", "https://c.t/3"),
            ("https://{switch:m,n}.t", "https://m.t"),
            ("https://t/{q}?k={key}", "https://t/213?k=a%26b%20c"),
        ] {
            let parsed = Template::parse(template).expect("a template");
            assert_eq!(parsed.fill(TILE, &names, false, Some("a&b c")), filled);
        }
        let tms = Template::parse("{y}").expect("a template");
        assert_eq!(tms.fill(TILE, &[], true, None), "2");
    }

    #[test]
    fn unknown_places_are_refused() {
        for template in ["{zz}", "{z", "z}", "{switch:}", "{switch:a,}", "{}"] {
            assert!(Template::parse(template).is_err(), "{template}");
        }
    }
}
