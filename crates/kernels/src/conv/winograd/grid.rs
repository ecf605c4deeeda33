//! How an image is cut into tiles of 2×2 outputs, and tiles into blocks.

use crate::tile::{even, wide_rows};

/// Elements of a tile: 4×4 values of the input.
pub(crate) const TILE: usize = 16;
/// Floats between the planes of a block, so that they do not all fall into the same cache sets.
const GAP: usize = 16;
/// Floats of a block that stay in cache between transform and product.
const BLOCK: usize = 96 * 1024;

/// The tiles of an image, row by row. A transformed block of them lies as [`TILE`] planes × tiles × channels.
#[derive(Debug, Clone)]
pub(crate) struct TileGrid {
    /// Rows and columns of the output.
    pub output: [usize; 2],
    /// Tiles from top to bottom and from left to right.
    tiles: [usize; 2],
    /// Most tiles of a block.
    block: usize,
}

/// Neighbouring tiles of one row.
pub(crate) struct TileRun {
    pub row: usize,
    pub column: usize,
    pub count: usize,
    /// Number of the first one in its block.
    pub number: usize,
}

impl TileGrid {
    pub fn new(output: [usize; 2], channels: usize, filters: usize) -> Self {
        let tiles = output.map(|size| size.div_ceil(2));
        // A multiple of the rows that a product holds in registers.
        let rows = wide_rows();
        let most = (BLOCK / (TILE * (channels + filters)) / rows).max(1) * rows;
        TileGrid { output, tiles, block: even(tiles[0] * tiles[1], most) }
    }

    /// Returns the rows and columns of the input with the halo that the tiles cover.
    pub fn halo(&self) -> [usize; 2] {
        self.tiles.map(|tiles| 2 * tiles + 2)
    }

    /// Returns the number of positions of the padded input.
    pub fn halo_len(&self) -> usize {
        self.halo().iter().product()
    }

    /// Returns the number of positions of the output.
    pub fn output_len(&self) -> usize {
        self.output.iter().product()
    }

    /// Returns the number of floats from one plane of a block to the next.
    pub fn plane(&self, width: usize) -> usize {
        self.block * width + GAP
    }

    /// Returns the first tile of every block, and the number of its tiles.
    pub fn blocks(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (all, most) = (self.tiles[0] * self.tiles[1], self.block);
        (0..all).step_by(most).map(move |first| (first, most.min(all - first)))
    }

    /// Returns the runs of the tiles `first..first + count` of a block, row by row.
    pub fn runs(&self, first: usize, count: usize) -> impl Iterator<Item = TileRun> + use<> {
        assert!(
            count <= self.block && first + count <= self.tiles[0] * self.tiles[1],
            "a block of tiles inside the image is needed"
        );
        let across = self.tiles[1];
        let mut tile = first;
        std::iter::from_fn(move || {
            let (row, column) = (tile / across, tile % across);
            let run = (across - column).min(first + count - tile);
            let number = tile - first;
            tile += run;
            (run > 0).then_some(TileRun { row, column, count: run, number })
        })
    }
}
