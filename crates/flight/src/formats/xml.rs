//! XML as a small tree, within bounds: size, depth and number of elements are limited, and entities
//! other than the five of XML itself are dropped, so that no document grows when it is read.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Bytes of a document at most. The largest real capabilities of map services are about 10 MB.
pub const MAX_BYTES: usize = super::MAX_FILE_BYTES;
const MAX_DEPTH: usize = 64;
/// As many as the largest plan has in a `.kml` of ours.
const MAX_ELEMENTS: usize = 300_000;
/// Tags, texts, entities and comments: an element has two tags, a text in it and one behind it. A small `.kmz` holds
/// millions.
const MAX_PARTS: usize = 5 * MAX_ELEMENTS;
/// Attributes of an element at most, and of a document.
const MAX_ATTRIBUTES: usize = 2000;
const MAX_ATTRIBUTES_IN_ALL: usize = 200_000;

/// How the faults of a document that is too large begin.
pub(super) const TOO_LARGE: &str = "the document has more than";

/// An element, by its local name: prefixes differ between services, meanings do not.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Element {
    /// Local name.
    pub name: String,
    /// Attributes by local name.
    pub attributes: Vec<(String, String)>,
    /// What is inside, in order.
    pub children: Vec<Element>,
    /// Its own text, trimmed.
    pub text: String,
}

impl Element {
    /// Reads a document.
    ///
    /// # Errors
    /// The fault, as a sentence.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() > MAX_BYTES {
            return Err(format!("{TOO_LARGE} {MAX_BYTES} bytes"));
        }
        let text = decode(bytes);
        let mut reader = Reader::from_str(&text);
        let mut open: Vec<Self> = vec![Self::default()];
        let (mut count, mut attributes, mut parts) = (0_usize, 0_usize, 0_usize);
        loop {
            parts += 1;
            if parts > MAX_PARTS {
                return Err(format!("{TOO_LARGE} {MAX_PARTS} tags, texts and entities"));
            }
            let event = reader.read_event().map_err(|error| format!("no XML: {error}"))?;
            if attributes > MAX_ATTRIBUTES_IN_ALL {
                return Err(format!("{TOO_LARGE} {MAX_ATTRIBUTES_IN_ALL} attributes"));
            }
            let top = open.last_mut().ok_or("no XML: an element too many ends")?;
            match event {
                Event::Start(start) => {
                    count += 1;
                    if count > MAX_ELEMENTS {
                        return Err(format!("{TOO_LARGE} {MAX_ELEMENTS} elements"));
                    }
                    if open.len() > MAX_DEPTH {
                        return Err(format!("the document is more than {MAX_DEPTH} elements deep"));
                    }
                    let element = element(&start);
                    attributes += element.attributes.len();
                    open.push(element);
                }
                Event::Empty(start) => {
                    count += 1;
                    if count > MAX_ELEMENTS {
                        return Err(format!("{TOO_LARGE} {MAX_ELEMENTS} elements"));
                    }
                    let element = element(&start);
                    attributes += element.attributes.len();
                    top.children.push(element);
                }
                Event::End(_) => {
                    let mut done = open.pop().ok_or("no XML: an element too many ends")?;
                    done.text = done.text.trim().to_owned();
                    open.last_mut().ok_or("no XML: an element too many ends")?.children.push(done);
                }
                Event::Text(text) => top.text.push_str(&text.decode().map_err(|error| error.to_string())?),
                Event::CData(text) => top.text.push_str(&String::from_utf8_lossy(&text)),
                Event::GeneralRef(reference) => {
                    if let Ok(Some(c)) = reference.resolve_char_ref() {
                        top.text.push(c);
                    } else if let Some(text) = predefined(&reference) {
                        top.text.push_str(text);
                    }
                }
                Event::Eof => break,
                Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => {}
            }
        }
        match open.as_mut_slice() {
            [document] if document.children.len() == 1 => Ok(document.children.remove(0)),
            [document] if document.children.is_empty() => Err("no XML: it has no element".to_owned()),
            [_] => Err("no XML: it has more than one root".to_owned()),
            _ => Err("the document was cut short".to_owned()),
        }
    }

    /// The children of a name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The first child of a name.
    pub fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// The text of the first child of a name, unless it is empty.
    pub fn text_of(&self, name: &str) -> Option<&str> {
        self.child(name).map(|child| child.text.as_str()).filter(|text| !text.is_empty())
    }

    /// An attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// An attribute as a finite number.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.attribute(name)?.trim().parse().ok().filter(|number: &f64| number.is_finite())
    }

    /// The first element of a name at any depth, itself included.
    pub fn find(&self, name: &str) -> Option<&Self> {
        if self.name == name { Some(self) } else { self.children.iter().find_map(|child| child.find(name)) }
    }
}

fn element(start: &BytesStart<'_>) -> Element {
    let local = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let mut read = start.attributes();
    // Whether a name comes twice is not asked: that takes the square of their number.
    let attributes = read.with_checks(false).flatten().take(MAX_ATTRIBUTES).map(|attribute| {
        let value = String::from_utf8_lossy(&attribute.value);
        let value = quick_xml::escape::unescape(&value).map_or_else(|_| value.to_string(), Into::into);
        (local(attribute.key.local_name().as_ref()), value)
    });
    Element { name: local(start.local_name().as_ref()), attributes: attributes.collect(), ..Element::default() }
}

fn predefined(name: &[u8]) -> Option<&'static str> {
    match name {
        b"amp" => Some("&"),
        b"lt" => Some("<"),
        b"gt" => Some(">"),
        b"quot" => Some("\""),
        b"apos" => Some("'"),
        _ => None,
    }
}

/// UTF-8, or Latin-1 where the declaration says so, as MapServer long did by default.
fn decode(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let declaration = String::from_utf8_lossy(&bytes[..bytes.len().min(120)]).to_ascii_lowercase();
    let is_latin = declaration.starts_with("<?xml")
        && declaration.split("?>").next().is_some_and(|line| {
            line.contains("iso-8859-1") || line.contains("iso-8859-15") || line.contains("windows-1252")
        });
    if is_latin {
        bytes.iter().map(|byte| char::from(*byte)).collect()
    } else {
        String::from_utf8_lossy(bytes).into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lose_prefixes_and_texts_their_entities() {
        let root = Element::parse(
            b"<?xml version='1.0'?><!-- c --><ows:A x:b='1 &amp; 2'><wms:C> a &lt;&#233;<![CDATA[&d]]> </wms:C><D/></ows:A>",
        )
        .expect("XML");
        assert_eq!((root.name.as_str(), root.attribute("b")), ("A", Some("1 & 2")));
        assert_eq!(root.text_of("C"), Some("a <é&d"));
        assert_eq!(root.all("D").count(), 1);
        assert!(root.find("D").is_some() && root.find("E").is_none());
    }

    // fault 49: entities of capabilities do not unfold
    #[test]
    fn bombs_do_not_go_off() {
        let bomb = b"<!DOCTYPE lolz [<!ENTITY lol 'lol'><!ENTITY l2 '&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;'>\
            <!ENTITY x SYSTEM 'file:///etc/passwd'>]><a>&l2;&x;</a>";
        let text = Element::parse(bomb).map(|root| root.text);
        assert!(text.clone().map_or(true, |text| text.len() < 20), "{text:?}");
        let deep = "<a>".repeat(100_000);
        assert!(Element::parse(deep.as_bytes()).unwrap_err().contains("deep"));
        let wide = format!("<a>{}</a>", "<b/>".repeat(MAX_ELEMENTS + 1));
        assert!(Element::parse(wide.as_bytes()).unwrap_err().contains("elements"));
        let many = format!("<a {}/>", (0..1000).map(|i| format!("a{i}='{i}' ")).collect::<String>());
        assert!(Element::parse(many.as_bytes()).is_ok());
        let wide = format!("<a>{}</a>", format!("<b{}/>", " c=''".repeat(1000)).repeat(201));
        assert!(Element::parse(wide.as_bytes()).unwrap_err().contains("attributes"));
        let long = format!("<a>{}</a>", "b&amp;".repeat(MAX_PARTS / 2));
        assert!(Element::parse(long.as_bytes()).unwrap_err().contains("entities"));
        assert!(Element::parse(&vec![b' '; MAX_BYTES + 1]).is_err());
    }

    #[test]
    fn what_is_no_document_is_refused() {
        for text in ["", "plain", "<a>", "<a></b>", "</a>", "<a/><b/>", "<a", "<a>&#x110000;</a>"] {
            let _ = Element::parse(text.as_bytes());
        }
        assert!(
            Element::parse(b"<a>").is_err() && Element::parse(b"").is_err() && Element::parse(b"<a/><b/>").is_err()
        );
    }

    #[test]
    fn latin_1_is_understood() {
        let root = Element::parse(b"<?xml version='1.0' encoding=\"ISO-8859-1\"?><a>Espa\xf1a</a>").expect("XML");
        assert_eq!(root.text, "España");
    }
}
