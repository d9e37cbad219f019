//! Inflates a gzip file with the library that mcubes uses and throws the bytes away: what
//! `benches/peers` measures meshing against.
//!
//! ```text
//! inflate FILE.gz
//! ```

use std::error::Error;
use std::fs::File;
use std::io::{BufReader, Read};

use flate2::bufread::MultiGzDecoder;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("inflate FILE.gz")?;
    let mut inflater = MultiGzDecoder::new(BufReader::with_capacity(1 << 20, File::open(path)?));
    let mut buffer = vec![0; 1 << 19];
    let mut bytes = 0;
    loop {
        match inflater.read(&mut buffer)? {
            0 => break,
            n => bytes += n,
        }
    }
    println!("{bytes} bytes");
    Ok(())
}
