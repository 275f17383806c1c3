//! Colours of files in linear light, and from an ICC profile's primaries to those of sRGB.
//!
//! An ICC profile of three primaries (ICC.1:2022, F.3: one curve a channel, then one matrix) or of grey (one curve) is read
//! by moxcms; its curves become tables and its matrix integers, so that the pixels themselves are treated the same way on
//! every machine. As resampling and the matrix are both linear, the matrix is applied to the few pixels of the result.
//! Profiles that need a look-up table of several dimensions (printers, scanners) are ignored.

use crate::frame::srgb;
use moxcms::{ColorProfile, DataColorSpace, ToneReprCurve};

/// Fractional bits of the matrix.
const MATRIX_BITS: u32 = 16;

/// How the samples of a file become linear light in the primaries of sRGB.
pub(super) struct Colour {
    /// The linear light of every sample value: 256 or 65,536 entries for each of red, green and blue, or once for grey.
    curves: Vec<Vec<u16>>,
    /// From the file's primaries to those of sRGB; none where they are the same.
    matrix: Option<[[i64; 3]; 3]>,
}

impl Colour {
    /// The colours of a file without a profile: sRGB.
    pub(super) fn srgb(entries: usize) -> Self {
        let light = |i| if entries == 256 { srgb::to_linear(i as u8) } else { srgb::to_linear_16(i as u16) };
        Self { curves: vec![(0..entries).map(light).collect()], matrix: None }
    }

    /// The colours of a file with the ICC profile `icc`.
    ///
    /// # Errors
    /// Why the profile cannot be used.
    pub(super) fn from_icc(icc: &[u8], grey: bool, entries: usize) -> Result<Self, String> {
        let profile = ColorProfile::new_from_slice(icc).map_err(|e| e.to_string())?;
        let tabulate = |curve: &Option<ToneReprCurve>| {
            let curve = curve.as_ref().ok_or("it has no tone curve")?;
            tabulate(curve, entries)
        };
        match (profile.color_space, grey) {
            (DataColorSpace::Gray, true) => {
                Ok(Self { curves: vec![tabulate(&profile.gray_trc)?], matrix: None })
            }
            (DataColorSpace::Rgb, false) => {
                let curves = [&profile.red_trc, &profile.green_trc, &profile.blue_trc];
                let curves = curves.into_iter().map(tabulate).collect::<Result<_, _>>()?;
                Ok(Self { curves, matrix: to_srgb_matrix(&profile)? }.or_srgb(entries))
            }
            (space, _) => Err(format!("it is for {space:?} colours, and the photo is not")),
        }
    }

    /// sRGB itself where this is sRGB within half a step of 8 bits, as most profiles in photos are: then 8-bit codes stay
    /// what they are.
    fn or_srgb(self, entries: usize) -> Self {
        let srgb = Self::srgb(entries);
        let same = self.matrix.is_none()
            && self.curves.iter().all(|curve| {
                curve.iter().zip(&srgb.curves[0]).all(|(&a, &b)| {
                    let step = srgb::to_linear(srgb::to_srgb(b).max(1))
                        - srgb::to_linear(srgb::to_srgb(b).max(1) - 1);
                    a.abs_diff(b) <= step / 2
                })
            });
        if same { srgb } else { self }
    }

    /// The curve of `channel`.
    pub(super) fn curve(&self, channel: usize) -> &[u16] {
        self.curves.get(channel).unwrap_or(&self.curves[0])
    }

    /// Linear light in the file's primaries as linear light in those of sRGB; what sRGB cannot show is clipped.
    pub(super) fn to_srgb_primaries(&self, light: [u16; 3]) -> [u16; 3] {
        let Some(matrix) = &self.matrix else { return light };
        matrix.map(|row| {
            let sum: i64 = row.iter().zip(light).map(|(&factor, value)| factor * i64::from(value)).sum();
            ((sum + (1 << (MATRIX_BITS - 1))) >> MATRIX_BITS).clamp(0, i64::from(u16::MAX)) as u16
        })
    }
}

/// A curve as a table of linear light.
fn tabulate(curve: &ToneReprCurve, entries: usize) -> Result<Vec<u16>, String> {
    let curve = curve.make_linear_evaluator().map_err(|e| e.to_string())?;
    let last = (entries - 1) as f32;
    let light = |i| (curve.evaluate_value(i as f32 / last).clamp(0.0, 1.0) * 65_535.0).round() as u16;
    Ok((0..entries).map(light).collect())
}

/// The matrix from a profile's primaries to those of sRGB; none if they are the same within what profiles are rounded to.
fn to_srgb_matrix(profile: &ColorProfile) -> Result<Option<[[i64; 3]; 3]>, String> {
    const SAME: f64 = 0.004;
    let matrix = profile.transform_matrix(&ColorProfile::new_srgb()).v;
    if !matrix.iter().flatten().all(|factor| factor.abs() < 16.0) {
        return Err("its primaries are impossible".to_owned());
    }
    let identity = |row: usize, column: usize| f64::from(u8::from(row == column));
    let same = (0..9).all(|i| (matrix[i / 3][i % 3] - identity(i / 3, i % 3)).abs() < SAME);
    let one = f64::from(1 << MATRIX_BITS);
    Ok((!same).then(|| {
        matrix.map(|row| {
            let mut row = row.map(|factor| (factor * one).round() as i64);
            // White stays white and grey grey, to the last bit, if the profile means it.
            let rest = (1 << MATRIX_BITS) - row.iter().sum::<i64>();
            if rest.abs() < (SAME * one) as i64 {
                row[1] += rest;
            }
            row
        })
    }))
}
