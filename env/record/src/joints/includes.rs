//! Files that an MJCF document includes.

/// Paths in the `<include file="…"/>` elements of `document`. Empty if it is not UTF-8.
pub(super) fn included(document: &[u8]) -> Vec<String> {
    let Ok(text) = std::str::from_utf8(document) else { return vec![] };
    let text = without_comments(text);
    let elements = text.split("<include").skip(1).filter(|rest| rest.starts_with(char::is_whitespace));
    let tags = elements.filter_map(|rest| rest.split_once('>')).map(|(tag, _)| tag);
    tags.filter_map(|tag| attribute(tag, "file")).collect()
}

fn without_comments(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("<!--") {
        kept.push_str(before);
        rest = after.split_once("-->").map_or("", |(_, after)| after);
    }
    kept + rest
}

/// Value of the attribute `name` of the inside of a tag.
fn attribute(tag: &str, name: &str) -> Option<String> {
    let mut rest = tag.trim_start();
    while let Some((key, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let quote = after.chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
        let (value, tail) = after[1..].split_once(quote)?;
        if key.trim() == name {
            return Some(value.to_owned());
        }
        rest = tail.trim_start();
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn included_finds_the_files_of_elements_only() {
        let text = r#"<mujoco><!-- <include file="no.xml"/> --><include file="a.xml"/>
            <include
              file = 'sub/b.xml' /><included file="no.xml"/><include other="x=y" file="c.xml"></include></mujoco>"#;
        assert_eq!(included(text.as_bytes()), ["a.xml", "sub/b.xml", "c.xml"]);
        assert!(included(b"<include file=\"a.xml\"/>\xff").is_empty());
        assert!(included(b"<include file=\"a.xml <!-- ").is_empty());
    }
}
