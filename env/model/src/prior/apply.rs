//! Application of a prior file to a model.

use super::spelling::hint;
use super::{Distribution, Entry, PriorFile, TruncatedPrior};
use crate::law::Prior;
use crate::{Model, ModelError, Slot};

/// Largest distance, in standard deviations, between the centre of a distribution and its support. Beyond it the
/// support has practically no probability.
const MAX_CENTRE_DISTANCE_SD: f64 = 6.0;

impl PriorFile {
    /// Copy of the model with these priors; a `fixed` distribution sets the value. A refinement with a prior becomes
    /// free.
    ///
    /// # Errors
    /// When the model has no such parameter or already fixes it, or when a prior exceeds the bounds. The message names
    /// the file, the parameter, the value and the remedy.
    pub fn apply(&self, model: &Model) -> Result<Model, ModelError> {
        let mut model = model.clone();
        for entry in &self.entries {
            self.apply_entry(&mut model, entry).map_err(|problem| ModelError::Prior {
                file: self.source.clone(),
                place: entry.slot.clone(),
                problem,
            })?;
        }
        Ok(model)
    }

    fn apply_entry(&self, model: &mut Model, entry: &Entry) -> Result<(), String> {
        model.free_refinement(&entry.slot);
        let slots = model.slots();
        let Some((index, slot)) = slots.iter().enumerate().find(|(_, s)| s.name == entry.slot) else {
            let known: Vec<&str> = slots.iter().map(|s| s.name.as_str()).collect();
            return Err(format!("the model has no such parameter: {}", hint(&entry.slot, &known)));
        };
        if let Some(value) = slot.value {
            let remedy = "remove the prior, or remove the value from the model or recording";
            return Err(format!("is given as {value} {}: {remedy}", slot.unit));
        }
        match entry.distribution {
            None => {}
            Some(Distribution::Fixed { value }) => {
                check_bounds(slot, "value", value)?;
                model.set_value(index, value);
            }
            Some(distribution) => {
                model.priors.insert(entry.slot.clone(), truncated(slot, distribution)?);
            }
        }
        Ok(())
    }
}

/// Truncated prior of a distribution, checked against the bounds of the slot.
fn truncated(slot: &Slot, distribution: Distribution) -> Result<TruncatedPrior, String> {
    let cut = |prior, low: Option<f64>, high: Option<f64>| {
        let (lower, upper) = (low.unwrap_or(slot.lower), high.unwrap_or(slot.upper));
        check_bounds(slot, "low", lower)?;
        check_bounds(slot, "high", upper)?;
        if lower >= upper {
            return Err(format!("low = {lower}, high = {upper}: low must be less than high"));
        }
        Ok(TruncatedPrior { prior, lower, upper })
    };
    match distribution {
        Distribution::Normal { mean, sd, low, high } => {
            check_bounds(slot, "mean", mean)?;
            let truncated = cut(Prior::Normal { mean, sd }, low, high)?;
            check_centre(
                "mean",
                mean,
                [(truncated.lower - mean) / sd, (mean - truncated.upper) / sd],
                &truncated,
            )
        }
        Distribution::LogNormal { median, sd, low, high } => {
            if median <= 0.0 {
                return Err(format!("median = {median}: a log-normal median must be positive"));
            }
            check_bounds(slot, "median", median)?;
            let low = low.or(Some(slot.lower.max(0.0)));
            let truncated = cut(Prior::LogNormal { median, sd }, low, high)?;
            if truncated.lower < 0.0 {
                return Err(format!("low = {}: log-normal values are positive", truncated.lower));
            }
            let away = [(truncated.lower / median).ln() / sd, (median / truncated.upper).ln() / sd];
            check_centre("median", median, away, &truncated)
        }
        Distribution::Uniform { low, high } => {
            let truncated = cut(Prior::Uniform, Some(low), Some(high))?;
            match slot.prior {
                Prior::Angle(period) if high - low > period * (1.0 + 1e-9) => Err(format!(
                    "low = {low}, high = {high}: exceeds the period {period:.5} rad; for the full circle \
                     write distribution = \"angle\""
                )),
                _ => Ok(truncated),
            }
        }
        Distribution::OnBody => match slot.prior {
            Prior::OnBody(_) => cut(slot.prior, None, None),
            _ => Err(format!("is not a position on the body ({}): on_body requires a position", slot.unit)),
        },
        Distribution::Angle => match slot.prior {
            Prior::Angle(_) => cut(slot.prior, None, None),
            _ => Err(format!("is not an angle ({}): angle requires a direction", slot.unit)),
        },
        Distribution::Fixed { .. } => cut(slot.prior, None, None),
    }
}

/// Check that a distribution has probability on its support. `away`: distances of its centre below and above the
/// support, in standard deviations.
fn check_centre(
    what: &str,
    centre: f64,
    away: [f64; 2],
    truncated: &TruncatedPrior,
) -> Result<TruncatedPrior, String> {
    let TruncatedPrior { lower, upper, .. } = truncated;
    match away.into_iter().find(|sds| *sds > MAX_CENTRE_DISTANCE_SD) {
        Some(sds) => Err(format!(
            "{what} = {centre} lies {sds:.1} standard deviations outside [{lower}, {upper}]: \
             widen sd, or move the {what}"
        )),
        None => Ok(*truncated),
    }
}

fn check_bounds(slot: &Slot, what: &str, value: f64) -> Result<(), String> {
    let Slot { lower, upper, unit, .. } = slot;
    if (*lower..=*upper).contains(&value) {
        return Ok(());
    }
    Err(format!("{what} = {value}: must be in [{lower}, {upper}] {unit}"))
}
