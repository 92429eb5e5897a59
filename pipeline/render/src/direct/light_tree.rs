//! A tree over lights that have a place: how much of their light could reach a point, in groups.
//!
//! Conty Estevez and Kulla, *Importance Sampling of Many Lights with Adaptive Tree Splitting*, PACM
//! CGIT 1(2), 2018: a node's bound is its intensity over the squared distance, times the largest
//! cosines that its sphere and its cone of normals allow. A light that could reach a point has a
//! bound above zero, so that none is missed.

use super::emitter::Emitter;
use glam::Vec3;
use rrf_metrics::color::luminance;

/// Groups at the most.
pub(crate) const MOST_GROUPS: usize = 24;
/// Added to every bound on a cosine, for its rounding.
const SLACK: f32 = 1e-3;

/// A node of the tree.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// A sphere about all places.
    centre: Vec3,
    radius: f32,
    /// Cone of normals: axis and cosine of the half angle; -1 where light leaves every way.
    axis: Vec3,
    cosine: f32,
    /// Luminance of the intensity.
    level: f32,
    below: Below,
}

#[derive(Clone, Copy, Debug)]
enum Below {
    Emitter(u32),
    Nodes([u32; 2]),
}

/// The tree; its groups are nodes that together hold every light once.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightTree {
    nodes: Vec<Node>,
    groups: Vec<u32>,
}

impl LightTree {
    pub(crate) fn new(emitters: &[Emitter]) -> LightTree {
        let mut tree = LightTree::default();
        let mut ids: Vec<u32> = (0..emitters.len() as u32).collect();
        ids.retain(|&id| luminance(emitters[id as usize].intensity) > 0.0);
        if ids.is_empty() {
            return tree;
        }
        let root = tree.build(emitters, &mut ids);
        tree.groups = tree.cut(root);
        tree
    }

    pub(crate) fn groups(&self) -> usize {
        self.groups.len()
    }

    /// Adds the node of some lights and all below it; gives its number.
    fn build(&mut self, emitters: &[Emitter], ids: &mut [u32]) -> u32 {
        let of = |id: &u32| &emitters[*id as usize];
        let below = match ids {
            &mut [id] => Below::Emitter(id),
            _ => {
                let (low, high) = bounds(ids.iter().map(|id| of(id).middle()));
                let axis = longest(high - low);
                ids.sort_by(|a, b| {
                    let along = |id: &u32| of(id).middle()[axis];
                    along(a).total_cmp(&along(b)).then(a.cmp(b))
                });
                let (left, right) = ids.split_at_mut(ids.len() / 2);
                Below::Nodes([self.build(emitters, left), self.build(emitters, right)])
            }
        };
        let (low, high) = bounds(ids.iter().flat_map(|id| of(id).corners()));
        let centre = 0.5 * (low + high);
        let corners = ids.iter().flat_map(|id| of(id).corners());
        let radius = corners.map(|p| p.distance(centre)).fold(0.0, f32::max);
        let (axis, cosine) = cone(ids.iter().map(of));
        self.nodes.push(Node {
            centre,
            radius: radius * (1.0 + 1e-5),
            axis,
            cosine,
            level: ids.iter().map(|id| luminance(of(id).intensity)).sum(),
            below,
        });
        self.nodes.len() as u32 - 1
    }

    /// Splits the strongest and widest nodes until there are [`MOST_GROUPS`].
    fn cut(&self, root: u32) -> Vec<u32> {
        let mut groups = vec![root];
        while groups.len() < MOST_GROUPS {
            let worth = |&id: &u32| {
                let node = &self.nodes[id as usize];
                match node.below {
                    Below::Emitter(_) => -1.0,
                    Below::Nodes(_) => node.level * (node.radius + f32::MIN_POSITIVE),
                }
            };
            let best = groups.iter().enumerate().max_by(|a, b| {
                let (x, y) = (worth(a.1), worth(b.1));
                x.total_cmp(&y).then(b.0.cmp(&a.0))
            });
            let Some(place) = best.map(|(place, _)| place) else {
                break;
            };
            let Below::Nodes([left, right]) = self.nodes[groups[place] as usize].below else {
                break;
            };
            groups[place] = left;
            groups.push(right);
        }
        groups
    }

    /// Bound on the light of a group at `x` for a surface with unit normal `n` there, up to a common
    /// factor; its middle.
    pub(crate) fn reach(&self, group: usize, x: Vec3, n: Vec3) -> (f32, Vec3) {
        let node = &self.nodes[self.groups[group] as usize];
        (node.reach(x, n), node.centre)
    }

    /// A light of a group by a number in [0, 1), and its probability in the group; `None` where
    /// the whole group cannot reach `x`. Keeps its way down for numbers of the same point that follow.
    pub(crate) fn choose(
        &self,
        group: usize,
        (x, n): (Vec3, Vec3),
        u: f32,
        descent: &mut Descent,
    ) -> Option<(u32, f32)> {
        let root = *self.groups.get(group)?;
        let way = &mut descent.way;
        if way.first().is_none_or(|step| step.node != root) {
            way.clear();
            way.push(Step {
                node: root,
                from: 0.0,
                probability: 1.0,
            });
        }
        while way.len() > 1 && way.last().is_some_and(|step| !step.holds(u)) {
            way.pop();
        }
        loop {
            let step = *way.last()?;
            let [left, right] = match self.nodes[step.node as usize].below {
                Below::Emitter(id) => return Some((id, step.probability)),
                Below::Nodes(nodes) => nodes,
            };
            let [a, b] = [left, right].map(|node| self.nodes[node as usize].reach(x, n));
            let sum = a + b;
            if sum.is_nan() || sum <= 0.0 {
                return None;
            }
            let before = step.probability * (a / sum);
            let goes_left = b == 0.0 || a > 0.0 && u < step.from + before;
            way.push(match goes_left {
                true => Step {
                    node: left,
                    probability: before,
                    ..step
                },
                false => Step {
                    node: right,
                    from: step.from + before,
                    probability: step.probability * (b / sum),
                },
            });
        }
    }
}

/// A way down the tree, to the light that was chosen last.
#[derive(Clone, Debug, Default)]
pub(crate) struct Descent {
    way: Vec<Step>,
}

/// A node on the way: numbers from `from` on lead there, over as much as its probability.
#[derive(Clone, Copy, Debug)]
struct Step {
    node: u32,
    from: f32,
    probability: f32,
}

impl Descent {
    /// Forgets the way: another point follows.
    pub(crate) fn clear(&mut self) {
        self.way.clear();
    }
}

impl Step {
    fn holds(&self, u: f32) -> bool {
        self.from <= u && u < self.from + self.probability
    }
}

impl Node {
    fn reach(&self, x: Vec3, n: Vec3) -> f32 {
        let to = self.centre - x;
        let (squared, radius2) = (to.length_squared(), self.radius * self.radius);
        let least = (0.25 * radius2).max(f32::MIN_POSITIVE);
        if squared <= radius2 {
            return self.level / squared.max(least);
        }
        let distance = squared.sqrt();
        // the angle that the sphere takes up: its sine and cosine
        let sine = self.radius / distance;
        let wide = [(1.0 - sine * sine).max(0.0).sqrt(), sine];
        let toward = to / distance;
        let here = less(n.dot(toward), wide);
        let there = if self.cosine <= -1.0 {
            1.0
        } else {
            let [c, s] = with_sine(self.cosine);
            let [c, s] = [c * wide[0] - s * wide[1], s * wide[0] + c * wide[1]];
            // cone and sphere together reach beyond a half turn
            if s < 0.0 || c <= -1.0 {
                1.0
            } else {
                less(-self.axis.dot(toward), [c, s])
            }
        };
        if here <= 0.0 || there <= 0.0 {
            return 0.0;
        }
        self.level * here * there / squared.max(least)
    }
}

/// A cosine and the sine beside it.
fn with_sine(cosine: f32) -> [f32; 2] {
    [cosine, (1.0 - cosine * cosine).max(0.0).sqrt()]
}

/// Cosine of an angle made smaller by another, not below 0: 1 where it is within the other.
fn less(cosine: f32, [by_cosine, by_sine]: [f32; 2]) -> f32 {
    let [c, s] = with_sine(cosine.clamp(-1.0, 1.0));
    if c >= by_cosine {
        return 1.0;
    }
    (c * by_cosine + s * by_sine + SLACK).min(1.0)
}

/// Least and greatest coordinates.
fn bounds(places: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    places.fold(start, |(low, high), p| (low.min(p), high.max(p)))
}

fn longest(size: Vec3) -> usize {
    let largest = size.max_element();
    (0..3).find(|&axis| size[axis] == largest).unwrap_or(0)
}

/// A cone that holds every normal, by its axis and the cosine of its half angle.
fn cone<'e>(emitters: impl Iterator<Item = &'e Emitter> + Clone) -> (Vec3, f32) {
    let every_way = (Vec3::Z, -1.0);
    if emitters.clone().any(|e| e.normal().is_none()) {
        return every_way;
    }
    let normals = emitters.filter_map(Emitter::normal);
    let Some(axis) = normals.clone().sum::<Vec3>().try_normalize() else {
        return every_way;
    };
    let cosine = normals.map(|n| n.dot(axis)).fold(1.0, f32::min);
    (axis, cosine - 1e-6)
}
