//! Names of episodes.

use std::path::{Component, Path};

use crate::fault::Fault;

/// Whether `c` is printable: not a control character, not invisible, and not a change of the text direction.
pub(crate) fn is_printable(c: char) -> bool {
    !c.is_control()
        && !matches!(c, '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{206F}' | '\u{FEFF}')
}

/// Refuses a name that is not a valid file name, or that contains characters that are not printable. An escape sequence
/// or a line break in a name could disguise terminal output.
pub(crate) fn check_name(name: &str) -> Result<(), Fault> {
    let mut parts = Path::new(name).components();
    let single =
        matches!((parts.next(), parts.next()), (Some(Component::Normal(part)), None) if part == name);
    if single && !name.starts_with('.') && !name.contains('\\') && name.chars().all(is_printable) {
        return Ok(());
    }
    Err(Fault::EpisodeName { name: name.to_owned() })
}
