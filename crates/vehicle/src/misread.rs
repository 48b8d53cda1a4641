//! Error texts for invalid values of requests. Serde's own texts name Rust types; they (`serde::de::Error`) are parsed
//! and rephrased here, once for all front ends. For values of several alternative kinds serde does not report the value
//! given: `several.rs` does.

/// Name of the whole input, which has no field name.
const ALL: &str = "what was given";

/// The error for an invalid value: its path, the value, what is expected, and the range or unit of the field with this
/// name.
pub fn in_words(path: &str, said: &str, takes: impl Fn(&str) -> Option<String>) -> String {
    let is_place = |place: &str| place.bytes().all(|byte| byte.is_ascii_digit() || b" column".contains(&byte));
    let said = said.rsplit_once(" at line ").filter(|(_, place)| is_place(place)).map_or(said, |(said, _)| said);
    let part = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    let (named, last) = if path.is_empty() { (ALL, "") } else { (path, path.rsplit('.').next().unwrap_or_default()) };
    // The first name in backticks.
    let quoted = said.split('`').nth(1).unwrap_or_default();
    let after = |phrase: &str| said.strip_prefix(phrase);
    if let Some((given, expected)) = after("invalid type: ")
        .or_else(|| after("invalid value: "))
        .or_else(|| after("invalid length "))
        .and_then(|rest| rest.rsplit_once(", expected "))
    {
        let (kind, range) = as_taken(expected);
        let taken = takes(last).or(range).map(|taken| format!(" ({taken})")).unwrap_or_default();
        return format!("{named} is {}, should be {kind}{taken}", as_given(given));
    }
    if after("missing field ").is_some() {
        let taken = takes(quoted).map(|taken| format!(" ({taken})")).unwrap_or_default();
        return format!("{} is missing{taken}", part(quoted));
    }
    if after("duplicate field ").is_some() {
        return format!("{} is given twice", part(quoted));
    }
    if after("unknown field ").is_some() {
        // Its path ends with it, where serde_path_to_error was there.
        let name = if last == quoted { path.to_owned() } else { part(quoted) };
        return match choices(said) {
            Some(names) => format!("there is no {name}; taken are {}", names.trim_start_matches("one of ")),
            None => format!("there is no {name}; no values are taken"),
        };
    }
    if after("unknown variant ").is_some() {
        let choices = choices(said).unwrap_or_default();
        return if path.is_empty() {
            format!("there is no {quoted}: {choices}")
        } else {
            format!("{path} is \"{quoted}\", should be {choices}")
        };
    }
    // From serde_json, for enumerated words, and from Rust's own parsers.
    let none_of_them = match said {
        "expected value" => Some("text"),
        "invalid float literal" => Some("number"),
        "invalid digit found in string" | "number too large to fit in target type" => Some("whole number in range"),
        _ => None,
    };
    if let Some(kind) = none_of_them {
        let taken = takes(last).map(|taken| format!(" ({taken})")).unwrap_or_default();
        return format!("{named} is not a {kind}{taken}");
    }
    if path.is_empty() { said.to_owned() } else { format!("{path}: {said}") }
}

/// The names listed by serde.
fn choices(said: &str) -> Option<String> {
    let (_, list) = said.rsplit_once(", expected ")?;
    Some(list.replace('`', ""))
}

/// The value as the caller wrote it.
fn as_given(given: &str) -> String {
    let text = match given {
        "map" => "an object",
        "sequence" => "a list",
        "null" | "unit value" | "Option value" => "null",
        given if given.bytes().all(|byte| byte.is_ascii_digit()) => return format!("a list of {given}"),
        given => given.strip_prefix("string ").or_else(|| given.split('`').nth(1)).unwrap_or(given),
    };
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}

/// The expected kind without the names of Rust's types, with the range of a whole number.
fn as_taken(expected: &str) -> (String, Option<String>) {
    let whole = |range: String| ("a whole number".to_owned(), Some(range));
    let kind = match expected {
        "u8" => return whole(format!("0 to {}", u8::MAX)),
        "u16" => return whole(format!("0 to {}", u16::MAX)),
        "u32" => return whole(format!("0 to {}", u32::MAX)),
        "u64" | "usize" => return whole("from 0".to_owned()),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number",
        "f32" | "f64" => "a number",
        "a boolean" => "true or false",
        "a string" | "a borrowed string" | "string or map" | "variant identifier" => "a text",
        "a sequence" => "a list",
        "a map" => "an object",
        other => {
            let length = other.strip_prefix("an array of length ").or_else(|| other.strip_prefix("a tuple of size "));
            match (length, other.split(' ').next()) {
                (Some(length), _) => return (format!("a list of {length}"), None),
                (None, Some("struct" | "internally" | "adjacently")) => "an object",
                (None, Some("enum")) => "a text",
                (None, _) => other,
            }
        }
    };
    (kind.to_owned(), None)
}

/// The unit in the suffix of a value's name.
pub fn unit(name: &str) -> Option<&'static str> {
    const UNITS: [(&str, &str); 9] = [
        ("_m_s2", "m/s²"),
        ("_m_s", "m/s"),
        ("_rad_s", "rad/s"),
        ("_deg", "degrees"),
        ("_rad", "radians"),
        ("_hz", "Hz"),
        ("_m", "metres"),
        ("_s", "seconds"),
        ("_pct", "percent"),
    ];
    UNITS.into_iter().find_map(|(ending, unit)| name.ends_with(ending).then_some(unit))
}
