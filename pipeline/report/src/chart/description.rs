//! Description of a chart, for everything that draws it.

/// A panel of a chart: series over two axes.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Drawn in this order, the last on top.
    pub series: Vec<Series>,
}

/// An axis of a panel.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Quantity and unit.
    pub title: &'static str,
    /// Logarithmic, for values above zero only; otherwise linear from zero.
    pub is_log: bool,
}

/// Points of one kind and what joins them.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend; series of one name have one entry, those without a name none.
    pub name: Option<String>,
    /// Number of the colour; grey where there is none.
    pub color: Option<usize>,
    /// Line through the points.
    pub line: Line,
    /// The points, in the line's order.
    pub points: Vec<Point>,
}

/// Line through the points of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// Nothing.
    None,
    /// A solid line.
    Solid,
    /// A thin and pale one, for many series.
    Pale,
    /// A dashed line.
    Dashed,
}

/// A point of a series.
#[derive(Clone, Debug, Default)]
pub struct Point {
    /// Horizontal place.
    pub x: f64,
    /// Vertical place.
    pub y: f64,
    /// Standard error of `y`; 0 for no bar.
    pub se: f64,
    /// Radius of the mark \[pixels\]; 0 for none.
    pub radius: u32,
    /// Shown where the mark is pointed at.
    pub text: String,
}

impl Axis {
    /// A logarithmic axis.
    pub const fn log(title: &'static str) -> Axis {
        let is_log = true;
        Axis { title, is_log }
    }

    /// A linear axis.
    pub const fn linear(title: &'static str) -> Axis {
        let is_log = false;
        Axis { title, is_log }
    }
}

impl Series {
    /// A line without marks.
    pub fn line(
        name: Option<&str>,
        color: Option<usize>,
        line: Line,
        places: impl IntoIterator<Item = (f64, f64)>,
    ) -> Series {
        let point = |(x, y)| Point {
            x,
            y,
            ..Point::default()
        };
        Series {
            name: name.map(str::to_string),
            color,
            line,
            points: places.into_iter().map(point).collect(),
        }
    }

    /// Whether its points have marks.
    pub fn has_marks(&self) -> bool {
        self.points.iter().any(|p| p.radius > 0)
    }
}

impl Point {
    /// Ends of the bar of one standard error; what would fall to zero or below has no place on a
    /// logarithmic axis and is cut at half.
    pub fn bar(&self) -> [f64; 2] {
        [(self.y - self.se).max(0.5 * self.y), self.y + self.se]
    }
}

/// Colour of a number, told apart by the colour-blind too (Okabe and Ito 2008); grey for none.
pub fn rgb(color: Option<usize>) -> (u8, u8, u8) {
    const COLORS: [(u8, u8, u8); 8] = [
        (0, 114, 178),
        (213, 94, 0),
        (0, 158, 115),
        (204, 121, 167),
        (230, 159, 0),
        (86, 180, 233),
        (90, 90, 90),
        (160, 140, 0),
    ];
    color.map_or((120, 120, 120), |n| COLORS[n % COLORS.len()])
}
