//! Slices of many types, carved out of lent words.

use bytemuck::Pod;

/// Words of 64 bits that `count` values take.
pub(super) const fn words<T>(count: usize) -> usize {
    (count * size_of::<T>()).div_ceil(8)
}

/// The next `count` values of `memory`, which shrinks; `None` where there is too little of it.
pub(super) fn take<'a, T: Pod>(memory: &mut &'a mut [u64], count: usize) -> Option<&'a mut [T]> {
    let taken: &mut [u8] = bytemuck::cast_slice_mut(memory.split_off_mut(..words::<T>(count))?);
    // Cut first: values of three or twelve bytes need not fill their last word.
    taken.get_mut(..count * size_of::<T>()).map(bytemuck::cast_slice_mut)
}
