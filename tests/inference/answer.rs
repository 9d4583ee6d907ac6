//! The answer to likelihoods made up so that it can be read off: threshold, kept, undecided.

use willis::internals::decision::{Decision, Keep};
use willis::internals::network::{Network, Node, Origin, Vessel};
use willis::internals::sampling::Likelihood;

/// The rules on samples ask nothing of the network but whether A is 0.
fn decide(rule: Keep, result: &Likelihood) -> Decision {
    let mut network = Network::new();
    let ends = [0, 1].map(|_| network.add_node(Node::default()));
    for _ in &result.likelihood {
        network.add_vessel(ends, Vessel::new(0.01, 0.001, Origin::Candidate));
    }
    willis::internals::decision::decide(rule, &network, result).unwrap()
}

/// Uncertain vessels with these L and standard errors.
fn likelihood(figures: &[(f64, f64)]) -> Likelihood {
    Likelihood {
        likelihood: figures.iter().map(|(l, _)| *l).collect(),
        std_error: figures.iter().map(|(_, e)| *e).collect(),
        frequency: figures.iter().map(|(l, _)| l / 10.0).collect(),
        uncertain: vec![true; figures.len()],
        network_resilience: 0.0,
        perfused: 1.0,
        residual: 0.0,
        samples: 100,
        trace: Vec::new(),
    }
}

#[test]
fn the_median_leaves_out_zeros_and_what_is_certain_and_keeps_what_lies_above() {
    let mut result = likelihood(&[(0.0, 0.0), (1.0, 0.1), (3.0, 0.1), (5.0, 0.1), (7.0, 0.1), (0.0, 0.0), (100.0, 0.1)]);
    result.uncertain[6] = false;
    let answer = decide(Keep::Median, &result);
    assert_eq!(answer.median, Some(4.0));
    assert_eq!(answer.kept, [false, false, false, true, true, false, true]);
    assert!(answer.undecided.is_empty());
}

/// With an odd number the median is a vessel's own L; its decision flips only when ranks change.
#[test]
fn the_vessel_that_is_the_median_is_not_undecided_for_that() {
    let answer = decide(Keep::Median, &likelihood(&[(1.0, 0.1), (3.0, 0.1), (5.0, 0.1)]));
    assert_eq!((answer.median, &answer.kept[..]), (Some(3.0), &[false, false, true][..]));
    assert!(answer.undecided.is_empty());
    // The rank of the middle one flips at 4, halfway to the next: two errors of 0.6 reach it.
    assert_eq!(decide(Keep::Median, &likelihood(&[(1.0, 0.1), (3.0, 0.6), (5.0, 0.1)])).undecided, [1]);
    assert!(decide(Keep::Median, &likelihood(&[(1.0, 0.1), (3.0, 0.4), (5.0, 0.1)])).undecided.is_empty());
    assert!(decide(Keep::Median, &likelihood(&[(2.0, 0.1)])).undecided.is_empty());
}

#[test]
fn the_other_rules() {
    let result = likelihood(&[(1.0, 0.2), (2.0, 0.2), (10.0, 0.2), (11.0, 0.2)]);
    assert_eq!(decide(Keep::Value(2.0), &result).kept, [false, false, true, true]);
    assert_eq!(decide(Keep::Value(2.1), &result).undecided, [1]);
    assert_eq!(decide(Keep::Quantile(0.0), &result).kept, [false, true, true, true]);
    assert_eq!(decide(Keep::Frequency(0.2), &result).kept, [false, true, true, true]);
    // Otsu on ln L: 0, 0.69 | 2.30, 2.40.
    assert_eq!(decide(Keep::Otsu, &result).kept, [false, false, true, true]);
    assert_eq!(decide(Keep::Median, &likelihood(&[(0.0, 0.0)])).kept, [false]);
}

/// What a message lists is in the help and can be read, and reads as it is written; a page has the law of each rule that it follows.
#[test]
fn every_rule_is_told_and_read_and_followed() {
    let said = "everything".parse::<Keep>().unwrap_err().to_string();
    let forms: Vec<&str> =
        said.split_once("expected ").unwrap().1.split([',', ' ']).filter(|form| !["", "or"].contains(form)).collect();
    assert_eq!(forms.len(), 9, "{said}");
    let laws = concat!(env!("CARGO_MANIFEST_DIR"), "/crates/report/src/page/assets/rules.js");
    let laws = std::fs::read_to_string(laws).expect("the laws of the page");
    let mut told = Keep::HELP.to_owned();
    for form in forms {
        assert!(told.contains(form), "{form}: {}", Keep::HELP);
        told = told.replacen(form, "", 1);
        let word = form.split(['[', '=']).next().unwrap();
        let rule: Keep = match word.parse() {
            Ok(rule) => rule,
            Err(why) => {
                let example = why.to_string().split_once("as in ").expect("an example").1.to_owned();
                example.parse().expect("a rule")
            }
        };
        assert!(rule.to_string().starts_with(word), "{rule}");
        assert_eq!(rule.to_string().parse::<Keep>().unwrap(), rule);
        assert_eq!(form.contains('='), rule.to_string().contains('='), "{rule}");
        if let Some(followed) = rule.followed() {
            let followed = serde_json::to_value(followed).expect("JSON");
            let law = followed.as_object().and_then(|law| law.keys().next()).expect("a law");
            assert!(laws.contains(&format!("\n  {law}: {{ keeps: ")), "{law}");
        }
    }
    for (text, wanted) in [
        (
            "median=3",
            "expected probable[=PRICE], best-first[=P], reconnect[=P], median, quantile=Q, value=X, otsu, frequency=F or probability=P",
        ),
        ("quantile==", "needs a figure, as in quantile=0.8"),
        ("value", "needs a figure, as in value=1e5"),
        ("reconnect=40%", "expected a number from 0 to 1, such as reconnect=0.4"),
        ("quantile=1.1", "expected a number from 0 to 1, such as quantile=0.011"),
        ("probable=", "expected probable[=PRICE], "),
        ("probable=50%", "expected probable[=PRICE], "),
        ("probable=2000", "keep probable 2000: expected a number from 0 to 1000"),
        ("value=inf", "expected a finite number of W/m3"),
        ("resonect", "did you mean \"reconnect\"? expected probable"),
    ] {
        let said = text.parse::<Keep>().unwrap_err().to_string();
        assert!(said.contains(wanted), "{text}: {said}");
    }
}
