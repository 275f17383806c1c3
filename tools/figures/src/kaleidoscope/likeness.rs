//! What a picture keeps of another, and what it shows of the ranges that it is made of.

/// The side of the windows of [`ssim`], and how far they are apart.
const WINDOW: usize = 8;
const STEP: usize = 4;

/// The mean structural similarity of two lumas of `width` (Wang et al., 2004), in square windows of equal weights.
pub(super) fn ssim(a: &[u8], b: &[u8], width: usize) -> f64 {
    let height = a.len() / width;
    let (mut sum, mut count) = (0.0, 0.0);
    for y in (0..=height.saturating_sub(WINDOW)).step_by(STEP) {
        for x in (0..=width.saturating_sub(WINDOW)).step_by(STEP) {
            let rows = (y..y + WINDOW).map(|row| row * width + x..row * width + x + WINDOW);
            sum += similarity(rows.flatten().map(|i| (f64::from(a[i]), f64::from(b[i]))));
            count += 1.0;
        }
    }
    sum / count
}

fn similarity(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    /// (0.01 · 255)² and (0.03 · 255)².
    const C: [f64; 2] = [6.5025, 58.5225];
    let (mut n, mut a, mut b, mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (p, q) in pairs {
        (n, a, b) = (n + 1.0, a + p, b + q);
        (aa, bb, ab) = (aa + p * p, bb + q * q, ab + p * q);
    }
    let (a, b) = (a / n, b / n);
    let (va, vb, cov) = (aa / n - a * a, bb / n - b * b, ab / n - a * b);
    (2.0 * a * b + C[0]) * (2.0 * cov + C[1]) / ((a * a + b * b + C[0]) * (va + vb + C[1]))
}

/// The mean |gradient| of a luma of `width` across the borders of `ranges` (column, row, side), in parts of that elsewhere.
pub(super) fn border_ratio(luma: &[u8], width: usize, ranges: &[(usize, usize, usize)]) -> f64 {
    let height = luma.len() / width;
    let (mut left, mut upper) = (vec![false; luma.len()], vec![false; luma.len()]);
    for &(x, y, side) in ranges {
        (y..(y + side).min(height)).filter(|_| x < width).for_each(|row| left[row * width + x] = true);
        (x..(x + side).min(width)).filter(|_| y < height).for_each(|column| upper[y * width + column] = true);
    }
    let mut means = [(0.0, 0.0); 2];
    let mut take = |border: bool, a: u8, b: u8| {
        let (sum, count) = &mut means[usize::from(border)];
        (*sum, *count) = (*sum + f64::from(a.abs_diff(b)), *count + 1.0);
    };
    for i in 0..luma.len() {
        if i % width > 0 {
            take(left[i], luma[i], luma[i - 1]);
        }
        if i >= width {
            take(upper[i], luma[i], luma[i - width]);
        }
    }
    let [inside, border] = means.map(|(sum, count): (f64, f64)| sum / count.max(1.0));
    border / inside.max(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_like_itself_and_unlike_its_negative() {
        let luma: Vec<u8> = (0..64 * 48).map(|i: usize| (i * i % 251) as u8).collect();
        let negative: Vec<u8> = luma.iter().map(|&z| 255 - z).collect();
        assert!((ssim(&luma, &luma, 64) - 1.0).abs() < 1e-12);
        assert!(ssim(&luma, &negative, 64) < 0.0);
    }

    #[test]
    fn chequers_of_the_ranges_have_all_their_gradient_at_borders() {
        let luma: Vec<u8> = (0..64 * 32)
            .map(|i: usize| if (i % 64 / 8 + i / 64 / 8).is_multiple_of(2) { 0 } else { 200 })
            .collect();
        let ranges: Vec<_> = (0..32).map(|i| (i % 8 * 8, i / 8 * 8, 8)).collect();
        assert!(border_ratio(&luma, 64, &ranges) > 1e6);
        assert!(border_ratio(&[7; 64 * 32], 64, &ranges) < 1e-6);
    }
}
