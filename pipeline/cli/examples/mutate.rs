//! Mutates whole files of `fuzz/seeds` and reads them, on a stock compiler: what can be had of
//! fuzzing without coverage. The targets are those of `fuzz/`; see `fuzz/run.py`.
//!
//!     cargo run --release -p rrf-cli --example mutate -- parquet 60 1
//!
//! Arguments: target, seconds of this thread's CPU, seed. A panic or a crash leaves the input
//! where the reader found it and ends the process. `-- parquet --replay FOLDER` reads the files of a folder as they are.
#![allow(clippy::expect_used, clippy::panic, missing_docs, unexpected_cfgs)]

#[path = "../../../fuzz/src/lib.rs"]
mod readers;

use rrf_sampling::{Dimensions, Stage, Stream};
use std::path::Path;
use std::time::Instant;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [target, seconds, seed] = words.as_slice() else {
        panic!("arguments: TARGET SECONDS SEED, or TARGET --replay FOLDER");
    };
    let read = reader(target);
    if seconds == "--replay" {
        return replay(target, read, Path::new(seed));
    }
    let (seconds, seed): (f64, u64) = (
        seconds.parse().expect("SECONDS"),
        seed.parse().expect("SEED"),
    );
    let seeds = seeds(target);
    let (mut inputs, mut slowest) = (0u64, 0.0f64);
    while cpu_seconds() < seconds {
        let mut dice = Stream::new(seed, Stage::Test, 0).dimensions(inputs);
        let bytes = mutated(&seeds, &mut dice);
        let start = Instant::now();
        read(&bytes);
        slowest = slowest.max(start.elapsed().as_secs_f64());
        inputs += 1;
    }
    readers::clean();
    println!(
        "{target}: {inputs} inputs, {:.0} s CPU, slowest {slowest:.3} s, at most {} MiB resident",
        cpu_seconds(),
        peak_mib()
    );
}

/// Reads bytes as a user's file is read; whatever it returns is fine, a panic is not.
type Reader = fn(&[u8]);

fn reader(target: &str) -> Reader {
    match target {
        "pbrt" => readers::pbrt,
        "gltf" => readers::gltf,
        "obj" => readers::obj,
        "exr" => readers::exr,
        "parquet" => readers::parquet,
        "arrow" => readers::arrow,
        "small" => readers::small,
        other => panic!("no target {other}"),
    }
}

/// Reads every file of a folder; none may take 5 s.
fn replay(target: &str, read: Reader, folder: &Path) {
    let (inputs, mut slowest) = (files(folder), 0.0f64);
    for bytes in &inputs {
        let before = cpu_seconds();
        read(bytes);
        slowest = slowest.max(cpu_seconds() - before);
    }
    readers::clean();
    println!(
        "{target}: {} inputs, slowest {slowest:.3} s, at most {} MiB resident",
        inputs.len(),
        peak_mib()
    );
    assert!(slowest < 5.0, "an input takes {slowest} s");
}

fn seeds(target: &str) -> Vec<Vec<u8>> {
    files(&Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds")).join(target))
}

fn files(folder: &Path) -> Vec<Vec<u8>> {
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .expect("seeds")
        .map(|entry| entry.expect("a seed").path())
        .collect();
    paths.sort();
    paths
        .iter()
        .map(|path| std::fs::read(path).expect("a seed"))
        .collect()
}

/// Numbers at which lengths and offsets go wrong.
const EDGES: [u32; 8] = [0, 1, 0x7f, 0xff, 0xffff, 0x7fff_ffff, 0x8000_0000, u32::MAX];

/// A seed with 1 to 8 wounds.
fn mutated(seeds: &[Vec<u8>], dice: &mut Dimensions) -> Vec<u8> {
    let mut below = |n: usize| dice.next_u32() as usize % n.max(1);
    let mut bytes = seeds[below(seeds.len())].clone();
    for _ in 0..1 + below(8) {
        let (at, n) = (below(bytes.len()), bytes.len());
        let end = n.min(at + 1 + below(64));
        match below(7) {
            _ if n == 0 => bytes.push(below(256) as u8),
            0 => bytes[at] ^= 1 << below(8),
            1 => bytes[at] = below(256) as u8,
            2 => {
                let edge = EDGES[below(EDGES.len())].to_le_bytes();
                bytes[at..n.min(at + 4)].copy_from_slice(&edge[..4.min(n - at)]);
            }
            3 => drop(bytes.drain(at..end)),
            4 => {
                let piece = bytes[at..end].to_vec();
                let to = below(n);
                bytes.splice(to..to, piece);
            }
            5 => {
                let other = &seeds[below(seeds.len())];
                let from = below(other.len());
                let piece = &other[from..other.len().min(from + 1 + below(256))];
                let over = n.min(at + piece.len());
                bytes.splice(at..over, piece.iter().copied());
            }
            _ => bytes.truncate(at.max(n - n / 8)),
        }
    }
    bytes
}

/// CPU time of this thread.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    let nanoseconds = text.split(' ').next().and_then(|x| x.parse::<f64>().ok());
    nanoseconds.expect("schedstat") * 1e-9
}

fn peak_mib() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().split(' ').next()?.parse::<u64>().ok());
    kib.expect("VmHWM") >> 10
}
