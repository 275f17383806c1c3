//! The direction between strokes, by radial basis functions.
//!
//! v(p) = Σ w_i φ(|p − p_i|) with φ(r) = 1 / sqrt(1 + (r/s)²), so that v is the stroke's direction at each of its places p_i. φ is positive
//! definite: the equations have one solution. A little is added to their diagonal, so that strokes that cross are not taken to extremes.

use super::Stroke;

/// Places of all strokes together: 256³/3 steps solve for them.
const MOST: usize = 256;

/// From a place on a stroke to the next, in pixels: half the stride of patches.
const STEP: f32 = 12.0;

/// s, as a share of the picture's diagonal: a stroke reaches about a quarter of the picture before it has lost half of its say.
const REACH: f32 = 0.15;

/// What is added to the diagonal: neighbouring places may differ by about this share.
const RELAXED: f64 = 0.01;

/// Shorter sums of unit vectors than this are of strokes that cancel: there is no direction.
const CANCELLED: f32 = 1e-3;

/// A direction everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionField {
    places: Vec<[f32; 2]>,
    weights: Vec<[f32; 2]>,
    /// 1/s².
    sharpness: f32,
}

impl DirectionField {
    /// The field of strokes over a picture of this size. Strokes have at least two different points.
    pub fn new(strokes: &[Stroke], (width, height): (usize, usize)) -> Self {
        let total: f32 = strokes.iter().map(length).sum();
        // Each stroke has one place more than it has steps.
        let room = MOST.saturating_sub(strokes.len()).max(1);
        let step = STEP.max(total / room as f32);
        let (mut places, mut tangents) = (Vec::new(), Vec::new());
        for stroke in strokes {
            walk(stroke, step, |place, tangent| {
                if places.len() < MOST {
                    places.push(place);
                    tangents.push(tangent);
                }
            });
        }
        let reach = REACH * (width as f32).hypot(height as f32);
        let sharpness = 1.0 / (reach * reach);
        let mut matrix: Vec<Vec<f64>> = places
            .iter()
            .map(|a| places.iter().map(|b| f64::from(basis(a, b, sharpness))).collect())
            .collect();
        for (index, row) in matrix.iter_mut().enumerate() {
            row[index] += RELAXED;
        }
        Self { weights: solve(matrix, &tangents), places, sharpness }
    }

    /// The direction at a place, of length 1.
    pub fn at(&self, x: f32, y: f32) -> Option<[f32; 2]> {
        let mut sum = [0.0; 2];
        for (place, weight) in self.places.iter().zip(&self.weights) {
            let basis = basis(place, &[x, y], self.sharpness);
            sum[0] += weight[0] * basis;
            sum[1] += weight[1] * basis;
        }
        let length = sum[0].hypot(sum[1]);
        (length > CANCELLED).then(|| [sum[0] / length, sum[1] / length])
    }
}

fn basis(a: &[f32; 2], b: &[f32; 2], sharpness: f32) -> f32 {
    let square = (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    (1.0 + square * sharpness).sqrt().recip()
}

fn length(stroke: &Stroke) -> f32 {
    stroke.windows(2).map(|ends| (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1])).sum()
}

/// Names places along a stroke, `step` apart, and the direction there.
fn walk(stroke: &Stroke, step: f32, mut name: impl FnMut([f32; 2], [f32; 2])) {
    // How far it still is to the next place.
    let mut left = 0.0;
    for ends in stroke.windows(2) {
        let way = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
        let piece = way[0].hypot(way[1]);
        if piece == 0.0 {
            continue;
        }
        let tangent = [way[0] / piece, way[1] / piece];
        while left <= piece {
            name([ends[0][0] + tangent[0] * left, ends[0][1] + tangent[1] * left], tangent);
            left += step;
        }
        left -= piece;
    }
}

/// Solves a symmetric, positive definite system by Cholesky's method, for both coordinates.
fn solve(mut matrix: Vec<Vec<f64>>, right: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let size = matrix.len();
    for row in 0..size {
        for column in 0..=row {
            let done: f64 = (0..column).map(|k| matrix[row][k] * matrix[column][k]).sum();
            let rest = matrix[row][column] - done;
            matrix[row][column] = if row == column { rest.sqrt() } else { rest / matrix[column][column] };
        }
    }
    let mut solution: Vec<[f64; 2]> = right.iter().map(|value| value.map(f64::from)).collect();
    for row in 0..size {
        for (column, &factor) in matrix[row][..row].iter().enumerate() {
            take(&mut solution, row, column, factor);
        }
        solution[row] = solution[row].map(|value| value / matrix[row][row]);
    }
    for row in (0..size).rev() {
        for (column, line) in matrix.iter().enumerate().skip(row + 1) {
            take(&mut solution, row, column, line[row]);
        }
        solution[row] = solution[row].map(|value| value / matrix[row][row]);
    }
    solution.into_iter().map(|value| value.map(|value| value as f32)).collect()
}

/// Takes a multiple of one row of a solution from another.
fn take(solution: &mut [[f64; 2]], from: usize, row: usize, factor: f64) {
    let [x, y] = solution[row];
    solution[from] = [solution[from][0] - factor * x, solution[from][1] - factor * y];
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: Option<[f32; 2]>, [x, y]: [f32; 2]) -> bool {
        found.is_some_and(|found| {
            found[0] * x + found[1] * y > 0.95 && (found[0].hypot(found[1]) - 1.0).abs() < 1e-5
        })
    }

    #[test]
    fn strokes_are_kept_to_and_turned_between() {
        let strokes = vec![vec![[20.0, 100.0], [20.0, 20.0]], vec![[100.0, 20.0], [180.0, 20.0]]];
        let field = DirectionField::new(&strokes, (200, 120));
        assert!(near(field.at(20.0, 60.0), [0.0, -1.0]));
        assert!(near(field.at(140.0, 20.0), [1.0, 0.0]));
        assert!(near(field.at(199.0, 0.0), [1.0, 0.0]), "beyond a stroke it goes on");
        let [x, y] = field.at(60.0, 30.0).unwrap();
        assert!(x > 0.2 && y < -0.2, "between the two it turns: {x}, {y}");
    }

    #[test]
    fn long_and_repeated_strokes_are_no_trouble() {
        let long: Stroke = (0..4000).map(|i| [(i % 640) as f32, (i * 7 % 360) as f32]).collect();
        let once = vec![[10.0, 10.0], [300.0, 10.0]];
        let field = DirectionField::new(&[long, once.clone(), once], (640, 360));
        assert!(field.places.len() <= MOST);
        assert!(field.weights.iter().flatten().all(|weight| weight.is_finite()));
    }

    #[test]
    fn strokes_that_cancel_give_no_direction() {
        let strokes = vec![vec![[0.0, 0.0], [1.0, 0.0]], vec![[0.0, 100.0], [-1.0, 100.0]]];
        assert_eq!(DirectionField::new(&strokes, (10, 100)).at(0.0, 50.0), None);
    }
}
