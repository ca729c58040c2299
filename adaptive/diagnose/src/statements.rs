//! Statements about effects, and formatted quantities.

use trundle_infer::{Estimate, Fit};
use trundle_model::Effect;
use trundle_record::Dataset;

/// A number with its standard deviation and unit, rounded to the first digit of the deviation: `14.2 ± 0.3
/// N`.
pub(crate) fn quantity(mean: f64, sd: f64, unit: &str) -> String {
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    if !(sd.is_finite() && sd > 0.0) {
        return format!("{mean:.3}{unit}");
    }
    let digits = (-sd.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{mean:.digits$} ± {sd:.digits$}{unit}")
}

/// The catalogue's sentence for an effect with its fitted parameters. A choice reads as the name of the episode, and
/// unidentifiable parameters read "unknown".
pub(crate) fn statement(effect: &Effect, name: &str, fit: &Fit, data: &Dataset) -> String {
    let mut sentence = effect.kind.spec().sentence.to_owned();
    for (param, value) in effect.kind.spec().params.iter().zip(&effect.values) {
        let episode = value.filter(|_| param.role.is_choice()).and_then(|ordinal| data.episode_name(ordinal));
        let estimated = || match (fit.estimate(&format!("{name}.{}", param.name)), value) {
            (Some(Estimate { mean, sd, identified: true, unit, .. }), _) => quantity(*mean, *sd, unit),
            (None, Some(given)) => quantity(*given, 0.0, param.unit),
            _ => "unknown".to_owned(),
        };
        let text = episode.map_or_else(estimated, str::to_owned);
        sentence = sentence.replace(&format!("{{{}}}", param.name), &text);
    }
    with_unknown_place(&sentence)
}

/// Replace a position with two unknown coordinates, and an unknown time, by phrases.
fn with_unknown_place(sentence: &str) -> String {
    sentence
        .replace("at (unknown, unknown)", "at a point that the data do not determine")
        .replace("At unknown in", "At a time that the data do not determine in")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{quantity, statement, with_unknown_place};
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::{Comparison, FitOptions, Quiet, fit};
    use trundle_model::Kind;

    #[test]
    fn digits_follow_the_deviation() {
        assert_eq!(quantity(14.2345, 0.31, "N"), "14.2 ± 0.3 N");
        assert_eq!(quantity(203.5, 12.0, "N·s/m"), "204 ± 12 N·s/m");
        assert_eq!(quantity(-0.481_23, 0.0021, "m"), "-0.481 ± 0.002 m");
        assert_eq!(quantity(1.2512, 0.0011, "1"), "1.251 ± 0.001");
    }

    #[test]
    fn an_event_names_its_episode() {
        let data = World::of(locked()).recording(1);
        let options = FitOptions { starts: 1, ..FitOptions::default() };
        let fitted = fit(&Comparison::of(&data).unwrap(), &locked(), &[], &options, &Quiet).unwrap();
        let ordinal = data.training[1].ordinal as f64;
        let load = effect(Kind::MassChange, &[("episode", ordinal), ("time", 2.0), ("mass", 5.0)]);
        let sentence = statement(&load, "mass_change", &fitted, &data);
        let name = &data.training[1].name;
        assert!(sentence.starts_with(&format!("At 2.000 s in {name} the mass changes")), "{sentence}");
    }

    #[test]
    fn an_unknown_place_reads_as_a_phrase() {
        let sentence = with_unknown_place("Dry friction of 7 ± 1 N acts at (unknown, unknown).");
        assert_eq!(sentence, "Dry friction of 7 ± 1 N acts at a point that the data do not determine.");
        let known = "Dry friction of 7 ± 1 N acts at (0.1 ± 0.2 m, unknown).";
        assert_eq!(with_unknown_place(known), known);
        let sentence = with_unknown_place("At unknown in push_2 the mass changes.");
        assert_eq!(sentence, "At a time that the data do not determine in push_2 the mass changes.");
    }
}
