//! The file of the sources (TOML): read with errors that name the line, changed one source at a time so that a person's
//! comments and order survive.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, Value};
use vencejo_store::{Access, Lock};

use crate::error::{MapError, Result};
use crate::settings::{Role, SourceSettings};

/// Default megabytes of each source's cache.
pub const DEFAULT_CACHE_MAX_MB: u32 = 2000;
/// Bytes of the file at most.
const MAX_BYTES: u64 = 1024 * 1024;
/// Sources at most.
pub const MAX_SOURCES: usize = 200;

const HEADER: &str = "\
# Map sources of Vencejo. Edit this file by hand or in the dialog of the map sources; both keep each other's changes.
# docs/maps.md describes every field. Keys are secret: keep this file to yourself.
";

/// Content of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Sources {
    /// Megabytes of each source's cache without its own limit.
    pub cache_max_mb: u32,
    /// In the file's order.
    pub sources: Vec<SourceSettings>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    #[serde(default)]
    cache_max_mb: Option<u32>,
    #[serde(default)]
    source: Vec<SourceSettings>,
}

/// The file, by its path.
#[derive(Debug, Clone)]
pub struct SourcesFile {
    path: PathBuf,
}

impl SourcesFile {
    /// The file of a path, which need not exist.
    pub const fn new(path: PathBuf) -> Self {
        Self { path }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn wrong(&self, reason: impl Into<String>) -> MapError {
        MapError::SourcesFile { path: self.path.clone(), reason: reason.into() }
    }

    fn text(&self) -> Result<Option<String>> {
        match std::fs::metadata(&self.path) {
            Ok(about) if about.len() > MAX_BYTES => Err(self.wrong(format!("has more than {MAX_BYTES} bytes"))),
            Ok(_) => std::fs::read_to_string(&self.path)
                .map(Some)
                .map_err(|error| self.wrong(format!("cannot be read: {error}"))),
            // Nor below a path that is not a folder.
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
            Err(error) => Err(self.wrong(format!("cannot be read: {error}"))),
        }
    }

    /// Reads it; `None` when it does not exist.
    ///
    /// # Errors
    /// [`MapError::SourcesFile`] with line and field.
    pub fn read(&self) -> Result<Option<Sources>> {
        self.text()?.map(|text| self.parse(&text)).transpose()
    }

    fn parse(&self, text: &str) -> Result<Sources> {
        let content: Content = toml_edit::de::from_str(text).map_err(|error| {
            let at = error.span().map(|span| format!("line {}: ", line_of(text, span.start)));
            self.wrong(format!("{}{}", at.unwrap_or_default(), error.message().trim()))
        })?;
        let lines = source_lines(text);
        let line = |index: usize| lines.get(index).map(|line| format!("line {line}: ")).unwrap_or_default();
        if content.source.len() > MAX_SOURCES {
            return Err(self.wrong(format!("has more than {MAX_SOURCES} sources")));
        }
        if content.cache_max_mb.is_some_and(|mb| !(1..=1_000_000).contains(&mb)) {
            return Err(self.wrong("cache_max_mb: goes from 1 to 1000000"));
        }
        let mut seen = BTreeMap::new();
        for (index, source) in content.source.iter().enumerate() {
            let faults = source.faults();
            if !faults.is_empty() {
                return Err(self.wrong(format!("{}source '{}': {}", line(index), source.id, faults.join("; "))));
            }
            if let Some(first) = seen.insert(source.id.clone(), index) {
                let first = lines.get(first).map(|line| format!(", as in line {line}")).unwrap_or_default();
                return Err(self.wrong(format!("{}id: '{}' is taken{first}", line(index), source.id)));
            }
        }
        Ok(Sources {
            cache_max_mb: content.cache_max_mb.unwrap_or(DEFAULT_CACHE_MAX_MB),
            sources: content.source.into_iter().map(|source| SourceSettings { has_key: None, ..source }).collect(),
        })
    }

    /// Writes a new file with these sources, unless there is one: another instance may have been quicker.
    ///
    /// # Errors
    /// [`MapError::Storage`] when it cannot be written.
    pub fn create(&self, sources: &[SourceSettings]) -> Result<()> {
        let mut document = DocumentMut::new();
        for source in sources {
            put(&mut document, source)?;
        }
        let text = format!("{HEADER}cache_max_mb = {DEFAULT_CACHE_MAX_MB}\n{document}");
        vencejo_store::create(&self.path, text.as_bytes(), Access::Owner)?;
        Ok(())
    }

    /// The right to change the file. Every change reads it, changes what it read and writes it while it holds this:
    /// several instances may use one folder.
    fn lock(&self) -> Result<Lock> {
        Ok(Lock::of(&self.path, vencejo_store::lock::PATIENCE)?)
    }

    fn document(&self) -> Result<DocumentMut> {
        // An invalid file is not changed: it is probably being edited by hand.
        let Some(text) = self.text()? else { return HEADER.parse().map_err(|error| self.wrong(format!("{error}"))) };
        self.parse(&text)?;
        text.parse().map_err(|error: toml_edit::TomlError| self.wrong(error.message()))
    }

    /// Puts one source in the place of that of its id, or at the end.
    ///
    /// # Errors
    /// [`MapError::SourcesFile`] when the file is wrong as it is, [`MapError::Storage`] when it cannot be written.
    pub fn put(&self, source: &SourceSettings) -> Result<()> {
        self.change(&source.id, |_| Ok(source.clone()))
    }

    /// Replaces the source of an id, as the file has it at this moment, by what `change` makes of it, or appends it.
    ///
    /// # Errors
    /// As [`Self::put`], and those of `change`: then nothing is written.
    pub fn change(
        &self,
        id: &str,
        change: impl FnOnce(Option<&SourceSettings>) -> Result<SourceSettings>,
    ) -> Result<()> {
        let _lock = self.lock()?;
        let mut document = self.document()?;
        let before = self.parse(&document.to_string())?.sources;
        let source = change(before.iter().find(|source| source.id == id))?;
        put(&mut document, &source)?;
        let text = document.to_string();
        // Nothing is written that would not be read.
        self.parse(&text)?;
        self.write(&text)
    }

    /// Sets the order of sources.
    ///
    /// # Errors
    /// As [`Self::put`].
    pub fn set_orders(&self, orders: &BTreeMap<String, i32>) -> Result<()> {
        let _lock = self.lock()?;
        let mut document = self.document()?;
        for table in tables(&mut document)?.iter_mut() {
            if let Some(order) = table.get("id").and_then(Item::as_str).and_then(|id| orders.get(id)) {
                set(table, "order", Value::from(i64::from(*order)));
            }
        }
        self.write(&document.to_string())
    }

    /// Removes a source; whether it was there.
    ///
    /// # Errors
    /// As [`Self::put`].
    pub fn remove(&self, id: &str) -> Result<bool> {
        let _lock = self.lock()?;
        let mut document = self.document()?;
        let tables = tables(&mut document)?;
        let before = tables.len();
        tables.retain(|table| table.get("id").and_then(Item::as_str) != Some(id));
        let was_there = tables.len() != before;
        if was_there {
            self.write(&document.to_string())?;
        }
        Ok(was_there)
    }

    /// Only its owner reads it: it may hold keys.
    fn write(&self, text: &str) -> Result<()> {
        Ok(vencejo_store::write(&self.path, text.as_bytes(), Access::Owner)?)
    }
}

fn tables(document: &mut DocumentMut) -> Result<&mut ArrayOfTables> {
    let item = document.entry("source").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
    if let Some(inline) = item.as_array() {
        // `source = [{…}]`, as it may be written by hand.
        let tables = inline.iter().filter_map(Value::as_inline_table).map(|table| table.clone().into_table()).collect();
        *item = Item::ArrayOfTables(tables);
    }
    item.as_array_of_tables_mut().ok_or_else(|| MapError::storage("`source` is not a list of tables"))
}

fn put(document: &mut DocumentMut, source: &SourceSettings) -> Result<()> {
    let kept = SourceSettings { has_key: None, ..source.clone() };
    let fields = toml_edit::ser::to_document(&kept).map_err(MapError::storage)?;
    let tables = tables(document)?;
    let index = tables.iter().position(|table| table.get("id").and_then(Item::as_str) == Some(&source.id));
    let table = match index {
        Some(index) => tables.get_mut(index),
        None => {
            let mut table = Table::new();
            table.decor_mut().set_prefix("\n");
            tables.push(table);
            let last = tables.len() - 1;
            tables.get_mut(last)
        }
    };
    let table = table.ok_or_else(|| MapError::storage("the source's table is gone"))?;
    // Those of a reader, for whom every kind begins as a base map.
    let defaults =
        SourceSettings { role: Role::default(), ..SourceSettings::new(&*source.id, &*source.name, source.kind) };
    let defaults = toml_edit::ser::to_document(&defaults).map_err(MapError::storage)?;
    // Values now at their default are removed with their comment; the others keep theirs.
    let gone: Vec<String> =
        table.iter().map(|(key, _)| key.to_owned()).filter(|key| !fields.contains_key(key)).collect();
    for key in gone {
        table.remove(&key);
    }
    for (key, item) in fields.iter() {
        let value = inline(item.clone());
        let Ok(value) = value.into_value() else { continue };
        let is_default = defaults.get(key).and_then(|item| inline(item.clone()).into_value().ok());
        let is_default = is_default.is_some_and(|default| default.to_string().trim() == value.to_string().trim());
        if is_default && !table.contains_key(key) && !["id", "name", "kind"].contains(&key) {
            continue;
        }
        set(table, key, value);
    }
    Ok(())
}

/// Sets a value and keeps the comment behind it.
fn set(table: &mut Table, key: &str, mut value: Value) {
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        None => {
            table.insert(key, Item::Value(value));
        }
    }
}

/// Tables as inline ones: a source stays one block.
fn inline(item: Item) -> Item {
    match item {
        Item::Table(table) => Item::Value(Value::InlineTable(table.into_inline_table())),
        Item::ArrayOfTables(tables) => {
            let mut array = toml_edit::Array::new();
            for table in tables {
                array.push(Value::InlineTable(table.into_inline_table()));
            }
            Item::Value(Value::Array(array))
        }
        other => other,
    }
}

fn line_of(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1
}

/// Lines where the sources begin, in order.
fn source_lines(text: &str) -> Vec<usize> {
    let is_start = |line: &str| {
        line.split('#').next().is_some_and(|line| line.split_whitespace().collect::<String>() == "[[source]]")
    };
    (1..).zip(text.lines()).filter(|(_, line)| is_start(line)).map(|(number, _)| number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::SourceKind;
    use crate::testing::Folder;

    const TEXT: &str = "# my maps\ncache_max_mb = 10\n\n[[source]] # the first\nid = \"osm\" # short\nname = \"OSM\"\nkind = \"xyz\"\n\
        url = \"https://t/{z}/{x}/{y}\"\n# half\nopacity = 0.5 # seen through\n\n[[source]]\nid = \"b\"\nname = \"B\"\nkind = \"mbtiles\"\npath = \"b.mbtiles\"\n";

    fn file(folder: &Folder, text: &str) -> SourcesFile {
        let file = SourcesFile::new(folder.path().join("sources.toml"));
        std::fs::write(file.path(), text).expect("written");
        file
    }

    #[test]
    fn comments_survive_changes() {
        let folder = Folder::new();
        let file = file(&folder, TEXT);
        let mut osm = file.read().expect("right").expect("there").sources.remove(0);
        (osm.opacity, osm.key) = (0.75, Some("secret".into()));
        file.put(&osm).expect("put");
        let text = std::fs::read_to_string(file.path()).expect("read");
        for kept in [
            "# my maps",
            "# the first",
            "# short",
            "# half\nopacity = 0.75 # seen through",
            "key = \"secret\"",
            "id = \"b\"",
        ] {
            assert!(text.contains(kept), "{kept}: {text}");
        }
        assert!(!text.contains("visible"), "defaults are not written: {text}");
        let sources = file.read().expect("right").expect("there");
        assert_eq!((sources.cache_max_mb, &sources.sources[0]), (10, &osm));
        file.set_orders(&BTreeMap::from([("b".to_owned(), 7)])).expect("set");
        assert_eq!(file.read().expect("right").expect("there").sources[1].order, 7);
        assert!(file.remove("osm").expect("removed") && !file.remove("osm").expect("gone"));
        assert_eq!(file.read().expect("right").expect("there").sources.len(), 1);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            assert_eq!(std::fs::metadata(file.path()).expect("there").permissions().mode() & 0o777, 0o600);
        }
    }

    #[test]
    fn errors_name_line_and_field() {
        let folder = Folder::new();
        for (text, said) in [
            (TEXT.replace("0.5", "2.5"), "line 4: source 'osm': opacity"),
            (TEXT.replace("\"b\"", "\"osm\""), "line 12: id: 'osm' is taken, as in line 4"),
            (TEXT.replace("opacity", "opcity"), "line 10: unknown field `opcity`"),
            (TEXT.replace("0.5", "'half'"), "line 10: "),
            (TEXT.replace("\"xyz\"", "\"xzy\""), "line 7: unknown variant `xzy`"),
            (TEXT.replace("\"OSM\"", "\"OSM"), "line 6"),
            (TEXT.replace("= 10", "= 0"), "cache_max_mb"),
        ] {
            let file = file(&folder, &text);
            let error = file.read().expect_err("wrong").to_string();
            assert!(error.contains(said), "{said}: {error}");
            let source = SourceSettings::new("c", "C", SourceKind::Mbtiles);
            assert!(file.put(&source).is_err(), "a wrong file is left alone");
            assert_eq!(std::fs::read_to_string(file.path()).expect("read"), text);
        }
    }

    #[test]
    fn several_writers_lose_no_source() {
        let folder = Folder::new();
        let path = folder.path().join("sources.toml");
        std::thread::scope(|scope| {
            for writer in 0..4 {
                let path = &path;
                scope.spawn(move || {
                    let file = SourcesFile::new(path.clone());
                    file.create(&[]).expect("made, or there");
                    for number in 0..15 {
                        let id = format!("s{writer}-{number}");
                        let source = SourceSettings::new(&*id, &*id, SourceKind::Mbtiles);
                        file.put(&SourceSettings { path: Some("a.mbtiles".into()), ..source }).expect("put");
                    }
                });
            }
        });
        assert_eq!(SourcesFile::new(path).read().expect("right").expect("there").sources.len(), 60);
    }

    #[test]
    fn all_presets_survive_the_file() {
        let folder = Folder::new();
        let file = SourcesFile::new(folder.path().join("new/sources.toml"));
        assert_eq!(file.read().expect("none"), None);
        let mut presets: Vec<_> = crate::presets::presets().into_iter().map(|preset| preset.settings).collect();
        let heights = SourceSettings::new("heights", "Heights", SourceKind::Dem);
        presets.push(SourceSettings { path: Some("files/heights".into()), ..heights });
        file.create(&presets).expect("made");
        assert_eq!(file.read().expect("right").expect("there").sources, presets);
        for preset in &presets {
            file.put(preset).expect("put");
        }
        assert_eq!(file.read().expect("right").expect("there").sources, presets);
    }
}
