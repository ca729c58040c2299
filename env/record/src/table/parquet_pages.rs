//! Validation of the page headers of a Parquet column before decoding.
//!
//! The decoder allocates the sizes that a header states, up to 2 GiB for a page and 50 GiB for a dictionary, and a failed
//! allocation aborts the process. Headers are encoded in Thrift's compact protocol. `PageHeader` in Apache Parquet's
//! `parquet.thrift` defines the fields read here.

use std::fs::File;

use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{ChunkReader, Length};

use super::budget::Budget;
use crate::fault::Fault;

/// Memory that the decoder uses per dictionary entry, bytes.
const DICTIONARY_ENTRY_BYTES: usize = 32;
/// Largest nesting depth of structures. Parquet headers have three levels.
const MAX_DEPTH: usize = 8;

/// Refuses a column chunk whose pages need more memory than `budget` has left.
///
/// # Errors
/// Also if a header is invalid, or a page extends past the end of the chunk.
pub(super) fn check(file: &File, column: &ColumnChunkMetaData, budget: &Budget) -> Result<(), Fault> {
    let damaged = |message: &str| Fault::Parquet { message: message.to_owned() };
    let (start, length) = range(column).ok_or_else(|| damaged("a column has a negative offset or size"))?;
    if start.checked_add(length).is_none_or(|end| end > file.len()) {
        return Err(damaged("a column extends past the end of the file"));
    }
    let bytes = file.get_bytes(start, length as usize).map_err(|error| damaged(&error.to_string()))?;
    let mut rest = &bytes[..];
    while !rest.is_empty() {
        let (page, after) = Page::read(rest).ok_or_else(|| damaged("a page has an invalid header"))?;
        budget.check(page.unpacked, 1)?;
        budget.check(page.entries, DICTIONARY_ENTRY_BYTES)?;
        rest =
            after.get(page.packed..).ok_or_else(|| damaged("a page extends past the end of its column"))?;
    }
    Ok(())
}

/// Offset and length of a column chunk; `None` if one of them is negative.
fn range(column: &ColumnChunkMetaData) -> Option<(u64, u64)> {
    let start = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
    Some((u64::try_from(start).ok()?, u64::try_from(column.compressed_size()).ok()?))
}

/// Sizes of a page, bytes, and the number of entries of a dictionary page.
#[derive(Debug, Default, PartialEq)]
struct Page {
    unpacked: u64,
    packed: usize,
    entries: u64,
}

impl Page {
    /// Decodes a header. Returns the page and the bytes after the header.
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

/// Field identifiers of `PageHeader`.
const UNPACKED: i64 = 2;
const PACKED: i64 = 3;
const DICTIONARY: i64 = 7;
/// Field identifier in `DictionaryPageHeader`.
const ENTRIES: i64 = 1;

/// Decoder of Thrift's compact protocol over the remaining bytes. Methods return `None` if the bytes end early or are
/// invalid.
struct Compact<'a>(&'a [u8]);

impl Compact<'_> {
    /// Decodes a structure that is the field `outer` of another. Calls `found` with `outer`, the field and the value of each
    /// integer.
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
                // The type itself encodes the boolean.
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
        // Each entry has at least one byte, so an invalid count ends with the input.
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
    fn sizes_are_decoded() {
        // type 2, unpacked 300, packed 5, dictionary { entries 3, encoding 0, sorted }, and two bytes of the page.
        let bytes = [0x15, 4, 0x15, 0xD8, 4, 0x15, 10, 0x4C, 0x15, 6, 0x15, 0, 0x11, 0, 0, 7, 7];
        let (page, rest) = Page::read(&bytes).unwrap();
        assert_eq!(page, Page { unpacked: 300, packed: 5, entries: 3 });
        assert_eq!(rest, [7, 7]);
    }

    #[test]
    fn invalid_headers_are_none() {
        let negative = [0x15, 4, 0x15, 1, 0];
        let text_beyond_the_end = [0x18, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F];
        let endless = [0x1C; 64];
        for bytes in [&negative[..], &text_beyond_the_end, &endless, &[], &[0x15]] {
            assert_eq!(Page::read(bytes), None, "{bytes:?}");
        }
    }
}
