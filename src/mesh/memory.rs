//! Large outputs in memory: address space set aside for the most there can be, of which only what
//! is written takes memory, in huge pages where the system has them.
//!
//! First touch of new memory costs more than all arithmetic of a dense mesh, and growing a vector
//! would touch it twice.

use std::ops::{Deref, DerefMut};

use memmap2::{MmapMut, MmapOptions};

/// Linux lets a mapping begin at a huge page only where its length is a multiple of one.
const HUGE_PAGE: usize = 2 << 20;

/// The first items lie in small pages, at the end of the mapping's first huge one: to clear a huge
/// page takes longer than to make a small mesh.
const IN_SMALL_PAGES: usize = 256 << 10;
const BEGIN: usize = HUGE_PAGE - IN_SMALL_PAGES;

/// A slice that owns its memory.
#[derive(Debug)]
pub struct Buffer<T> {
    len: usize,
    memory: Memory<T>,
}

#[derive(Debug)]
enum Memory<T> {
    /// Pages of zeroes until they are written; the items from [`BEGIN`] on.
    Map(MmapMut),
    Vector(Vec<T>),
}

impl<T: bytemuck::Pod> Buffer<T> {
    /// Address space for `len` items, all zero. Nothing where the system does not give it: the
    /// caller then counts first and takes a [`Buffer::zeroed`].
    pub fn reserve(len: usize) -> Option<Self> {
        let bytes = len.checked_mul(size_of::<T>())?.checked_add(BEGIN)?;
        let bytes = bytes.checked_next_multiple_of(HUGE_PAGE)?;
        let mut options = MmapOptions::new();
        options.len(bytes).no_reserve_swap();
        let map = options.map_anon().ok()?;
        // Where the system has no huge pages, small ones serve.
        #[cfg(target_os = "linux")]
        let _ = map.advise_range(memmap2::Advice::HugePage, HUGE_PAGE, bytes - HUGE_PAGE);
        Some(Self { len, memory: Memory::Map(map) })
    }

    /// `len` items, all zero. Nothing where there is too little memory.
    pub fn zeroed(len: usize) -> Option<Self> {
        let mut items = Vec::new();
        items.try_reserve_exact(len).ok()?;
        items.resize(len, T::zeroed());
        Some(Self { len, memory: Memory::Vector(items) })
    }

    /// Keeps the first `len` items.
    pub fn truncate(&mut self, len: usize) {
        self.len = self.len.min(len);
    }
}

impl<T: bytemuck::Pod> Deref for Buffer<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match &self.memory {
            Memory::Map(map) => bytemuck::cast_slice(&map[BEGIN..][..self.len * size_of::<T>()]),
            Memory::Vector(vector) => &vector[..self.len],
        }
    }
}

impl<T: bytemuck::Pod> DerefMut for Buffer<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.memory {
            Memory::Map(map) => {
                bytemuck::cast_slice_mut(&mut map[BEGIN..][..self.len * size_of::<T>()])
            }
            Memory::Vector(vector) => &mut vector[..self.len],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn address_space_costs_nothing_until_it_is_written() {
        let mut buffer = Buffer::<[f32; 3]>::reserve(1 << 30).unwrap();
        buffer[1 << 29] = [1.0; 3];
        assert_eq!(buffer[(1 << 29)..][..2], [[1.0; 3], [0.0; 3]]);
        buffer.truncate(5);
        assert_eq!(buffer.len(), 5);
    }
}
