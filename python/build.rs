//! Computes the version of the sources, so that results identify the code that produced them.

use std::path::{Path, PathBuf};

/// Sources of a diagnosis of pushed objects, except [`JOINT_SOURCES`], relative to this crate.
const PLANAR_SOURCES: [&str; 5] = [
    "../Cargo.lock",
    "../env/model/src",
    "../env/record/src",
    "../adaptive/infer/src",
    "../adaptive/diagnose/src",
];

/// Further sources of a diagnosis of joints.
const JOINT_SOURCES: [&str; 2] = ["../env/record/src/joints", "../adaptive/mechanism/src"];

/// Further sources of other results.
const OTHER_SOURCES: [&str; 6] = [
    "../env/sim/src",
    "../adaptive/control/src",
    "../adaptive/posterior/src",
    "../adaptive/estimate/src",
    "../adaptive/paper/src",
    "src",
];

/// First line of the tests at the end of a file, which do not affect results.
const TEST_MODULE: &str = "mod tests {";

fn main() -> std::io::Result<()> {
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    add(&mut hash, &PLANAR_SOURCES, &JOINT_SOURCES)?;
    println!("cargo::rustc-env=TRUNDLE_PLANAR_SOURCES={:016x}", hash.0);
    add(&mut hash, &JOINT_SOURCES, &[])?;
    println!("cargo::rustc-env=TRUNDLE_JOINT_SOURCES={:016x}", hash.0);
    add(&mut hash, &OTHER_SOURCES, &[])?;
    println!("cargo::rustc-env=TRUNDLE_ALL_SOURCES={:016x}", hash.0);
    Ok(())
}

/// Adds the code below some folders, except that below others.
fn add(hash: &mut Fnv, sources: &[&str], except: &[&str]) -> std::io::Result<()> {
    for source in sources {
        println!("cargo::rerun-if-changed={source}");
        for file in files(Path::new(source))? {
            if except.iter().any(|folder| file.starts_with(folder)) {
                continue;
            }
            hash.add(&file.to_string_lossy());
            std::fs::read_to_string(&file)?
                .lines()
                .take_while(|line| *line != TEST_MODULE)
                .filter(|line| !is_comment(line))
                .for_each(|line| hash.add(line));
        }
    }
    Ok(())
}

/// Whether a line is a comment, which does not affect results.
fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with("//")
}

/// A file, or all files below a folder, sorted. A package without the other crates' sources has none.
fn files(path: &Path) -> std::io::Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(if path.exists() { vec![path.to_owned()] } else { vec![] });
    }
    let mut entries = std::fs::read_dir(path)?.map(|e| Ok(e?.path())).collect::<std::io::Result<Vec<_>>>()?;
    entries.sort();
    let below = entries.iter().map(|entry| files(entry)).collect::<std::io::Result<Vec<_>>>()?;
    Ok(below.concat())
}

/// FNV-1a of 64 bits (Fowler, Noll, Vo): it tells versions apart, and nobody has a reason to forge one.
struct Fnv(u64);

impl Fnv {
    fn add(&mut self, text: &str) {
        for byte in text.bytes().chain([0]) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
