//! Why a scene cannot be traced.

/// A scene that no ray can be sent into, with the fact and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TraceError {
    /// There is nothing to hit.
    #[error("the scene has no triangle with an area: there is nothing to light")]
    NoTriangles,
    /// Columns that should be parallel differ in length.
    #[error(
        "scene column `{column}` has {found} rows, `{reference}` has {expected}: they must agree"
    )]
    Length {
        /// The column that disagrees.
        column: &'static str,
        /// Its length.
        found: usize,
        /// The column that it must be parallel to.
        reference: &'static str,
        /// The length of that one.
        expected: usize,
    },
    /// An id that points outside its table.
    #[error("triangle {triangle}: {column} id {id} is out of range (the scene has {count})")]
    Id {
        /// The triangle.
        triangle: usize,
        /// Which id: vertex, material or area light.
        column: &'static str,
        /// Its value.
        id: u32,
        /// How many rows its table has.
        count: usize,
    },
    /// A texture id that points outside the texture table.
    #[error("material `{material}`: texture id {id} is out of range (the scene has {count})")]
    TextureId {
        /// The material's name.
        material: String,
        /// The id.
        id: u32,
        /// How many textures there are.
        count: usize,
    },
    /// A coordinate that is not a number or infinite.
    #[error("vertex {vertex} has a coordinate that is not finite: repair the mesh")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// More triangles than a 32-bit id can name.
    #[error("{count} triangles: at most {limit} can be traced")]
    TooMany {
        /// How many the scene has.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// Query columns that should be parallel differ in length.
    #[error(
        "query column `{column}` has {found} rows, `{reference}` has {expected}: they must agree"
    )]
    Queries {
        /// The column that disagrees.
        column: &'static str,
        /// Its length.
        found: usize,
        /// The column that it must be parallel to.
        reference: &'static str,
        /// The length of that one.
        expected: usize,
    },
    /// Its user told the tracer to give up ([`crate::Tracer::until`]).
    #[error("stopped on request")]
    Halted,
    /// A path count that cannot be split evenly.
    #[error(
        "{paths} paths cannot be split into {replicates} equal independent parts: ask for a multiple of {replicates}, at least one each"
    )]
    Paths {
        /// Paths asked for.
        paths: u32,
        /// Independent parts asked for.
        replicates: u32,
    },
}

impl TraceError {
    /// Whether the same call fails until the input changes (exit code 2).
    pub fn is_bad_input(&self) -> bool {
        !matches!(self, TraceError::Halted)
    }
}
