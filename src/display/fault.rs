//! A simulated panel that misbehaves on demand, as real ones do: late, lost, changed, forgetful.
//!
//! The loop that runs the frame must go on through all of it; tests run the same loop on this panel.

use super::{BackBuffer, Display, DisplayError, Mode, sim::Sim};
use crate::{frame::Layout, math::random::Rng};
use core::{iter::Peekable, ops::DerefMut};
use rand::{Rng as _, SeedableRng as _};

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mishap {
    /// The next present takes this many microseconds: the simulated time moves on by them, and nobody waits.
    Late(u64),
    /// The panel is lost for this many calls, the present one included; then it is back, and has forgotten its pixels.
    Lost(u64),
    /// The panel has another layout from now on. Where the panel's memory cannot hold it, it is lost for one call.
    Mode(Layout),
    /// The buffers hold unknown pixels, as after a switch from another console: their age is 0 until presented again.
    Forgotten,
}

/// A simulated panel to which `S` happens: pairs of a call's number and a mishap, numbers not decreasing.
///
/// Every [`Display::back_buffer`] and every [`Display::present`] is a call; the first is number 0. So in an untroubled run
/// the even calls ask for a back buffer and the odd ones present it, and a mishap may strike at either.
#[derive(Debug)]
pub struct Fault<M, S: Iterator<Item = (u64, Mishap)>> {
    sim: Sim<M>,
    schedule: Peekable<S>,
    /// Calls so far.
    calls: u64,
    /// Calls for which the panel stays lost.
    lost: u64,
    /// How late the next present is.
    late_us: u64,
}

impl<M: DerefMut<Target = [u8]>, S: Iterator<Item = (u64, Mishap)>> Fault<M, S> {
    /// `sim`, troubled by `schedule`: a list of one's own (`list.iter().copied()`) or a [`seeded`] one.
    pub fn new(sim: Sim<M>, schedule: impl IntoIterator<IntoIter = S>) -> Self {
        Self { sim, schedule: schedule.into_iter().peekable(), calls: 0, lost: 0, late_us: 0 }
    }

    /// The panel within: its frame, its log, its time.
    pub const fn sim(&self) -> &Sim<M> {
        &self.sim
    }

    /// The panel within, to set its time.
    pub const fn sim_mut(&mut self) -> &mut Sim<M> {
        &mut self.sim
    }

    /// Counts a call and lets happen what is due, up to the first mishap that fails the call; the others wait for the next.
    fn call(&mut self) -> Result<(), DisplayError> {
        let now = self.calls;
        self.calls += 1;
        self.stay_lost()?;
        while let Some((_, mishap)) = self.schedule.next_if(|&(at, _)| at <= now) {
            self.strike(mishap)?;
        }
        Ok(())
    }

    fn stay_lost(&mut self) -> Result<(), DisplayError> {
        match self.lost.checked_sub(1) {
            None => Ok(()),
            Some(rest) => {
                self.lost = rest;
                Err(DisplayError::Lost)
            }
        }
    }

    fn strike(&mut self, mishap: Mishap) -> Result<(), DisplayError> {
        match mishap {
            Mishap::Late(us) => self.late_us = self.late_us.saturating_add(us),
            Mishap::Forgotten => self.sim.forget(),
            Mishap::Lost(calls) => {
                self.sim.forget();
                self.lost = calls;
                self.stay_lost()?;
            }
            Mishap::Mode(layout) => {
                self.sim.set_layout(layout).map_err(|_| DisplayError::Lost)?;
                return Err(DisplayError::ModeChanged);
            }
        }
        Ok(())
    }
}

impl<M: DerefMut<Target = [u8]>, S: Iterator<Item = (u64, Mishap)>> Display for Fault<M, S> {
    fn mode(&self) -> Mode {
        self.sim.mode()
    }

    fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError> {
        self.call()?;
        self.sim.back_buffer()
    }

    fn present(&mut self) -> Result<(), DisplayError> {
        self.call()?;
        let late_us = core::mem::take(&mut self.late_us);
        self.sim.set_now(self.sim.now_us().saturating_add(late_us));
        self.sim.present()
    }
}

/// An endless schedule drawn from `seed`: a mishap of any kind every 1 to 32 calls, late ones by up to 250 ms, losses of up
/// to 16 calls, and changes to any of `layouts` (none where there are none).
pub fn seeded(seed: u64, layouts: &[Layout]) -> impl Iterator<Item = (u64, Mishap)> + '_ {
    let mut rng = Rng::seed_from_u64(seed);
    let mut below = move |limit: u64| rng.next_u64() % limit;
    let mut at = 0;
    core::iter::repeat_with(move || {
        at += 1 + below(32);
        let mishap = match below(4) {
            0 => Mishap::Late(below(250_001)),
            1 => Mishap::Lost(1 + below(16)),
            2 if !layouts.is_empty() => Mishap::Mode(layouts[below(layouts.len() as u64) as usize]),
            _ => Mishap::Forgotten,
        };
        (at, mishap)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        display::sim::{Buffering, memory_len},
        frame::{PixelFormat, Size},
    };
    use core::array::IntoIter;

    fn layout(width: u32) -> Layout {
        Layout::new(Size::new(width, 2), PixelFormat::Rgb888, None).expect("a good layout")
    }

    fn fault<const N: usize>(list: [(u64, Mishap); N]) -> Fault<Vec<u8>, IntoIter<(u64, Mishap), N>> {
        let memory = vec![0; memory_len(layout(4), Buffering::Single)];
        let sim = Sim::new(memory, layout(4), Buffering::Single, 0).expect("enough memory");
        Fault::new(sim, list)
    }

    #[test]
    fn a_lost_panel_comes_back_without_its_pixels() {
        let mut panel = fault([(3, Mishap::Lost(2))]);
        panel.back_buffer().expect("call 0");
        panel.present().expect("call 1");
        assert_eq!(panel.back_buffer().expect("call 2").age, 1);
        assert_eq!(panel.present(), Err(DisplayError::Lost), "call 3");
        assert_eq!(panel.back_buffer().expect_err("call 4"), DisplayError::Lost);
        assert_eq!(panel.back_buffer().expect("call 5").age, 0);
    }

    #[test]
    fn a_mode_that_changes_while_the_panel_is_lost_is_told_when_it_is_back() {
        let mut panel = fault([(0, Mishap::Lost(2)), (0, Mishap::Mode(layout(3)))]);
        assert_eq!(panel.back_buffer().expect_err("call 0"), DisplayError::Lost);
        assert_eq!(panel.back_buffer().expect_err("call 1"), DisplayError::Lost);
        assert_eq!(panel.mode().layout, layout(4));
        assert_eq!(panel.back_buffer().expect_err("call 2"), DisplayError::ModeChanged);
        assert_eq!(panel.mode().layout, layout(3));
    }

    #[test]
    fn a_present_makes_forgotten_pixels_known_again() {
        let mut panel = fault([(3, Mishap::Forgotten)]);
        let mut ages = [0; 4];
        for age in &mut ages {
            *age = panel.back_buffer().expect("always there").age;
            panel.present().expect("always works");
        }
        assert_eq!(ages, [0, 1, 1, 1]);
    }

    #[test]
    fn a_late_present_moves_the_simulated_time() {
        let mut panel = fault([(0, Mishap::Late(70_000))]);
        panel.sim_mut().set_now(1_000);
        panel.back_buffer().expect("call 0");
        panel.present().expect("call 1");
        assert_eq!(panel.sim().log().recent_us().last(), Some(71_000));
        panel.present().expect("call 2");
        assert_eq!(panel.sim().now_us(), 71_000, "late only once");
    }

    #[test]
    fn a_changed_mode_is_told_once_and_holds() {
        let mut panel = fault([(1, Mishap::Mode(layout(3))), (2, Mishap::Mode(layout(5)))]);
        panel.back_buffer().expect("call 0");
        assert_eq!(panel.present(), Err(DisplayError::ModeChanged));
        assert_eq!(panel.mode().layout, layout(3));
        assert_eq!(panel.back_buffer().expect_err("too wide for the memory"), DisplayError::Lost);
        assert_eq!(panel.back_buffer().expect("call 3").frame.layout(), layout(3));
    }

    #[test]
    fn a_seed_draws_the_same_trouble_again() {
        let layouts = [layout(1), layout(2)];
        let draw = |seed| seeded(seed, &layouts).take(50).collect::<Vec<_>>();
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
        assert!(draw(3).is_sorted_by_key(|&(at, _)| at));
        assert!(seeded(3, &[]).take(50).all(|(_, mishap)| !matches!(mishap, Mishap::Mode(_))));
    }
}
