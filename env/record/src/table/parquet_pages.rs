//! What the headers of a column's pages say of their size, read before the decoder believes them.
//!
//! The decoder reserves what a header asks for, up to 2 GiB for a page and 50 GiB for a dictionary, and a program
//! that does not get it ends at once. Headers are structures in Thrift's compact protocol; those of the fields that
//! are read here are in `PageHeader` of Apache Parquet's `parquet.thrift`.

use std::fs::File;

use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{ChunkReader, Length};

use super::budget::Budget;
use crate::fault::Fault;

/// Memory that the decoder takes for an entry of a dictionary, bytes: a reference to text.
const ENTRY: usize = 32;
/// Structures in structures; Parquet's have three levels.
const MAX_DEPTH: usize = 8;

/// Refuses a column chunk whose pages ask for more memory than is left.
///
/// # Errors
/// Also when a header is none, or a page ends behind the chunk.
pub(super) fn check(file: &File, column: &ColumnChunkMetaData, budget: &Budget) -> Result<(), Fault> {
    let damaged = |message: &str| Fault::Parquet { message: message.to_owned() };
    let (start, length) = range(column).ok_or_else(|| damaged("a column has no place in the file"))?;
    if start.checked_add(length).is_none_or(|end| end > file.len()) {
        return Err(damaged("a column lies behind the file's end"));
    }
    let bytes = file.get_bytes(start, length as usize).map_err(|error| damaged(&error.to_string()))?;
    let mut rest = &bytes[..];
    while !rest.is_empty() {
        let (page, after) = Page::read(rest).ok_or_else(|| damaged("a page's header makes no sense"))?;
        budget.check(page.unpacked, 1)?;
        budget.check(page.entries, ENTRY)?;
        rest = after.get(page.packed..).ok_or_else(|| damaged("a page ends behind its column"))?;
    }
    Ok(())
}

/// First byte and length of a column chunk; `None` where the file says that one of them is negative.
fn range(column: &ColumnChunkMetaData) -> Option<(u64, u64)> {
    let start = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
    Some((u64::try_from(start).ok()?, u64::try_from(column.compressed_size()).ok()?))
}

/// Sizes of a page, bytes, and the number of entries if it is a dictionary.
#[derive(Debug, Default, PartialEq)]
struct Page {
    unpacked: u64,
    packed: usize,
    entries: u64,
}

impl Page {
    /// Reads a header: the page, and what follows the header.
    fn read(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let mut page = Self::default();
        let mut header = Compact(bytes);
        let mut negative = false;
        header.structure(0, 0, &mut |outer, field, value| {
            let size = value.cast_unsigned();
            match (outer, field) {
                (0, UNPACKED) => page.unpacked = size,
                (0, PACKED) => page.packed = size as usize,
                (DICTIONARY, ENTRIES) => page.entries = size,
                _ => return,
            }
            negative |= value < 0;
        })?;
        (!negative).then_some((page, header.0))
    }
}

/// Fields of `PageHeader`.
const UNPACKED: i64 = 2;
const PACKED: i64 = 3;
const DICTIONARY: i64 = 7;
/// Field of `DictionaryPageHeader`.
const ENTRIES: i64 = 1;

/// What is left of a text in Thrift's compact protocol. `None` where it ends too early or makes no sense.
struct Compact<'a>(&'a [u8]);

impl Compact<'_> {
    /// Reads a structure, which is the field `outer` of another; integers go to `found` with `outer` and their field.
    fn structure(&mut self, depth: usize, outer: i64, found: &mut dyn FnMut(i64, i64, i64)) -> Option<()> {
        if depth >= MAX_DEPTH {
            return None;
        }
        let mut field = 0;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Some(());
            }
            field = match head >> 4 {
                0 => self.signed()?,
                more => field + i64::from(more),
            };
            match head & 0xF {
                // The type says whether it is true.
                1 | 2 => {}
                4..=6 => found(outer, field, self.signed()?),
                12 => self.structure(depth + 1, if depth == 0 { field } else { -1 }, found)?,
                kind => self.skip(depth, kind)?,
            }
        }
    }

    fn skip(&mut self, depth: usize, kind: u8) -> Option<()> {
        match kind {
            1..=3 => self.bytes(1),
            4..=6 => self.unsigned().map(drop),
            7 => self.bytes(8),
            8 => {
                let length = self.unsigned()?;
                self.bytes(usize::try_from(length).ok()?)
            }
            9 | 10 => self.list(depth),
            12 => self.structure(depth + 1, -1, &mut |_, _, _| {}),
            _ => None,
        }
    }

    fn list(&mut self, depth: usize) -> Option<()> {
        let head = self.byte()?;
        let count = match head >> 4 {
            15 => self.unsigned()?,
            few => u64::from(few),
        };
        // Each entry has a byte at least, so that a count that is made up ends with the text.
        (depth < MAX_DEPTH).then_some(())?;
        (0..count).try_for_each(|_| self.skip(depth + 1, head & 0xF))
    }

    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn bytes(&mut self, count: usize) -> Option<()> {
        self.0 = self.0.get(count..)?;
        Some(())
    }

    fn unsigned(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn signed(&mut self) -> Option<i64> {
        let value = self.unsigned()?;
        Some((value >> 1).cast_signed() ^ -((value & 1).cast_signed()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_headers_sizes_are_read() {
        // type 2, unpacked 300, packed 5, dictionary { entries 3, encoding 0, sorted }, and two bytes of the page.
        let bytes = [0x15, 4, 0x15, 0xD8, 4, 0x15, 10, 0x4C, 0x15, 6, 0x15, 0, 0x11, 0, 0, 7, 7];
        let (page, rest) = Page::read(&bytes).unwrap();
        assert_eq!(page, Page { unpacked: 300, packed: 5, entries: 3 });
        assert_eq!(rest, [7, 7]);
    }

    #[test]
    fn what_is_no_header_is_none() {
        let negative = [0x15, 4, 0x15, 1, 0];
        let text_beyond_the_end = [0x18, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F];
        let endless = [0x1C; 64];
        for bytes in [&negative[..], &text_beyond_the_end, &endless, &[], &[0x15]] {
            assert_eq!(Page::read(bytes), None, "{bytes:?}");
        }
    }
}
