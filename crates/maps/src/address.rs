//! Addresses of services as people give them: what is wrong with one, which hosts it leads to, and texts as parts of
//! one.

use std::collections::BTreeSet;

use url::Url;

/// Characters of an address at most.
const MAX_URL: usize = 2000;

/// Why a text cannot be the address of a service; places such as `{x}` are filled first.
pub fn url_fault(url: &str) -> Option<String> {
    if url.len() > MAX_URL {
        return Some(format!("has more than {MAX_URL} characters"));
    }
    if !(url.starts_with("http://") || url.starts_with("https://")) {
        return Some("begins with https:// or http://".to_owned());
    }
    let filled: String = {
        let mut depth = 0;
        url.chars()
            .filter_map(|c| match c {
                '{' => {
                    depth += 1;
                    None
                }
                '}' => {
                    depth -= 1;
                    Some('0')
                }
                _ if depth > 0 => None,
                c => Some(c),
            })
            .collect()
    };
    match Url::parse(&filled) {
        Err(error) => Some(format!("is no address: {error}")),
        Ok(url) if url.host_str().is_none_or(str::is_empty) => Some("names no host".to_owned()),
        Ok(url) if !url.username().is_empty() || url.password().is_some() => {
            Some("holds a name or password before the host; services are asked without".to_owned())
        }
        Ok(_) => None,
    }
}

/// The hosts that an address can lead to, whatever is filled in.
pub(crate) fn hosts(text: &str, subdomains: &[String]) -> BTreeSet<String> {
    let mut texts = vec![text.to_owned()];
    // The host is before the path; each place there multiplies the addresses.
    for _ in 0..4 {
        let host_end = |text: &str| {
            text.find("://").map_or(0, |at| at + 3 + text[at + 3..].find('/').unwrap_or(text.len() - at - 3))
        };
        let place = |text: &str| {
            let open = text[..host_end(text)].find('{')?;
            let close = open + text[open..].find('}')?;
            Some((open, close))
        };
        texts = texts
            .iter()
            .flat_map(|text| {
                let Some((open, close)) = place(text) else { return vec![text.clone()] };
                let name = text[open + 1..close].to_ascii_lowercase();
                let choices: Vec<String> = match name.strip_prefix("switch:") {
                    Some(_) => text[open + 8..close].split(',').map(|choice| choice.trim().to_owned()).collect(),
                    None if name == "s" => subdomains.to_vec(),
                    // A host that depends on the tile, or on the key itself, belongs to no source.
                    None => Vec::new(),
                };
                choices.iter().map(|choice| format!("{}{choice}{}", &text[..open], &text[close + 1..])).collect()
            })
            .take(100)
            .collect();
    }
    let plain = |text: &String| text.replace(['{', '}'], "0");
    texts.iter().filter_map(|text| Url::parse(&plain(text)).ok()?.host_str().map(str::to_owned)).collect()
}

/// A text as part of a query (RFC 3986, section 2.3).
pub fn escape(text: &str) -> String {
    url::form_urlencoded::byte_serialize(text.as_bytes()).collect::<String>().replace('+', "%20")
}
