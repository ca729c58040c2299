//! Parser of prior files.

use super::spelling::hint;
use super::{Distribution, Entry, PriorFile};
use crate::ModelError;
use toml::{Table, Value};

const FORMAT: &str = "trundle-prior/1";

const DISTRIBUTIONS: [&str; 6] = ["normal", "log_normal", "uniform", "on_body", "angle", "fixed"];

impl PriorFile {
    /// Parse the text of a prior file; `source` is the file name for messages.
    ///
    /// # Errors
    /// Names the file, the entry, and the value that is unknown, missing or not a number.
    pub fn from_toml(text: &str, source: &str) -> Result<Self, ModelError> {
        let bad =
            |place: &str, problem| ModelError::Prior { file: source.into(), place: place.into(), problem };
        let file: Table = toml::from_str(text).map_err(|e| bad("TOML", e.to_string()))?;
        let mut entries = vec![];
        for (name, table) in &file {
            match table {
                Value::Table(table) => {
                    for (key, value) in table {
                        let slot = format!("{name}.{key}");
                        let entry = entry(&slot, value).map_err(|problem| bad(&slot, problem))?;
                        entries.push(entry);
                    }
                }
                Value::String(format) if name == "format" && format == FORMAT => {}
                value if name == "format" => {
                    return Err(bad(name, format!("{value}: must be \"{FORMAT}\"")));
                }
                _ => {
                    let remedy = "group priors in tables by effect, such as `[body]` with `mass = { … }`";
                    return Err(bad(name, format!("is not a table: {remedy}")));
                }
            }
        }
        Ok(Self { source: source.to_owned(), entries })
    }
}

fn entry(slot: &str, value: &Value) -> Result<Entry, String> {
    let Value::Table(table) = value else {
        return Err(match value {
            Value::Integer(_) | Value::Float(_) => format!(
                "is {value}, not a prior: write {{ distribution = \"fixed\", value = {value} }} to hold it constant"
            ),
            _ => format!("is {value}, not a prior: give a table with `distribution`"),
        });
    };
    let per_episode = match table.get("scope").map(|scope| (scope.as_str(), scope)) {
        None | Some((Some("all"), _)) => false,
        Some((Some("episode"), _)) => true,
        Some((_, other)) => return Err(format!("scope = {other}: must be \"all\" or \"episode\"")),
    };
    let distribution = match table.get("distribution") {
        None if per_episode => {
            check_keys(table, &[])?;
            None
        }
        None => return Err(format!("has no `distribution`: {}", hint("", &DISTRIBUTIONS))),
        Some(Value::String(name)) => Some(distribution(name, table)?),
        Some(other) => return Err(format!("distribution = {other}: {}", hint("", &DISTRIBUTIONS))),
    };
    if per_episode && matches!(distribution, Some(Distribution::Fixed { .. })) {
        return Err("is fixed and therefore the same in every episode: remove `scope`".to_owned());
    }
    Ok(Entry { slot: slot.to_owned(), distribution, per_episode })
}

fn distribution(name: &str, table: &Table) -> Result<Distribution, String> {
    let [must, may] = distribution_keys(name)?;
    check_keys(table, &[must, may].concat())?;
    let number =
        |key: &str| optional_number(table, key)?.ok_or_else(|| format!("has no `{key}`: {name} needs it"));
    Ok(match name {
        "normal" | "log_normal" => {
            let sd = number("sd")?;
            if sd <= 0.0 {
                return Err(format!(
                    "sd = {sd}: must be positive; fix a value with distribution = \"fixed\""
                ));
            }
            let (low, high) = (optional_number(table, "low")?, optional_number(table, "high")?);
            match name {
                "normal" => Distribution::Normal { mean: number("mean")?, sd, low, high },
                _ => Distribution::LogNormal { median: number("median")?, sd, low, high },
            }
        }
        "uniform" => Distribution::Uniform { low: number("low")?, high: number("high")? },
        "on_body" => Distribution::OnBody,
        "angle" => Distribution::Angle,
        _ => Distribution::Fixed { value: number("value")? },
    })
}

/// Required and optional keys of a distribution.
fn distribution_keys(name: &str) -> Result<[&'static [&'static str]; 2], String> {
    Ok(match name {
        "normal" => [&["mean", "sd"], &["low", "high"]],
        "log_normal" => [&["median", "sd"], &["low", "high"]],
        "uniform" => [&["low", "high"], &[]],
        "on_body" | "angle" => [&[], &[]],
        "fixed" => [&["value"], &[]],
        _ => return Err(format!("distribution = \"{name}\" is unknown: {}", hint(name, &DISTRIBUTIONS))),
    })
}

fn check_keys(table: &Table, known: &[&str]) -> Result<(), String> {
    let known = [&["distribution", "scope"], known].concat();
    match table.keys().find(|key| !known.contains(&key.as_str())) {
        Some(key) => Err(format!("unknown key `{key}`: {}", hint(key, &known))),
        None => Ok(()),
    }
}

fn optional_number(table: &Table, key: &str) -> Result<Option<f64>, String> {
    let Some(value) = table.get(key) else { return Ok(None) };
    let number = value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
    match number.filter(|n| n.is_finite()) {
        Some(number) => Ok(Some(number)),
        None => Err(format!("{key} = {value}: must be a finite number")),
    }
}
