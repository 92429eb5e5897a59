//! The light conditions of an ensemble.

use crate::scenes::{cornell, room};
use glam::Vec3;
use rrf_lights::LightSource;
use rrf_sampling::{Stage, Stream};
use rrf_trace::Tracer;
use rrf_transfer::{ConditionPlan, LightConditions};

const BOX: [Vec3; 2] = [Vec3::new(-0.9, 0.1, -0.9), Vec3::new(0.9, 1.9, 0.9)];

/// Points where they may be, clear of the surface; suns only through the open front.
#[test]
fn conditions_of_an_open_box() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let plan = ConditionPlan {
        clearance: 0.1,
        ..ConditionPlan::within(BOX)
    };
    let left = |place: Vec3| place.x < 0.0;
    let stream = Stream::new(3, Stage::Test, 0);
    let conditions = LightConditions::new(&tracer, &left, &plan, stream);
    let (mut points, mut suns) = (0, 0);
    for source in conditions.sources.iter().flatten() {
        match source {
            LightSource::Point(point) => {
                points += 1;
                assert!(left(point.position));
                assert_eq!(tracer.distance(point.position, 0.1), None);
            }
            LightSource::Distant(sun) => {
                suns += 1;
                assert!(sun.toward.z > 0.0, "{}", sun.toward);
            }
            other => panic!("{}", other.kind()),
        }
    }
    assert_eq!(points, plan.points);
    assert_eq!(
        conditions.sources.len(),
        plan.points + plan.suns + plan.skies
    );
    assert!(suns > plan.suns + plan.skies);
    assert!(conditions.sky_seen > 0.2 && conditions.sky_seen < 0.5);
    assert_eq!(conditions.lights(stream).len(), conditions.sources.len());
    let again = LightConditions::new(&tracer, &left, &plan, stream);
    assert_eq!(again.sources, conditions.sources);
}

/// No sky in a closed room, and no light where none may be.
#[test]
fn conditions_of_a_closed_room() {
    let scene = room(BOX[0], BOX[1], Vec3::ONE);
    let tracer = Tracer::new(&scene).unwrap();
    let stream = Stream::new(3, Stage::Test, 0);
    let plan = ConditionPlan::within(BOX);
    let closed = LightConditions::new(&tracer, &|_| true, &plan, stream);
    assert_eq!((closed.sources.len(), closed.sky_seen), (plan.points, 0.0));
    let none = LightConditions::new(&tracer, &|_| false, &plan, stream);
    assert!(none.sources.is_empty());
}
