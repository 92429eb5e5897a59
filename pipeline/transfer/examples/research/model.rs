//! The library's model: rows, basis, cells, and what each kind of cell makes of the same rows.

use crate::clock::cpu;
use crate::setup::{Places, one_watt};
use crate::truth::Truth;
use glam::Vec3;
use rrf_trace::Tracer;
use rrf_transfer::{
    CellChoice, DirectLight, FlatMirrors, PartFit, Receivers, RowPoint, TransferCell,
    TransferConfig, TransferModel, TransferQuery, bake_transfer,
};

/// One line for each choice of cells.
pub fn run(
    tracer: &Tracer,
    places: &Places,
    truth: &Truth,
    ensemble: usize,
    config: &TransferConfig,
    choices: &[CellChoice],
) {
    let mirrors = FlatMirrors::new(tracer);
    let lights: Vec<_> = (places.lights(ensemble, 77).iter())
        .map(|&l| mirrors.of(one_watt(l)))
        .collect();
    let lights: Vec<&dyn DirectLight> = lights.iter().map(|l| l as &dyn DirectLight).collect();
    let draw = |_: u64, count: usize| -> Vec<RowPoint> { places.candidates(count, 2) };
    let own = own_light(&mirrors, truth);
    for &choice in choices {
        let start = cpu();
        let config = TransferConfig { choice, ..*config };
        let model = bake_transfer(tracer, &draw, &lights, &config, &|| false).expect("a model");
        println!("{choice:?}: {:.1} CPU s", cpu() - start);
        report(tracer, &mirrors, truth, &own, &model);
    }
}

/// Light that flat mirrors add by way of the judged points themselves, shape [points, lights].
pub fn own_light(mirrors: &FlatMirrors, truth: &Truth) -> Vec<Vec3> {
    let of = |&l: &Vec3| mirrors.at_rows(&one_watt(l), &truth.points, 0);
    let by_light: Vec<Vec<Vec3>> = truth.lights.iter().map(of).collect();
    (0..truth.points.len())
        .flat_map(|p| by_light.iter().map(move |own| own[p]))
        .collect()
}

fn report(
    tracer: &Tracer,
    mirrors: &FlatMirrors,
    truth: &Truth,
    own: &[Vec3],
    model: &TransferModel,
) {
    let receivers = model.receivers(tracer);
    let queries: Vec<TransferQuery> = (truth.points.iter())
        .map(|p| TransferQuery::of_row(tracer, p))
        .collect();
    let mut predicted = own.to_vec();
    let (mut residual, mut unknown) = (0.0, 0);
    let mut trusted = vec![None; predicted.len()];
    let count = truth.lights.len();
    for (l, &light) in truth.lights.iter().enumerate() {
        let irradiance = receivers.irradiance(&mirrors.of(one_watt(light)));
        let own_residual = model.residual(&irradiance).expect("columns");
        if std::env::var_os("WORST").is_some() {
            println!("   light {l} residual {own_residual:.3}");
        }
        residual += own_residual / count as f32;
        let light = model.coefficients(&irradiance).expect("columns");
        for (p, answer) in model.evaluate(&light, &queries).iter().enumerate() {
            predicted[p * count + l] += answer.radiance.max(Vec3::ZERO);
            unknown += usize::from(answer.cell == rrf_scene::INVALID);
            let is_trusted = answer.trusted && own_residual <= 0.1;
            trusted[p * count + l] = is_trusted.then(|| model.cells[answer.cell as usize].error);
        }
    }
    let squares = truth.squares(&predicted, &predicted);
    println!("   {}", truth.summary(&squares));
    speed(
        &receivers,
        &mirrors.of(one_watt(truth.lights[0])),
        &queries,
        model,
    );
    let mean = |of: &dyn Fn(&TransferCell) -> usize| {
        let sum: usize = model.cells.iter().map(of).sum();
        sum as f64 / model.cells.len() as f64
    };
    let nets = |cell: &TransferCell| cell.parts.iter().any(|p| matches!(p, PartFit::Net(_)));
    println!(
        "   {} patches, {} of {} columns in use, {:.0} rows",
        model.patches.len(),
        model.used.iter().filter(|&&u| u).count(),
        model.used.len(),
        mean(&|cell| cell.rows as usize) * model.cells.len() as f64,
    );
    println!(
        "   {} cells, {} by nets, {:.1} directions of {:.0} nodes; {:.2} MB, {:.2} MB of it reads",
        model.cells.len(),
        model.cells.iter().filter(|c| nets(c)).count(),
        mean(&|cell| cell.read.rank()),
        mean(&|cell| cell.read.nodes.len()),
        1e-6 * model.bytes() as f64,
        1e-6 * mean(&|cell| cell.read.bytes()) * model.cells.len() as f64,
    );
    println!(
        "   {unknown} answers without a cell, residual {:.1} %",
        100.0 * residual
    );
    let trusted = &trusted;
    let kept = |wanted: bool| (0..squares.len()).filter(move |&i| trusted[i].is_some() == wanted);
    let rms = |of: &mut dyn Iterator<Item = usize>| {
        let (sum, n) = of.fold((0.0, 0), |(sum, n), i| (sum + f64::from(squares[i]), n + 1));
        100.0 * (sum / f64::from(n.max(1))).max(0.0).sqrt()
    };
    let within = kept(true)
        .filter(|&i| trusted[i].is_some_and(|error| squares[i].max(0.0).sqrt() <= 3.0 * error));
    println!(
        "   {:.1} % trusted: their error {:.2} %, the others' {:.2} %; {:.1} % of them within three stated errors",
        100.0 * kept(true).count() as f64 / predicted.len() as f64,
        rms(&mut kept(true)),
        rms(&mut kept(false)),
        100.0 * within.count() as f64 / kept(true).count().max(1) as f64,
    );
    if std::env::var_os("WORST").is_some() {
        worst(truth, &queries, model, &predicted, &squares);
    }
}

/// What a light and a point cost.
fn speed(
    receivers: &Receivers,
    light: &dyn DirectLight,
    queries: &[TransferQuery],
    model: &TransferModel,
) {
    let many: Vec<TransferQuery> = (0..200).flat_map(|_| queries).copied().collect();
    let times = 10.0;
    let repeat = |what: &dyn Fn()| {
        what();
        let start = cpu();
        (0..10).for_each(|_| what());
        (cpu() - start) / times
    };
    let irradiance = receivers.irradiance(light);
    let known = model.coefficients(&irradiance).expect("columns");
    let rays = repeat(&|| drop(receivers.irradiance(light)));
    let coefficients = repeat(&|| drop(model.coefficients(&irradiance)));
    let points = repeat(&|| drop(model.evaluate(&known, &many)));
    println!(
        "   a light: {:.1} CPU ms by {} points, {:.1} CPU ms of coefficients; a point: {:.0} CPU ns",
        1e3 * rays,
        receivers.points(),
        1e3 * coefficients,
        1e9 * points / many.len() as f64
    );
}

/// The points that make most of the error.
fn worst(
    truth: &Truth,
    queries: &[TransferQuery],
    model: &TransferModel,
    predicted: &[Vec3],
    squares: &[f32],
) {
    let lights = truth.lights.len();
    let of = |p: usize| squares[p * lights..(p + 1) * lights].iter().sum::<f32>();
    let total: f32 = squares.iter().sum();
    let mut order: Vec<usize> = (0..queries.len()).collect();
    order.sort_by(|&a, &b| of(b).total_cmp(&of(a)));
    for &p in order.iter().take(14) {
        let mean =
            |v: &[Vec3]| v[p * lights..(p + 1) * lights].iter().sum::<Vec3>() / lights as f32;
        let query = &queries[p];
        let most = (0..lights)
            .max_by(|&a, &b| squares[p * lights + a].total_cmp(&squares[p * lights + b]));
        let l = most.expect("lights");
        println!(
            "   at light {l} {:.2}: {:.4} for {:.4}, light's mean error {:.3}",
            truth.lights[l],
            predicted[p * lights + l],
            truth.halves[0][p * lights + l],
            ((0..queries.len())
                .map(|q| squares[q * lights + l])
                .sum::<f32>()
                / queries.len() as f32)
                .sqrt(),
        );
        let cell = model.tree.find(query).map(|c| &model.cells[c as usize]);
        println!(
            "   share {:.3} at {:.2} n {:.1} {:?} colour {:.2}, cell {:?}: {:.4} for {:.4}",
            of(p) / total,
            query.position,
            query.geometric,
            query.surface,
            query.base_color,
            cell.map(|c| (c.read.rank(), c.read.nodes.len(), c.rows, c.error)),
            mean(predicted),
            mean(&truth.halves[0]),
        );
    }
}
