//! XML of services: the bounded tree of plan files, and the exceptions of WMS and OWS.

pub use vencejo_flight::formats::xml::{Element, MAX_BYTES};

/// Text of an XML exception (WMS 1.1.1 and 1.3.0 `ServiceException`, OWS `ExceptionText`), or `None`.
pub fn exception(root: &Element) -> Option<String> {
    // Capabilities speak of exceptions too.
    if !root.name.ends_with("ExceptionReport") {
        return None;
    }
    let (code, text) = if let Some(exception) = root.find("ServiceException") {
        (exception.attribute("code"), exception.text.clone())
    } else {
        let exception = root.find("Exception")?;
        (exception.attribute("exceptionCode"), exception.text_of("ExceptionText").unwrap_or_default().to_owned())
    };
    let text = crate::sniff::one_line(&text, 300);
    Some(match (code.filter(|code| !code.is_empty()), text.is_empty()) {
        (Some(code), false) => format!("{text} ({code})"),
        (Some(code), true) => code.to_owned(),
        (None, false) => text,
        (None, true) => "an exception without words".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exceptions_of_both_standards_are_told() {
        let wms = "<ServiceExceptionReport><ServiceException code='LayerNotDefined'>\n msWMSLoadGetMapParams(): Invalid\n \
                   layer </ServiceException></ServiceExceptionReport>";
        let said = exception(&Element::parse(wms.as_bytes()).expect("XML"));
        assert_eq!(said.as_deref(), Some("msWMSLoadGetMapParams(): Invalid layer (LayerNotDefined)"));
        let ows = "<ows:ExceptionReport><ows:Exception exceptionCode='TileOutOfRange'/></ows:ExceptionReport>";
        assert_eq!(exception(&Element::parse(ows.as_bytes()).expect("XML")).as_deref(), Some("TileOutOfRange"));
        assert_eq!(exception(&Element::parse(b"<a/>").expect("XML")), None);
    }
}
