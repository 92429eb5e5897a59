//! Scenes in code, for tests and measurements.

use glam::{Vec2, Vec3};
use rrf_scene::{AreaLight, INVALID, Material, Scene};

/// A scene under construction.
#[derive(Default)]
pub struct Builder {
    pub scene: Scene,
}

pub fn lambert(base_color: Vec3) -> Material {
    Material::lambert("lambert", base_color)
}

pub fn principled(base_color: Vec3, roughness: f32, metallic: f32, specular: f32) -> Material {
    Material::principled("principled", base_color, roughness, metallic, specular)
}

impl Builder {
    pub fn material(&mut self, material: Material) -> u32 {
        self.scene.materials.push(material);
        self.scene.materials.len() as u32 - 1
    }

    pub fn light(&mut self, radiance: Vec3, two_sided: bool) -> u32 {
        self.scene.area_lights.push(AreaLight {
            radiance,
            two_sided,
        });
        let id = self.scene.area_lights.len() as u32 - 1;
        self.scene.area_light_names.push(format!("lamp{id}"));
        id
    }

    /// One object of triangles with geometric normals.
    pub fn mesh(&mut self, positions: &[Vec3], triangles: &[[u32; 3]], material: u32, light: u32) {
        let zeros = vec![Vec3::ZERO; positions.len()];
        self.smooth_mesh(positions, &zeros, triangles, material, light);
    }

    /// One object of triangles with normals a vertex.
    pub fn smooth_mesh(
        &mut self,
        positions: &[Vec3],
        normals: &[Vec3],
        triangles: &[[u32; 3]],
        material: u32,
        light: u32,
    ) {
        let scene = &mut self.scene;
        let first = scene.positions.len() as u32;
        let object = scene.objects.len() as u32;
        scene.objects.push(format!("object {object}"));
        scene.positions.extend_from_slice(positions);
        scene.normals.extend_from_slice(normals);
        scene.uvs.extend(positions.iter().map(|_| Vec2::ZERO));
        for triangle in triangles {
            scene.triangles.push(triangle.map(|v| v + first));
            scene.triangle_material.push(material);
            scene.triangle_light.push(light);
            scene.triangle_object.push(object);
        }
    }

    /// A parallelogram; its normal is `a` x `b`.
    pub fn quad(&mut self, corner: Vec3, a: Vec3, b: Vec3, material: u32, light: u32) {
        self.mesh(
            &[corner, corner + a, corner + a + b, corner + b],
            &[[0, 1, 2], [0, 2, 3]],
            material,
            light,
        );
    }

    /// An axis-aligned box as one object, normals outward, or inward when `inward`.
    pub fn cuboid(&mut self, min: Vec3, max: Vec3, inward: bool, material: u32, light: u32) {
        let corner = |i: u32| {
            let pick = |bit: u32, low: f32, high: f32| if i >> bit & 1 == 1 { high } else { low };
            Vec3::new(
                pick(0, min.x, max.x),
                pick(1, min.y, max.y),
                pick(2, min.z, max.z),
            )
        };
        let positions: Vec<Vec3> = (0..8).map(corner).collect();
        let faces: [[u32; 4]; 6] = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let triangles: Vec<[u32; 3]> = faces
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .map(|[a, b, c]| if inward { [a, c, b] } else { [a, b, c] })
            .collect();
        self.mesh(&positions, &triangles, material, light);
    }

    /// A sphere of 2 `n`^2 triangles or so with outward smooth normals.
    pub fn sphere(&mut self, centre: Vec3, radius: f32, n: u32, material: u32, light: u32) {
        let (mut normals, mut triangles) = (Vec::new(), Vec::new());
        for i in 0..=n {
            for j in 0..=2 * n {
                let theta = std::f32::consts::PI * i as f32 / n as f32;
                let phi = std::f32::consts::PI * (j % (2 * n)) as f32 / n as f32;
                let r = if i == 0 || i == n { 0.0 } else { theta.sin() };
                normals.push(Vec3::new(r * phi.cos(), r * phi.sin(), theta.cos()));
            }
        }
        let row = 2 * n + 1;
        for i in 0..n {
            for j in 0..2 * n {
                let (a, b) = (i * row + j, (i + 1) * row + j);
                if i > 0 {
                    triangles.push([a, b, a + 1]);
                }
                if i + 1 < n {
                    triangles.push([b, b + 1, a + 1]);
                }
            }
        }
        let positions: Vec<Vec3> = normals.iter().map(|n| centre + *n * radius).collect();
        self.smooth_mesh(&positions, &normals, &triangles, material, light);
    }
}

/// Bitterli's Cornell box (CC0), without its area light, vertex by vertex as in the pbrt file:
/// the normals of three walls point out of the room, the boxes end 3e-8 from the floor.
pub fn cornell() -> Scene {
    let mut builder = Builder::default();
    let white = builder.material(lambert(Vec3::new(0.725, 0.71, 0.68)));
    let red = builder.material(lambert(Vec3::new(0.63, 0.065, 0.05)));
    let green = builder.material(lambert(Vec3::new(0.14, 0.45, 0.091)));
    let quad: &[[u32; 3]] = &[[0, 1, 2], [0, 2, 3]];
    builder.cornell_part(
        &[
            [-1.0, 1.74846e-07, -1.0],
            [-1.0, 1.74846e-07, 1.0],
            [1.0, -1.74846e-07, 1.0],
            [1.0, -1.74846e-07, -1.0],
        ],
        quad,
        white,
    );
    builder.cornell_part(
        &[
            [1.0, 2.0, 1.0],
            [-1.0, 2.0, 1.0],
            [-1.0, 2.0, -1.0],
            [1.0, 2.0, -1.0],
        ],
        quad,
        white,
    );
    builder.cornell_part(
        &[
            [-1.0, 0.0, -1.0],
            [-1.0, 2.0, -1.0],
            [1.0, 2.0, -1.0],
            [1.0, 0.0, -1.0],
        ],
        quad,
        white,
    );
    builder.cornell_part(
        &[
            [1.0, 0.0, -1.0],
            [1.0, 2.0, -1.0],
            [1.0, 2.0, 1.0],
            [1.0, 0.0, 1.0],
        ],
        quad,
        green,
    );
    builder.cornell_part(
        &[
            [-1.0, 0.0, 1.0],
            [-1.0, 2.0, 1.0],
            [-1.0, 2.0, -1.0],
            [-1.0, 0.0, -1.0],
        ],
        quad,
        red,
    );
    builder.cornell_part(
        &[
            [-0.0460751, 0.6, 0.573007],
            [-0.0460751, -2.98023e-08, 0.573007],
            [0.124253, 0.0, 0.00310463],
            [0.124253, 0.6, 0.00310463],
            [0.533009, 0.0, 0.746079],
            [0.533009, 0.6, 0.746079],
            [0.703337, 0.6, 0.176177],
            [0.703337, 2.98023e-08, 0.176177],
            [0.533009, 0.6, 0.746079],
            [-0.0460751, 0.6, 0.573007],
            [0.124253, 0.6, 0.00310463],
            [0.703337, 0.6, 0.176177],
            [0.703337, 2.98023e-08, 0.176177],
            [0.124253, 0.0, 0.00310463],
            [-0.0460751, -2.98023e-08, 0.573007],
            [0.533009, 0.0, 0.746079],
            [0.533009, 0.0, 0.746079],
            [-0.0460751, -2.98023e-08, 0.573007],
            [-0.0460751, 0.6, 0.573007],
            [0.533009, 0.6, 0.746079],
            [0.703337, 0.6, 0.176177],
            [0.124253, 0.6, 0.00310463],
            [0.124253, 0.0, 0.00310463],
            [0.703337, 2.98023e-08, 0.176177],
        ],
        &[
            [0, 2, 1],
            [0, 3, 2],
            [4, 6, 5],
            [4, 7, 6],
            [8, 10, 9],
            [8, 11, 10],
            [12, 14, 13],
            [12, 15, 14],
            [16, 18, 17],
            [16, 19, 18],
            [20, 22, 21],
            [20, 23, 22],
        ],
        white,
    );
    builder.cornell_part(
        &[
            [-0.720444, 1.2, -0.473882],
            [-0.720444, 0.0, -0.473882],
            [-0.146892, 0.0, -0.673479],
            [-0.146892, 1.2, -0.673479],
            [-0.523986, 0.0, 0.0906493],
            [-0.523986, 1.2, 0.0906492],
            [0.0495656, 1.2, -0.108948],
            [0.0495656, 0.0, -0.108948],
            [-0.523986, 1.2, 0.0906492],
            [-0.720444, 1.2, -0.473882],
            [-0.146892, 1.2, -0.673479],
            [0.0495656, 1.2, -0.108948],
            [0.0495656, 0.0, -0.108948],
            [-0.146892, 0.0, -0.673479],
            [-0.720444, 0.0, -0.473882],
            [-0.523986, 0.0, 0.0906493],
            [-0.523986, 0.0, 0.0906493],
            [-0.720444, 0.0, -0.473882],
            [-0.720444, 1.2, -0.473882],
            [-0.523986, 1.2, 0.0906492],
            [0.0495656, 1.2, -0.108948],
            [-0.146892, 1.2, -0.673479],
            [-0.146892, 0.0, -0.673479],
            [0.0495656, 0.0, -0.108948],
        ],
        &[
            [0, 2, 1],
            [0, 3, 2],
            [4, 6, 5],
            [4, 7, 6],
            [8, 10, 9],
            [8, 11, 10],
            [12, 14, 13],
            [12, 15, 14],
            [16, 18, 17],
            [16, 19, 18],
            [20, 22, 21],
            [20, 23, 22],
        ],
        white,
    );
    builder.scene
}

impl Builder {
    fn cornell_part(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]], material: u32) {
        let positions: Vec<Vec3> = positions.iter().map(|&p| p.into()).collect();
        self.mesh(&positions, triangles, material, INVALID);
    }
}
