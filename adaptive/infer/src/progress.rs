//! Progress of work with several stages: a total share that never decreases, and a stage that never goes
//! back.
//!
//! Each stage reports from 0 to 1, usually several times, because the number of fits is not known in advance.
//! A round of a stage with `n` expected rounds covers 1/n of what remains of the stage. Additional rounds
//! advance ever more slowly, and fewer rounds end with a jump to the next stage.

/// A stage of some work.
#[derive(Clone, Copy, Debug)]
pub struct Stage {
    /// Name under which it reports.
    pub name: &'static str,
    /// Expected share of the total time at which it ends.
    pub end: f64,
    /// Expected number of rounds from 0 to 1.
    pub rounds: f64,
}

/// Progress of some work.
#[derive(Debug)]
pub struct Progress {
    stages: &'static [Stage],
    stage: usize,
    /// The last report.
    last: (String, f64),
    /// Share of the total at which the round began, and the share that it covers.
    round: (f64, f64),
    share: f64,
}

impl Progress {
    /// Work at its start, with its `stages` in order.
    #[must_use]
    pub fn new(stages: &'static [Stage]) -> Self {
        let mut progress =
            Self { stages, stage: 0, last: (String::new(), 0.0), round: (0.0, 0.0), share: 0.0 };
        progress.begin_round();
        progress
    }

    /// Returns the stage and the total share after a report that `what` has reached `done`. An unknown name
    /// and the name of an earlier stage count towards the current stage.
    pub fn advance(&mut self, what: &str, done: f64) -> (&'static str, f64) {
        let done = if done.is_finite() { done.clamp(0.0, 1.0) } else { 0.0 };
        let ahead = self.stages.iter().position(|stage| stage.name == what).filter(|at| *at > self.stage);
        if let Some(ahead) = ahead {
            self.stage = ahead;
            self.share = self.share.max(self.stages[ahead - 1].end);
            self.begin_round();
        } else if what != self.last.0 || done < self.last.1 {
            self.begin_round();
        }
        self.last = (what.to_owned(), done);
        self.share = self.share.max(self.round.0 + self.round.1 * done);
        (self.stages.get(self.stage).map_or("", |stage| stage.name), self.share)
    }

    fn begin_round(&mut self) {
        let (end, rounds) = self.stages.get(self.stage).map_or((1.0, 1.0), |stage| (stage.end, stage.rounds));
        self.round = (self.share, (end - self.share).max(0.0) / rounds.max(1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAGES: [Stage; 3] = [
        Stage { name: "first", end: 0.2, rounds: 1.0 },
        Stage { name: "second", end: 0.8, rounds: 3.0 },
        Stage { name: "third", end: 1.0, rounds: 1.0 },
    ];

    fn followed(reports: &[(&str, f64)]) -> Vec<(&'static str, f64)> {
        let mut progress = Progress::new(&STAGES);
        reports.iter().map(|(what, done)| progress.advance(what, *done)).collect()
    }

    #[test]
    fn a_stage_of_one_round_is_followed_as_it_reports() {
        let seen = followed(&[("first", 0.0), ("first", 0.5), ("first", 1.0), ("third", 0.5)]);
        assert_eq!(seen.iter().map(|s| s.0).collect::<Vec<_>>(), ["first", "first", "first", "third"]);
        for ((_, share), wanted) in seen.iter().zip([0.0, 0.1, 0.2, 0.9]) {
            assert!((share - wanted).abs() < 1e-12, "{share} {wanted}");
        }
    }

    #[test]
    fn neither_share_nor_stage_goes_back_however_often_a_stage_begins_again() {
        let names =
            ["first", "second", "other", "first", "second", "other", "second", "third", "second", "third"];
        let reports: Vec<_> = names
            .iter()
            .cycle()
            .take(200)
            .flat_map(|n| [0.0, 0.7, 0.3, 1.0, f64::NAN].map(|d| (*n, d)))
            .collect();
        let seen = followed(&reports);
        assert!(seen.windows(2).all(|pair| pair[0].1 <= pair[1].1));
        assert!(seen.iter().all(|(_, share)| (0.0..=1.0).contains(share)));
        let place = |name: &str| STAGES.iter().position(|stage| stage.name == name);
        assert!(seen.windows(2).all(|pair| place(pair[0].0) <= place(pair[1].0)));
    }

    #[test]
    fn more_rounds_than_usual_never_reach_the_end_of_their_stage() {
        let reports = [("second", 0.0), ("second", 1.0)].repeat(9);
        let seen = followed(&reports);
        assert!((seen[1].1 - 0.4).abs() < 1e-12, "a third of the stage");
        assert!(seen.iter().all(|(_, share)| *share < 0.8));
        assert!(seen[5].1 > seen[3].1, "each round goes on");
    }
}
