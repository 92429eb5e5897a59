//! Measurements of a batch for monitoring, in the text form of OpenMetrics, which node_exporter's
//! textfile collector and Prometheus read.

use super::outcome::Outcome;
use std::fmt::Write;

/// A measurement: its name, what it is, and its value for a run.
type Gauge = (&'static str, &'static str, fn(&Outcome) -> Option<f64>);

const GAUGES: [Gauge; 11] = [
    (
        "rrf_run_exit_code",
        "0 done, 1 failed, 2 bad input, 3 target missed.",
        |run| Some(f64::from(run.code)),
    ),
    (
        "rrf_run_relative_error",
        "Relative error of the model.",
        |run| run.relative_error,
    ),
    (
        "rrf_run_relative_error_se",
        "Standard error of the relative error.",
        |run| run.relative_error_se,
    ),
    ("rrf_run_target", "Relative error to reach.", |run| {
        run.target.map(f64::from)
    }),
    (
        "rrf_run_target_met",
        "1 where the target is met, 0 where it is missed.",
        |run| run.target_met.map(|met| f64::from(u8::from(met))),
    ),
    ("rrf_run_seconds", "Wall time of the last command.", |run| {
        Some(run.seconds)
    }),
    (
        "rrf_run_work_seconds",
        "Wall time of all stages so far.",
        |run| run.work_seconds,
    ),
    ("rrf_run_rounds", "Rounds that are done.", |run| {
        run.rounds.map(f64::from)
    }),
    ("rrf_run_cells", "Cells of the model.", |run| {
        run.cells.map(|cells| cells as f64)
    }),
    ("rrf_run_bytes", "Bytes of the run's files.", |run| {
        run.bytes.map(|bytes| bytes as f64)
    }),
    (
        "rrf_run_model_bytes",
        "Bytes of the model's files.",
        |run| run.model_bytes.map(|bytes| bytes as f64),
    ),
];

/// The text of all measurements; `now` in seconds since 1970, `code` the exit code.
pub fn text(outcomes: &[Outcome], now: u64, code: u8) -> String {
    let mut text = String::new();
    let mut family = |name: &str, what: &str, values: &[(Option<&Outcome>, f64)]| {
        let _ = writeln!(text, "# HELP {name} {what}");
        let _ = writeln!(text, "# TYPE {name} gauge");
        for (run, value) in values {
            let _ = match run {
                Some(run) => writeln!(text, "{name}{{{}}} {value}", labels(run)),
                None => writeln!(text, "{name} {value}"),
            };
        }
    };
    for (name, what, value) in GAUGES {
        let values = outcomes
            .iter()
            .filter_map(|run| Some((Some(run), value(run)?)));
        family(name, what, &values.collect::<Vec<_>>());
    }
    let code = [(None, f64::from(code))];
    family("rrf_batch_exit_code", "Exit code of the batch.", &code);
    let end = [(None, now as f64)];
    family(
        "rrf_batch_end_timestamp_seconds",
        "When the batch ended.",
        &end,
    );
    text.push_str("# EOF\n");
    text
}

fn labels(run: &Outcome) -> String {
    let name = run.run.file_name().unwrap_or_default().to_string_lossy();
    let scene = run.scene.to_string_lossy();
    let version = env!("CARGO_PKG_VERSION");
    let [name, scene] = [name, scene].map(|text| escaped(&text));
    format!("run=\"{name}\",scene=\"{scene}\",version=\"{version}\"")
}

fn escaped(text: &str) -> String {
    let text = text.replace('\\', "\\\\").replace('"', "\\\"");
    text.replace('\n', "\\n")
}

#[cfg(test)]
mod tests {
    use super::super::outcome::State;
    use super::*;

    #[test]
    fn a_family_has_its_type_and_a_line_a_run() {
        let state = (2, State::BadInput);
        let broken =
            Outcome::without_work("out/a-1".into(), "we\"ird.obj".into(), state, String::new());
        let done = Outcome {
            relative_error: Some(0.25),
            ..broken.clone()
        };
        let text = text(&[done, broken], 7, 2);
        assert!(text.contains("# TYPE rrf_run_relative_error gauge\nrrf_run_relative_error{run=\"a-1\",scene=\"we\\\"ird.obj\""));
        assert_eq!(text.matches("\nrrf_run_relative_error{").count(), 1);
        assert_eq!(text.matches("\nrrf_run_exit_code{").count(), 2);
        assert!(text.contains("\nrrf_batch_exit_code 2\n"));
        assert!(text.ends_with("\nrrf_batch_end_timestamp_seconds 7\n# EOF\n"));
    }
}
