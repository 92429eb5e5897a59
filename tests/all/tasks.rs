//! `rrf plan`, `rrf task`, `rrf commit`: a bake by others.

use crate::program::{Place, bytes_below, cornell, done, refused, rrf, says};

const SETTINGS: [&str; 14] = [
    "--method",
    "nets",
    "--light-box",
    "-0.6,1.3,-0.6,0.6,1.8,0.6",
    "--rows",
    "8000",
    "--cells",
    "4",
    "--paths",
    "4",
    "--rounds",
    "2",
    "--most-cells",
    "6",
];

fn missing(run: &str) -> Vec<String> {
    let said = done(&["plan", run, "--missing"]);
    said.out.lines().map(String::from).collect()
}

/// Tasks backwards, each twice, the ones that wait tried early: the bytes of a bake.
#[test]
fn in_any_order() {
    let place = Place::new();
    let (scene, run, whole) = (cornell(), place.name("run"), place.name("whole"));
    done(&[&["plan", &scene, "-o", &run], &SETTINGS[..]].concat());
    for round in 0..2 {
        let plan = place.name(&format!("run/rounds/{round:03}/tasks.parquet"));
        let unfinished = rrf(&["commit", &run]);
        assert_eq!(unfinished.code, Some(1), "{unfinished:#?}");
        let mut waits = 0;
        for pass in 0..3 {
            for id in missing(&run).iter().rev() {
                let task = ["task", "--plan", &plan, "--index", id];
                let said = rrf(&task);
                if said.code == Some(1) {
                    says(&said, &["waits for an extraction"]);
                    waits += 1;
                    continue;
                }
                assert_eq!(said.code, Some(0), "{said:#?}");
                assert!(done(&task).out.contains("done already"));
            }
            assert!(pass < 2 || missing(&run).is_empty());
        }
        assert!(
            waits > 0,
            "no training task was tried before its extraction"
        );
        done(&["commit", &run]);
    }
    assert!(done(&["plan", &run]).out.contains("ended"));
    done(&[&["bake", &scene, "-o", &whole], &SETTINGS[..]].concat());
    assert!(bytes_below(&place.path("run")) == bytes_below(&place.path("whole")));
}

#[test]
fn wrong_calls() {
    let place = Place::new();
    let (scene, run) = (cornell(), place.name("run"));
    done(&[&["plan", &scene, "-o", &run], &SETTINGS[..]].concat());
    let plan = place.name("run/rounds/000/tasks.parquet");
    refused(
        &["task", "--plan", &plan, "--index", "99"],
        &["task 99", "0 to"],
    );
    refused(
        &["task", "--plan", &scene, "--index", "0"],
        &["no plan of a run"],
    );
    refused(
        &["task", "--plan", &plan],
        &["--index", "SLURM_ARRAY_TASK_ID"],
    );
    refused(&["plan", &scene], &["not a run folder"]);
    let chapter = place.path("run/rounds/000/tasks/00000.json");
    let hashed = std::fs::read_to_string(&chapter).unwrap();
    let first = ["task", "--plan", &plan, "--index", "0"];
    std::fs::write(&chapter, "nothing").unwrap();
    refused(&first, &["00000.json"]);
    std::fs::remove_file(&chapter).unwrap();
    refused(&first, &["task 0", "missing", "rrf plan"]);
    // a changed digit, which its hash shows
    std::fs::write(&chapter, hashed.replacen("\"seed\":1", "\"seed\":2", 1)).unwrap();
    refused(&first, &["00000.json", "hash"]);
    // without a hash: another run's, other rows than were planned, and one that begins elsewhere
    let (content, _) = hashed.split_once(",\"blake3\"").unwrap();
    let whole = format!("{content}}}\n");
    let change = |from: &str, to: &str| {
        assert!(whole.contains(from), "{from} is not in {whole}");
        std::fs::write(&chapter, whole.replacen(from, to, 1)).unwrap();
    };
    change("\"seed\":1", "\"seed\":2");
    refused(
        &first,
        &["task 0", "does not belong to this run", "rrf plan"],
    );
    change("\"paths\":", "\"paths\":1");
    refused(
        &first,
        &["task 0", "does not belong to this run", "rrf plan"],
    );
    change("\"first\":0", "\"first\":1");
    refused(&first, &["task 0", "does not contain it", "rrf plan"]);
    done(&["plan", &run]);
    done(&first);
}
